/* A host that counts allocations and opened files during steps; link it with --wrap of the functions below.
 *
 *     quiet_step TOKEN STEPS FIRST_FORCE REFERENCE:LOW:HIGH...
 *
 * Prints how often they were called at instantiation and in the steps, and the largest force.
 */
#include "fmi3Functions.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

static long calls;

void *__real_malloc(size_t size);
void *__real_calloc(size_t n, size_t size);
void *__real_realloc(void *old, size_t size);
void __real_free(void *memory);
FILE *__real_fopen(const char *path, const char *mode);

void *__wrap_malloc(size_t size) { return calls++, __real_malloc(size); }
void *__wrap_calloc(size_t n, size_t size) { return calls++, __real_calloc(n, size); }
void *__wrap_realloc(void *old, size_t size) { return calls++, __real_realloc(old, size); }
void __wrap_free(void *memory) { calls++, __real_free(memory); }
FILE *__wrap_fopen(const char *path, const char *mode) { return calls++, __real_fopen(path, mode); }

static unsigned long long seed = 1;

static double uniform(void)
{
    seed = seed * 6364136223846793005ull + 1442695040888963407ull;
    return (double) (seed >> 11) / 9007199254740992.0;
}

int main(int argc, char *argv[])
{
    const long steps = strtol(argv[2], NULL, 10);
    const fmi3ValueReference first = (fmi3ValueReference) atoi(argv[3]);
    const fmi3ValueReference forces[6] = {first, first + 1, first + 2, first + 3, first + 4, first + 5};
    fmi3Instance tire = fmi3InstantiateCoSimulation("t", argv[1], "", fmi3False, fmi3False, fmi3False, fmi3False, NULL, 0,
                                                    NULL, NULL, NULL);
    double values[6], largest = 0.0, last;
    fmi3Boolean flags[3];
    long before, i;
    int k;

    if (!tire || fmi3EnterInitializationMode(tire, fmi3False, 0.0, 0.0, fmi3False, 0.0) != fmi3OK ||
        fmi3ExitInitializationMode(tire) != fmi3OK)
        return 1;
    before = calls;
    for (i = 0; i < steps; i++) {
        for (k = 4; k < argc; k++) {
            unsigned reference;
            double low, high, value;

            if (sscanf(argv[k], "%u:%lf:%lf", &reference, &low, &high) != 3)
                return 1;
            value = low + (high - low) * uniform();
            if (fmi3SetFloat64(tire, &reference, 1, &value, 1) != fmi3OK)
                return 1;
        }
        if (fmi3DoStep(tire, 1e-3 * (double) i, 1e-3, fmi3True, flags, flags + 1, flags + 2, &last) != fmi3OK ||
            fmi3GetFloat64(tire, forces, 6, values, 6) != fmi3OK)
            return 1;
        for (k = 0; k < 3; k++)
            largest = fmax(largest, fabs(values[k]));
    }
    printf("%ld %ld %g\n", before, calls - before, largest);
    fmi3FreeInstance(tire);
    return 0;
}
