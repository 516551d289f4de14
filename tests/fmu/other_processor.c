/* Forces and the serialized state of an FMU (FMI 3) on another processor.
 *
 *     other_processor TOKEN STEPS FIRST_FORCE FOREIGN WRITTEN REFERENCE:LOW:HIGH...
 *
 * Random inputs between limits, steps of 1 ms; prints three forces of each step. The state is serialized into the file
 * WRITTEN half-way and restored from these bytes before the last steps. The last line is the status of restoring the
 * bytes in the file FOREIGN, which another processor wrote.
 */
#include "fmi3Functions.h"

#include <stdio.h>
#include <stdlib.h>

enum { MAX_INPUTS = 64, FIXED = 6, FORCES = 3, MAX_BYTES = 1 << 20 };
#define STEP 1e-3

static unsigned long long seed = 1;
static fmi3Byte bytes[MAX_BYTES];

static double between(double low, double high)
{
    seed = seed * 6364136223846793005ull + 1442695040888963407ull;
    return low + (high - low) * ((double) (seed >> 11) / 9007199254740992.0);
}

static int restored(fmi3Instance tire, size_t size)
{
    fmi3FMUState state = NULL;
    int status = fmi3DeserializeFMUState(tire, bytes, size, &state);

    if (status == fmi3OK)
        status = fmi3SetFMUState(tire, state);
    fmi3FreeFMUState(tire, &state);
    return status;
}

static int through_bytes(fmi3Instance tire, const char *path)
{
    fmi3FMUState state = NULL;
    size_t size = 0;
    FILE *file = fopen(path, "wb");

    if (!file || fmi3GetFMUState(tire, &state) != fmi3OK || fmi3SerializedFMUStateSize(tire, state, &size) != fmi3OK ||
        size > MAX_BYTES || fmi3SerializeFMUState(tire, state, bytes, size) != fmi3OK)
        return 0;
    fwrite(bytes, 1, size, file);
    fclose(file);
    fmi3FreeFMUState(tire, &state);
    return restored(tire, size) == fmi3OK;
}

int main(int argc, char *argv[])
{
    fmi3ValueReference inputs[MAX_INPUTS], forces[FORCES];
    double low[MAX_INPUTS], high[MAX_INPUTS], values[MAX_INPUTS], found[FORCES], last;
    const int n_inputs = argc - FIXED, n = argc > FIXED ? atoi(argv[2]) : 0;
    fmi3Boolean flags[3];
    fmi3Instance tire;
    FILE *foreign;
    int i, j;

    if (n < 1 || n_inputs > MAX_INPUTS)
        return 2;
    for (j = 0; j < n_inputs; j++)
        if (sscanf(argv[FIXED + j], "%u:%lf:%lf", &inputs[j], &low[j], &high[j]) != 3)
            return 2;
    for (j = 0; j < FORCES; j++)
        forces[j] = (fmi3ValueReference) (atoi(argv[3]) + j);
    tire = fmi3InstantiateCoSimulation("t", argv[1], "", fmi3False, fmi3False, fmi3False, fmi3False, NULL, 0, NULL, NULL,
                                       NULL);
    if (!tire || fmi3EnterInitializationMode(tire, fmi3False, 0.0, 0.0, fmi3False, 0.0) != fmi3OK ||
        fmi3ExitInitializationMode(tire) != fmi3OK)
        return 3;
    for (i = 0; i < n; i++) {
        for (j = 0; j < n_inputs; j++)
            values[j] = between(low[j], high[j]);
        if (i == n / 2 && !through_bytes(tire, argv[5]))
            return 5;
        if (fmi3SetFloat64(tire, inputs, (size_t) n_inputs, values, (size_t) n_inputs) != fmi3OK ||
            fmi3DoStep(tire, (double) i * STEP, STEP, fmi3True, flags, flags + 1, flags + 2, &last) != fmi3OK ||
            fmi3GetFloat64(tire, forces, FORCES, found, FORCES) != fmi3OK)
            return 4;
        printf("%.17g %.17g %.17g\n", found[0], found[1], found[2]);
    }
    foreign = fopen(argv[4], "rb");
    printf("%d\n", foreign ? restored(tire, fread(bytes, 1, MAX_BYTES, foreign)) : -1);
    fmi3FreeInstance(tire);
    return 0;
}
