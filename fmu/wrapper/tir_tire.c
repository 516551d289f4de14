/* A tire from a property file.  See tir_tire.h. */
#include "tir_tire.h"

#include "tir_entries.h"

#include <math.h>
#include <string.h>

#define COUNT(table) (sizeof(table) / sizeof *(table))

typedef struct {
    int by_default, relaxes;
    int demanded; /* by an input: 1 if this library has the input, -1 if not; 0 for other effects */
    int owned;    /* where the coefficients that only this effect reads begin in OWNED; -1 ends them */
} Effect;

static const double MISSING[N_COEFFICIENTS] = TIR_MISSING;
static const double NEUTRAL[N_COEFFICIENTS] = TIR_NEUTRAL;
static const double STANDARD[N_COEFFICIENTS] = TIR_STANDARD; /* if no value is given or assumed */
static const char ASSUMED[N_COEFFICIENTS] = TIR_ASSUMED;     /* the field assumes a value */
static const char *const EFFECT_NAMES[] = TIR_EFFECT_NAMES;
static const Effect EFFECTS[] = TIR_EFFECTS;
static const int OWNED[] = TIR_OWNED;
static const int NEEDED[] = TIR_NEEDED; /* the scale of the model's own relaxation lengths, what they need; -1 */
static const struct {
    int input, low, high;
} RANGES[] = TIR_RANGES;

static int has_effect(const Reading *reading, size_t i)
{
    return reading->has_effects ? reading->has[i] : EFFECTS[i].by_default;
}

/* Whether the file names an effect of relaxation, or gives its coefficients and names none. */
static int has_relaxation(const Reading *reading, const double parameters[])
{
    size_t i;
    const int *owned;

    for (i = 0; i < COUNT(EFFECTS); i++) {
        if (!EFFECTS[i].relaxes)
            continue;
        if (has_effect(reading, i))
            return 1;
        for (owned = OWNED + EFFECTS[i].owned; !reading->has_effects && *owned >= 0; owned++)
            if (parameters[*owned] != NEUTRAL[*owned])
                return 1;
    }
    return 0;
}

/* Whether the file gives a coefficient, or the field assumes a value. */
static int is_given(const Reading *reading, int n)
{
    if (!reading->known[n])
        return ASSUMED[n];
    return !(reading->assumed[n] && reading->found[n] == STANDARD[n]);
}

/* A tire without relaxation has the lengths of its model, if it has values of the coefficients that they need. */
static void add_lengths(const Reading *reading, double parameters[])
{
    const int *needed;

    if (NEEDED[0] < 0 || has_relaxation(reading, parameters))
        return;
    for (needed = NEEDED + 1; *needed >= 0; needed++)
        if (!is_given(reading, *needed))
            return;
    parameters[NEEDED[0]] = 1.0;
}

static int check_effects(Reading *reading)
{
    size_t i;

    for (i = 0; i < COUNT(EFFECTS); i++)
        if (EFFECTS[i].demanded && has_effect(reading, i) != (EFFECTS[i].demanded > 0))
            return tir_refuse(reading, "only %s has the effect %s: export a library of this tire",
                          has_effect(reading, i) ? "the tire" : "this library", EFFECT_NAMES[i]);
    return 1;
}

static int find_coefficients(Reading *reading, double parameters[])
{
    size_t i;
    const int *owned;

    for (i = 0; i < N_COEFFICIENTS; i++)
        parameters[i] = reading->known[i] ? reading->found[i] : MISSING[i];
    for (i = 0; i < COUNT(EFFECTS) && reading->has_effects; i++)
        for (owned = OWNED + EFFECTS[i].owned; !reading->has[i] && *owned >= 0; owned++)
            parameters[*owned] = NEUTRAL[*owned];
    if (!reading->known[OWN_UNLOADED_RADIUS] || !(parameters[OWN_UNLOADED_RADIUS] > 0.0))
        return tir_refuse(reading, "a tire needs UNLOADED_RADIUS > 0");
    if (!reading->known[OWN_FNOMIN] || !(parameters[OWN_FNOMIN] > 0.0))
        return tir_refuse(reading, "a tire needs FNOMIN > 0");
    add_lengths(reading, parameters);
    return 1;
}

