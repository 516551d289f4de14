/* A host that calls an FMU with hub inputs at random: values of every size, steps, events, saved states, derivatives.
 *
 *     fuzz_hub TOKEN CALLS END_OF_INPUTS NUMBER_OF_VALUES HAS_EVENT_MODE
 *
 * Prints how many calls were accepted and refused.  Exits with 1 if an accepted call returns a value that is not finite, or
 * if a refused call changes the state.
 */
#include "fmi3Functions.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MOST = 2000 };

static unsigned long long seed = 1;

static double uniform(void)
{
    seed = seed * 6364136223846793005ull + 1442695040888963407ull;
    return (double) (seed >> 11) / 9007199254740992.0;
}

/* Mostly of the size of a wheel's motion; also huge, tiny, zero and not finite. */
static double wild(void)
{
    static const double special[] = {0.0, 1e300, -1e300, 1e-300, NAN, INFINITY, -1.0, 1e9};
    const double kind = uniform();

    if (kind < 0.1)
        return special[(int) (uniform() * 8.0)];
    return (2.0 * uniform() - 1.0) * (kind < 0.4 ? 1.0 : kind < 0.7 ? 30.0 : kind < 0.9 ? 0.3 : 1e6);
}

static unsigned char before[sizeof(double) * 4 * MOST], after[sizeof before];

static size_t bytes_of(fmi3Instance tire, unsigned char bytes[])
{
    fmi3FMUState state = NULL;
    size_t size = 0;

    fmi3GetFMUState(tire, &state);
    fmi3SerializedFMUStateSize(tire, state, &size);
    if (size > sizeof before || fmi3SerializeFMUState(tire, state, bytes, size) != fmi3OK)
        exit(2);
    fmi3FreeFMUState(tire, &state);
    return size;
}

int main(int argc, char *argv[])
{
    const long calls = argc == 6 ? strtol(argv[2], NULL, 10) : 0;
    const unsigned end_of_inputs = argc == 6 ? (unsigned) atoi(argv[3]) : 0;
    const int n = argc == 6 ? atoi(argv[4]) : 0, events = argc == 6 ? atoi(argv[5]) : 0;
    fmi3Instance tire = fmi3InstantiateCoSimulation("t", argv[1], "", fmi3False, fmi3False, events != 0, fmi3True, NULL, 0,
                                                    NULL, NULL, NULL);
    long accepted = 0, refused = 0, handled = 0, i;
    fmi3FMUState saved = NULL;
    double time = 0.0;

    if (!tire || n > MOST)
        return 2;
    fmi3EnterInitializationMode(tire, fmi3False, 0.0, 0.0, fmi3False, 0.0);
    fmi3ExitInitializationMode(tire);
    fmi3GetFMUState(tire, &saved);
    for (i = 0; i < calls; i++) {
        const double choice = uniform();
        const fmi3ValueReference a = (fmi3ValueReference) (uniform() * n);
        const fmi3ValueReference b = (fmi3ValueReference) (uniform() * (choice < 0.55 ? end_of_inputs : (unsigned) n));
        const double one = 1.0;
        const size_t size = bytes_of(tire, before);
        fmi3Boolean flags[5];
        double value = 0.0, last;
        fmi3Status status;

        if (choice < 0.03) { /* an array, or none, with a right or wrong number of values */
            const fmi3ValueReference array = 0x10000u + (fmi3ValueReference) (uniform() * 13.0);
            double many[9];
            int k;

            for (k = 0; k < 9; k++)
                many[k] = wild();
            status = fmi3SetFloat64(tire, &array, 1, many, uniform() < 0.2 ? 9 : 3);
        } else if (choice < 0.6) {
            value = wild();
            status = fmi3SetFloat64(tire, &b, 1, &value, 1);
            value = 0.0;
        } else if (choice < 0.85) {
            status = fmi3GetFloat64(tire, &a, 1, &value, 1);
        } else if (choice < 0.95) {
            const double step = 0.02 * uniform();
            status = fmi3DoStep(tire, time, step, fmi3True, flags, flags + 1, flags + 2, &last);
            time = last;
        } else if (choice < 0.96) {
            status = fmi3EnterEventMode(tire);
        } else if (choice < 0.97) {
            status = fmi3UpdateDiscreteStates(tire, flags, flags + 1, flags + 2, flags + 3, flags + 4, &last);
        } else if (choice < 0.98) {
            status = fmi3EnterStepMode(tire);
            handled += status == fmi3OK;
        } else if (choice < 0.995) {
            status = fmi3GetDirectionalDerivative(tire, &a, 1, &b, 1, &one, 1, &value, 1);
        } else {
            status = fmi3SetFMUState(tire, saved);
            time = 0.0;
        }
        if (status == fmi3OK || status == fmi3Warning) {
            accepted++;
            if (!isfinite(value)) {
                printf("call %ld: value reference %u is %g\n", i, a, value);
                return 1;
            }
        } else {
            refused++;
            if (bytes_of(tire, after) != size || memcmp(before, after, size) != 0) {
                printf("call %ld was refused and has changed the state\n", i);
                return 1;
            }
        }
    }
    fmi3FreeFMUState(tire, &saved);
    fmi3FreeInstance(tire);
    printf("%ld accepted, %ld refused, %ld returns from event mode\n", accepted, refused, handled);
    return 0;
}
