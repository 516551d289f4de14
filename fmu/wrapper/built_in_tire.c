/* The tire for which the binary was compiled.  See tire.h. */
#include "instance.h"

#include "tire_values.h"

#include <float.h>
#include <math.h>
#include <string.h>

static const double START[] = START_VALUES;
static const double RANGES[][2] = INPUT_RANGES;

/* The generated header and the model's code must have the same number of values. */
#define HAS(table, n) (sizeof(table) / sizeof *(table) == (n) ? 1 : -1)
typedef char starts_are_complete[HAS(START, N_VALUES)];
typedef char ranges_are_complete[HAS(RANGES, N_INPUTS)];
typedef char texts_fit[sizeof INSTANTIATION_TOKEN <= TOKEN_SIZE && sizeof RELAXATION_NOTE <= NOTE_SIZE ? 1 : -1];

const char *tire_find(const char *resources, Tire *tire)
{
    (void) resources;
    memset(tire, 0, sizeof *tire);
    memcpy(tire->token, INSTANTIATION_TOKEN, sizeof INSTANTIATION_TOKEN);
    memcpy(tire->note, RELAXATION_NOTE, sizeof RELAXATION_NOTE);
    tire->count = N_VALUES;
    memcpy(tire->starts, START, sizeof START);
    memcpy(tire->ranges, RANGES, sizeof RANGES);
    return NULL;
}
