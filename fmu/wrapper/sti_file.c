/* The tire of the file that the host names (CHTDST).  See sti_values.h.
 *
 * TYPARR has, behind the values for the host: a mark, the width, the parameters by their order in the model, and the
 * valid ranges of the inputs.
 */
#include "sti_values.h"

#include "tir_tire.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

/* The mark of stored values. */
#define MARK 19970512.0

enum { MARK_PLACE = STI_OWN_PARAMETERS, WIDTH_PLACE, VALUES_PLACE, RANGES_PLACE = VALUES_PLACE + N_HOST_PARAMETERS };

typedef char values_fit[RANGES_PLACE + 2 * N_INPUTS == STI_PARAMETERS && STI_PARAMETERS <= MOST_PARAMETERS ? 1 : -1];

static const struct {
    int input, coefficient;
} NOMINAL_INPUTS[] = TIRE_NOMINAL_INPUTS;

/* The name of the file without blanks around it.  Returns 0 if there is none. */
static int file_name(const Call *call, char name[STI_TEXT + 1])
{
    const char *text = call->file_name;
    size_t n = *call->n_file_name > 0 ? (size_t) *call->n_file_name : 0, i;

    for (i = 0; text && i < n && i < STI_TEXT && text[i];)
        i++;
    for (n = text ? i : 0; n > 0 && text[n - 1] == ' ';)
        n--;
    for (i = 0; i < n && text[i] == ' ';)
        i++;
    memcpy(name, text ? text + i : "", n - i);
    name[n - i] = 0;
    return n > i;
}

/* The last part of a path. */
static const char *short_name(const char path[])
{
    const char *letter, *found = path;

    for (letter = path; *letter; letter++)
        if ((*letter == '/' || *letter == '\\') && letter[1])
            found = letter + 1;
    return found;
}

static void fill(const double stored[], Tire *tire)
{
    size_t i;

    memcpy(tire->starts + FIRST_PARAMETER, stored + VALUES_PLACE, N_HOST_PARAMETERS * sizeof *stored);
    memcpy(tire->ranges, stored + RANGES_PLACE, sizeof tire->ranges);
    for (i = 0; NOMINAL_INPUTS[i].input >= 0; i++)
        tire->starts[FIRST_INPUT + NOMINAL_INPUTS[i].input] = stored[VALUES_PLACE + NOMINAL_INPUTS[i].coefficient];
}

int sti_take_values(Call *call, Tire *tire)
{
    double *stored = call->parameters;
    char name[STI_TEXT + 1], problem[STI_TEXT], line[2 * STI_TEXT + 4];
    TirTire read;

    stored[MARK_PLACE] = 0.0;
    if (!file_name(call, name)) {
        sti_write(call, "no tire file is named: this library reads one");
        return FATAL;
    }
    memset(&read, 0, sizeof read);
    memcpy(read.parameters, tire->starts + FIRST_PARAMETER, sizeof read.parameters);
    if (!tir_read(name, &read, problem, sizeof problem)) {
        snprintf(line, sizeof line, "%s: %s", short_name(name), problem);
        sti_write(call, line);
        return FATAL;
    }
    stored[MARK_PLACE] = MARK;
    stored[WIDTH_PLACE] = read.width;
    memcpy(stored + VALUES_PLACE, read.parameters, sizeof read.parameters);
    memcpy(stored + RANGES_PLACE, read.ranges, sizeof read.ranges);
    fill(stored, tire);
    return GOOD;
}

int sti_stored_values(Call *call, Tire *tire)
{
    const double *stored = call->parameters;
    size_t i;

    if (stored[MARK_PLACE] != MARK) {
        sti_write(call, "the tire is not initialized, or TYPARR has been changed");
        return FATAL;
    }
    for (i = VALUES_PLACE; i < STI_PARAMETERS; i++)
        if (i < RANGES_PLACE ? !isfinite(stored[i]) : isnan(stored[i])) {
            sti_write(call, "TYPARR has been changed: a value is not finite");
            return FATAL;
        }
    fill(stored, tire);
    return GOOD;
}

double sti_width(const Call *call) { return call->parameters[WIDTH_PLACE]; }

const char *sti_title(const Call *call, char title[STI_TITLE])
{
    char name[STI_TEXT + 1];

    if (!file_name(call, name))
        return TIRE_TITLE;
    snprintf(title, STI_TITLE, "%s, %s", TIRE_TITLE, short_name(name));
    return title;
}
