/* What is known of every value, and access to the values of a state.  See state.h. */
#include "state.h"

#include <math.h>

static const char *const NAMES[] = VALUE_NAMES;
static const double NOMINAL[] = NOMINAL_VALUES;
const unsigned char value_kinds[] = VALUE_KINDS;
static const int EXTRA[] = EXTRAS;
const signed char value_directions[] = VALUE_DIRECTIONS;
/* By output of the model: its sign for a wheel that rolls backward. */
static const signed char BACKWARD[] = BACKWARD_SIGNS;

/* The generated header and the model's code must have the same number of values. */
#define HAS(table, n) (sizeof(table) / sizeof *(table) == (n) ? 1 : -1)
typedef char names_are_complete[HAS(NAMES, N_VALUES)];
typedef char sizes_are_complete[HAS(NOMINAL, N_VALUES)];
typedef char kinds_are_complete[HAS(value_kinds, N_VALUES)];
typedef char directions_are_complete[HAS(value_directions, N_VALUES)];
typedef char extras_are_complete[HAS(EXTRA, N_EXTRAS)];

const char *value_name(unsigned reference) { return NAMES[reference]; }

/* Not by two comparisons: without states one of them is always true or false. */
int value_is_state(unsigned reference)
{
    unsigned state;

    if (SPIN && reference == SPIN_VALUE)
        return 1;
    for (state = FIRST_STATE; state < FIRST_DERIVATIVE; state++)
        if (reference == state)
            return 1;
    return 0;
}

double value_scale(const State *state, unsigned reference)
{
    const double size = fabs(state->values[reference]);
    const double nominal = NOMINAL[reference] > 0.0 ? NOMINAL[reference] : 1.0;

    return size > nominal || value_kind(reference) == PARAMETER ? (size > 0.0 ? size : 1.0) : nominal;
}

int value_shows(unsigned reference) { return EXTRA[reference - FIRST_EXTRA]; }

double output_sign(double sense, size_t output) { return sense < 0.0 ? BACKWARD[output] : 1.0; }

void state_set(State *state, unsigned reference, double value)
{
    Continuous *continuous = &state->continuous;

    state->values[reference] = value;
#if SPIN
    if (reference == SPIN_VALUE)
        return;
#endif
#ifdef DISTANCE
    if (reference == FIRST_DERIVATIVE - 1)
        continuous->distance = value;
    else
#endif
#if N_MEMORY > 0
    if (reference >= FIRST_MEMORY)
        continuous->memory[reference - FIRST_MEMORY] = host_value(state, reference);
    else
#endif
        continuous->lagging[reference - FIRST_STATE] = host_value(state, reference);
}
