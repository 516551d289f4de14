/* The tire from resources/tire_values.bin, which is untrusted.  See tire.h.
 *
 * The file is the structure `Contents`: little-endian, of fixed size.  `structure` identifies the variables for which
 * this binary was compiled.
 */
#include "instance.h"

#include "resource_file.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#define FILE_NAME "tire_values.bin"

static const char FORMAT[8] = "TIREFMU2";

typedef struct {
    char format[sizeof FORMAT];
    char structure[sizeof STRUCTURE - 1];
    Tire tire;
} Contents;

typedef char contents_have_no_gaps
    [sizeof(Contents) == sizeof FORMAT + sizeof STRUCTURE - 1 + TOKEN_SIZE + NOTE_SIZE + sizeof(uint64_t) +
                             (N_VALUES + 2 * N_INPUTS) * sizeof(double)
         ? 1
         : -1];

/* ---------------------------------------------------------------- contents */

/* Text of an array that ends within it.  '%' is not allowed: FMI 2's logger would take the text for a format. */
static int is_text(const char text[], size_t size)
{
    size_t i;

    for (i = 0; i < size && text[i]; i++)
        if (text[i] < ' ' || text[i] > '~' || text[i] == '%')
            return 0;
    return i < size;
}

static const char *check(const Tire *tire)
{
    size_t i;

    if (!is_text(tire->token, TOKEN_SIZE) || !is_text(tire->note, NOTE_SIZE))
        return FILE_NAME " is damaged: a text is malformed";
    if (tire->count < FIRST_EXTRA || tire->count > N_VALUES)
        return FILE_NAME " is damaged: the number of values is wrong";
    for (i = 0; i < N_VALUES; i++)
        if (!isfinite(tire->starts[i]))
            return FILE_NAME " is damaged: a value is not finite";
    for (i = 0; i < N_INPUTS; i++)
        if (!(tire->ranges[i][0] <= tire->ranges[i][1])) /* NaN too */
            return FILE_NAME " is damaged: a valid range is empty";
    return NULL;
}

const char *tire_find(const char *resources, Tire *tire)
{
    Contents contents;
    FILE *file = resource_open(resources, FILE_NAME);
    size_t size;
    int more;

    if (!file)
        return FILE_NAME " in the resources cannot be opened, or the host does not pass their path";
    size = fread(&contents, 1, sizeof contents, file);
    more = size == sizeof contents && fgetc(file) != EOF;
    fclose(file);
    if (size != sizeof contents || more)
        return FILE_NAME " is damaged: its size is wrong";
    if (memcmp(contents.format, FORMAT, sizeof FORMAT) != 0 ||
        memcmp(contents.structure, STRUCTURE, sizeof contents.structure) != 0)
        return FILE_NAME " is not for this binary";
    *tire = contents.tire;
    return check(tire);
}