/* ---------------------------------------------------------------- wheel and vertical force */

/* A value of the file, whether the model has it or not. */
static double known_value(const Reading *reading, const double parameters[], int target, double otherwise)
{
    if (target < N_COEFFICIENTS)
        return parameters[target];
    return reading->known[target] && reading->found[target] >= 0.0 ? reading->found[target] : otherwise;
}

static void find_vertical(const Reading *reading, double parameters[])
{
    const double radius = parameters[OWN_UNLOADED_RADIUS];
    const double rim = known_value(reading, parameters, TIR_RIM_RADIUS, 0.0);
    const double offset = known_value(reading, parameters, TIR_BOTTOM_OFFST, 0.0);

    if (OWN_VERTICAL_DAMPING >= N_COEFFICIENTS)
        parameters[OWN_VERTICAL_DAMPING] =
            known_value(reading, parameters, TIR_VERTICAL_DAMPING, TIR_STANDARD_DAMPING);
    if (OWN_BOTTOM_STIFF >= N_COEFFICIENTS)
        parameters[OWN_BOTTOM_STIFF] = known_value(reading, parameters, TIR_BOTTOM_STIFF, 0.0);
    if (OWN_BOTTOM_RADIUS >= N_COEFFICIENTS)
        parameters[OWN_BOTTOM_RADIUS] = known_value(reading, parameters, TIR_BOTTOM_RADIUS,
                                                    rim > 0.0 ? rim + offset : TIR_STANDARD_BOTTOM * radius);
#ifdef OWN_VERTICAL_STIFFNESS
    if (OWN_VERTICAL_STIFFNESS >= N_COEFFICIENTS) {
        const double standard = parameters[OWN_FNOMIN] / (TIR_STANDARD_DEFLECTION * radius);
        const double stiffness = known_value(reading, parameters, TIR_VERTICAL_STIFFNESS, standard);
        parameters[OWN_VERTICAL_STIFFNESS] = stiffness > 0.0 ? stiffness : standard;
    }
#endif
    parameters[DEFAULT_SIGMA] = TIR_STANDARD_LENGTH * radius;
#ifdef TIR_LOW_SPEED
    if (parameters[TIR_LOW_SPEED] >= TIR_LEAST_LOW_SPEED)
        parameters[LOW_SPEED] = parameters[TIR_LOW_SPEED];
    else
#endif
        parameters[LOW_SPEED] = TIR_STANDARD_LOW_SPEED;
}

static int find_ranges(Reading *reading, TirTire *tire)
{
    size_t i;

    for (i = 0; i < COUNT(RANGES); i++) {
        const int low = RANGES[i].low, high = RANGES[i].high;
        double *range = tire->ranges[RANGES[i].input];

        if (low < N_COEFFICIENTS && is_given(reading, low) && is_given(reading, high)) {
            range[0] = tire->parameters[low];
            range[1] = tire->parameters[high];
        } else if (low >= N_COEFFICIENTS && reading->known[low] && reading->known[high]) {
            range[0] = reading->found[low];
            range[1] = reading->found[high];
        }
        if (!(range[0] <= range[1]))
            return tir_refuse(reading, "a valid range of the tire ends at %g before it begins at %g", range[1], range[0]);
    }
    return 1;
}

int tir_read(const char path[], TirTire *tire, char problem[], size_t size)
{
    Reading reading;
    size_t i;

    memset(&reading, 0, sizeof reading);
    reading.problem = problem;
    reading.size = size;
    for (i = 0; i < N_INPUTS; i++) {
        tire->ranges[i][0] = -HUGE_VAL;
        tire->ranges[i][1] = HUGE_VAL;
    }
    if (!tir_read_entries(&reading, path) || !check_effects(&reading) || !find_coefficients(&reading, tire->parameters))
        return 0;
    find_vertical(&reading, tire->parameters);
    tire->width = known_value(&reading, tire->parameters, TIR_WIDTH, 0.0);
    return find_ranges(&reading, tire);
}
