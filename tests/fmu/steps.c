/* Many steps of an FMU (FMI 3) with random inputs, as a real-time host sees them.
 *
 *     steps TOKEN STEPS FIRST_FORCE REFERENCE:LOW:HIGH...
 *
 * Each step sets the inputs to random values between limits, advances by 1 ms, and reads three forces.  Prints the
 * median, the 99.99th percentile and the longest time in microseconds of processor time of the thread, so that other
 * programs count as little as possible; how often memory was allocated or a file opened at instantiation and in the
 * steps (0 unless COUNTS is defined; then link with --wrap of the functions below); and the largest force.
 */
#include "fmi3Functions.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

enum { MAX_INPUTS = 64, FIXED = 4, FORCES = 3 };
#define STEP 1e-3

static long calls;

#ifdef COUNTS
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
#endif

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
    fmi3ValueReference inputs[MAX_INPUTS], forces[FORCES];
    double low[MAX_INPUTS], high[MAX_INPUTS], values[MAX_INPUTS], found[FORCES], last, largest = 0.0, *times;
    const long n = argc > FIXED ? strtol(argv[2], NULL, 10) : 0;
    const int n_inputs = argc - FIXED;
    fmi3Boolean flags[3];
    fmi3Instance tire;
    long before, i;
    int j;

    if (n < 1 || n_inputs > MAX_INPUTS || !(times = malloc((size_t) n * sizeof *times)))
        return 2;
    for (j = 0; j < n_inputs; j++)
        if (sscanf(argv[FIXED + j], "%u:%lf:%lf", &inputs[j], &low[j], &high[j]) != 3)
            return 2;
    for (j = 0; j < FORCES; j++)
        forces[j] = (fmi3ValueReference) (atoi(argv[3]) + j);
    before = calls;
    tire = fmi3InstantiateCoSimulation("t", argv[1], "", fmi3False, fmi3False, fmi3False, fmi3False, NULL, 0, NULL, NULL,
                                       NULL);
    if (!tire || fmi3EnterInitializationMode(tire, fmi3False, 0.0, 0.0, fmi3False, 0.0) != fmi3OK ||
        fmi3ExitInitializationMode(tire) != fmi3OK)
        return 3;
    before = calls - before;
    calls = 0;
    for (i = 0; i < n; i++) {
        double begin;
        for (j = 0; j < n_inputs; j++)
            values[j] = between(low[j], high[j]);
        begin = now();
        if (fmi3SetFloat64(tire, inputs, (size_t) n_inputs, values, (size_t) n_inputs) != fmi3OK ||
            fmi3DoStep(tire, (double) i * STEP, STEP, fmi3True, flags, flags + 1, flags + 2, &last) != fmi3OK ||
            fmi3GetFloat64(tire, forces, FORCES, found, FORCES) != fmi3OK)
            return 4;
        times[i] = now() - begin;
        for (j = 0; j < FORCES; j++)
            largest = fmax(largest, fabs(found[j]));
    }
    i = calls;
    qsort(times, (size_t) n, sizeof *times, by_size);
    printf("%.3f %.3f %.3f %ld %ld %g\n", times[n / 2], times[n - 1 - n / 10000], times[n - 1], before, i, largest);
    fmi3FreeInstance(tire);
    free(times);
    return 0;
}
