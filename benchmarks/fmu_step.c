/* CPU time of a tire FMU in a host (set inputs, step, read forces), compared with the model functions alone.
 *
 * Linked with the sources of the FMU (FMI 3), with the compiler options of the package. Prints two times in ns.
 */
#define _POSIX_C_SOURCE 200809L
#include "model_config.h"
#include "tire_values.h"

#include "fmi3Functions.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

enum { REPETITIONS = 21, STEPS = 20000 };

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return 1e9 * (double) t.tv_sec + (double) t.tv_nsec;
}

static int ascending(const void *a, const void *b)
{
    const double x = *(const double *) a, y = *(const double *) b;
    return (x > y) - (x < y);
}

int main(void)
{
    static const double start[] = START_VALUES;
    const double *parameters = start + 1 + N_HOST_INPUTS + N_OUTPUTS;
    double inputs[N_INPUTS] = {0.0}; /* inputs that the host does not set are last and 0: no turn slip */
    double forces[N_OUTPUTS], bare[REPETITIONS], whole[REPETITIONS], sum = 0.0, t0;
    unsigned input_references[N_HOST_INPUTS], output_references[N_OUTPUTS];
    bool event, terminate, early;
    double reached;
    long step = 0;
    int i, k;
    fmi3Instance tire = fmi3InstantiateCoSimulation("tire", INSTANTIATION_TOKEN, NULL, 0, 0, 0, 0, NULL, 0, NULL, NULL,
                                                    NULL);

    if (!tire || fmi3EnterInitializationMode(tire, 0, 0.0, 0.0, 0, 0.0) || fmi3ExitInitializationMode(tire))
        return 1;
    for (i = 0; i < N_HOST_INPUTS; i++) {
        input_references[i] = 1 + (unsigned) i;
        inputs[i] = start[1 + i];
    }
    for (i = 0; i < N_OUTPUTS; i++)
        output_references[i] = 1 + N_HOST_INPUTS + (unsigned) i;
    for (k = 0; k < REPETITIONS; k++) {
        t0 = now();
        for (i = 0; i < STEPS; i++) {
            inputs[0] = 0.1 * (i & 255) / 256.0;
            inputs[1] = 0.2 * (i & 63) / 64.0 - 0.1;
            model_forces(inputs, parameters, forces);
            sum += forces[0];
        }
        bare[k] = (now() - t0) / STEPS;
        t0 = now();
        for (i = 0; i < STEPS; i++, step++) {
            inputs[0] = 0.1 * (i & 255) / 256.0;
            inputs[1] = 0.2 * (i & 63) / 64.0 - 0.1;
            fmi3SetFloat64(tire, input_references, N_HOST_INPUTS, inputs, N_HOST_INPUTS);
            fmi3DoStep(tire, 0.001 * (double) step, 0.001, 1, &event, &terminate, &early, &reached);
            fmi3GetFloat64(tire, output_references, N_OUTPUTS, forces, N_OUTPUTS);
            sum += forces[0];
        }
        whole[k] = (now() - t0) / STEPS;
    }
    fmi3FreeInstance(tire);
    qsort(bare, REPETITIONS, sizeof *bare, ascending);
    qsort(whole, REPETITIONS, sizeof *whole, ascending);
    printf("%.1f %.1f\n", bare[REPETITIONS / 2], whole[REPETITIONS / 2]);
    return isfinite(sum) ? 0 : 1;
}
