/* Times of single steps of an FMU (FMI 3), as a real-time host sees them.
 *
 *     step_times TOKEN STEPS FIRST_RESULT N_RESULTS REFERENCE:LOW:HIGH...
 *
 * Each step sets the given inputs to random values between limits, advances by 1 ms, and reads the results.  Prints the
 * median, the 99.99th percentile and the longest time in microseconds of processor time of the thread, so that other
 * programs count as little as possible.
 */
#define _POSIX_C_SOURCE 199309L
#include "fmi3Functions.h"

#include <stdio.h>
#include <stdlib.h>
#include <time.h>

enum { MAX_VARIABLES = 64, FIXED = 5 };
#define STEP 1e-3

static unsigned long long seed = 1;

static double between(double low, double high)
{
    seed = seed * 6364136223846793005ull + 1442695040888963407ull;
    return low + (high - low) * ((double) (seed >> 11) / 9007199254740992.0);
}

static int by_size(const void *a, const void *b)
{
    const double x = *(const double *) a, y = *(const double *) b;
    return (x > y) - (x < y);
}

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return 1e6 * (double) t.tv_sec + 1e-3 * (double) t.tv_nsec;
}

int main(int argc, char *argv[])
{
    fmi3ValueReference inputs[MAX_VARIABLES], results[MAX_VARIABLES];
    double low[MAX_VARIABLES], high[MAX_VARIABLES], values[MAX_VARIABLES], found[MAX_VARIABLES], last, *times;
    const long n = argc > FIXED ? strtol(argv[2], NULL, 10) : 0;
    const int n_inputs = argc - FIXED, n_results = argc > FIXED ? atoi(argv[4]) : 0;
    fmi3Boolean flags[3];
    fmi3Instance tire;
    long i;
    int j;

    if (n < 1 || n_inputs > MAX_VARIABLES || n_results > MAX_VARIABLES || !(times = malloc((size_t) n * sizeof *times)))
        return 2;
    for (j = 0; j < n_inputs; j++)
        if (sscanf(argv[FIXED + j], "%u:%lf:%lf", &inputs[j], &low[j], &high[j]) != 3)
            return 2;
    for (j = 0; j < n_results; j++)
        results[j] = (fmi3ValueReference) (atoi(argv[3]) + j);
    tire = fmi3InstantiateCoSimulation("t", argv[1], "", fmi3False, fmi3False, fmi3False, fmi3False, NULL, 0, NULL, NULL,
                                       NULL);
    if (!tire || fmi3EnterInitializationMode(tire, fmi3False, 0.0, 0.0, fmi3False, 0.0) != fmi3OK ||
        fmi3ExitInitializationMode(tire) != fmi3OK)
        return 3;
    for (i = 0; i < n; i++) {
        double begin;
        for (j = 0; j < n_inputs; j++)
            values[j] = between(low[j], high[j]);
        begin = now();
        if (fmi3SetFloat64(tire, inputs, (size_t) n_inputs, values, (size_t) n_inputs) != fmi3OK ||
            fmi3DoStep(tire, (double) i * STEP, STEP, fmi3True, flags, flags + 1, flags + 2, &last) != fmi3OK ||
            fmi3GetFloat64(tire, results, (size_t) n_results, found, (size_t) n_results) != fmi3OK)
            return 4;
        times[i] = now() - begin;
    }
    qsort(times, (size_t) n, sizeof *times, by_size);
    printf("%.3f %.3f %.3f\n", times[n / 2], times[n - 1 - n / 10000], times[n - 1]);
    fmi3FreeInstance(tire);
    free(times);
    return 0;
}
