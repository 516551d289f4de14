/* Many tires, long runs: the FMU (FMI 3) that a library of a path has, called as a host calls it.
 *
 *     many_tires LIBRARY TOKEN OTHER_LIBRARY OTHER_TOKEN COPY INSTANCES STEPS FIRST_FORCE REFERENCE:LOW:HIGH...
 *
 * COPY is a copy of LIBRARY.  Inputs are random between limits; references are the same in all libraries.  Prints name and value of:
 *   bytes per instance of both; microseconds per step of both, in turns; the median of their ratios
 *   bytes that the allocator holds after STEPS steps of one instance beyond those before, per step
 *   the largest difference of the forces of an instance that is saved and restored at random steps from one that is not
 *   the largest difference of the forces of two copies of the library in one process
 *   the slowest step and the median, microseconds of processor time
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <malloc.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "fmi3Functions.h"

enum { MAX_INPUTS = 64, FORCES = 3, FIXED = 7, BLOCKS = 41, BLOCK = 500 };
#define STEP 1e-3

typedef struct {
    fmi3InstantiateCoSimulationTYPE *instantiate;
    fmi3EnterInitializationModeTYPE *enter;
    fmi3ExitInitializationModeTYPE *leave;
    fmi3SetFloat64TYPE *set;
    fmi3GetFloat64TYPE *get;
    fmi3DoStepTYPE *step;
    fmi3GetFMUStateTYPE *save;
    fmi3SetFMUStateTYPE *restore;
    fmi3FreeInstanceTYPE *end;
    const char *token;
} Library;

static fmi3ValueReference inputs[MAX_INPUTS], forces[FORCES];
static double low[MAX_INPUTS], high[MAX_INPUTS];
static int n_inputs;

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return 1e6 * (double) t.tv_sec + 1e-3 * (double) t.tv_nsec;
}

static double between(unsigned long long *seed, double a, double b)
{
    *seed = *seed * 6364136223846793005ull + 1442695040888963407ull;
    return a + (b - a) * ((double) (*seed >> 11) / 9007199254740992.0);
}

static void *entry(void *library, const char *name)
{
    void *found = library ? dlsym(library, name) : NULL;
    if (!found) {
        fprintf(stderr, "%s\n", dlerror());
        exit(2);
    }
    return found;
}

static Library opened(const char *path, const char *token)
{
    void *library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    Library found = {entry(library, "fmi3InstantiateCoSimulation"), entry(library, "fmi3EnterInitializationMode"),
                     entry(library, "fmi3ExitInitializationMode"), entry(library, "fmi3SetFloat64"),
                     entry(library, "fmi3GetFloat64"), entry(library, "fmi3DoStep"), entry(library, "fmi3GetFMUState"),
                     entry(library, "fmi3SetFMUState"), entry(library, "fmi3FreeInstance"), token};
    return found;
}

static fmi3Instance started(const Library *library)
{
    fmi3Instance tire = library->instantiate("t", library->token, "", fmi3False, fmi3False, fmi3False, fmi3False, NULL, 0,
                                             NULL, NULL, NULL);
    if (!tire || library->enter(tire, fmi3False, 0.0, 0.0, fmi3False, 0.0) != fmi3OK || library->leave(tire) != fmi3OK)
        exit(3);
    return tire;
}

static void advance(const Library *library, fmi3Instance tire, long i, unsigned long long *seed, double found[FORCES])
{
    double values[MAX_INPUTS], last;
    fmi3Boolean flags[3];
    int j;

    for (j = 0; j < n_inputs; j++)
        values[j] = between(seed, low[j], high[j]);
    if (library->set(tire, inputs, (size_t) n_inputs, values, (size_t) n_inputs) != fmi3OK ||
        library->step(tire, (double) i * STEP, STEP, fmi3True, &flags[0], &flags[1], &flags[2], &last) != fmi3OK ||
        library->get(tire, forces, FORCES, found, FORCES) != fmi3OK)
        exit(4);
}

static int by_size(const void *a, const void *b)
{
    const double x = *(const double *) a, y = *(const double *) b;
    return (x > y) - (x < y);
}

static double larger(double largest, const double a[FORCES], const double b[FORCES])
{
    int j;

    for (j = 0; j < FORCES; j++)
        largest = fmax(largest, fabs(a[j] - b[j]) / (1.0 + fabs(b[j])));
    return largest;
}

static void measure_memory(const Library libraries[2], long n)
{
    static const char *const names[] = {"bytes_per_instance", "other_bytes_per_instance"};
    int k;
    long i;

    for (k = 0; k < 2; k++) {
        const size_t before = mallinfo2().uordblks + mallinfo2().hblkhd;
        fmi3Instance *tires = malloc((size_t) n * sizeof *tires);

        for (i = 0; i < n; i++)
            tires[i] = started(&libraries[k]);
        printf("%s %.0f\n", names[k],
               (double) (mallinfo2().uordblks + mallinfo2().hblkhd - before) / (double) n - (double) sizeof *tires);
        for (i = 0; i < n; i++)
            libraries[k].end(tires[i]);
        free(tires);
    }
}

static void measure_steps(const Library libraries[2])
{
    double ratios[BLOCKS], sums[2] = {0.0, 0.0}, found[FORCES];
    fmi3Instance tires[2] = {started(&libraries[0]), started(&libraries[1])};
    unsigned long long seeds[2] = {1, 1};
    int b, turn;
    long i;

    for (b = 0; b < BLOCKS; b++) {
        double times[2];

        for (turn = 0; turn < 2; turn++) {
            const int k = (turn + b) % 2;
            const double begin = now();

            for (i = 0; i < BLOCK; i++)
                advance(&libraries[k], tires[k], (long) b * BLOCK + i, &seeds[k], found);
            times[k] = (now() - begin) / BLOCK;
            sums[k] += times[k] / BLOCKS;
        }
        ratios[b] = times[0] / times[1];
    }
    qsort(ratios, BLOCKS, sizeof *ratios, by_size);
    printf("step %.3f\nother_step %.3f\nratio %.3f\n", sums[0], sums[1], ratios[BLOCKS / 2]);
}

/* One instance runs alone; a second one is saved and restored at random; a third one is that of a copy of the library. */
static void run_long(const Library *library, const Library *copy, long n)
{
    fmi3Instance plain = started(library), restored = started(library), other = started(copy);
    unsigned long long seed = 2, restored_seed = 2, other_seed = 2, chance = 3;
    double *times = malloc((size_t) n * sizeof *times), found[FORCES], again[FORCES], state_error = 0.0, copy_error = 0.0;
    fmi3FMUState state = NULL;
    size_t before = 0;
    long i;

    for (i = 0; i < n; i++) {
        const unsigned long long earlier = restored_seed;
        double begin = now();

        advance(library, plain, i, &seed, found);
        times[i] = now() - begin;
        if (between(&chance, 0.0, 1.0) < 0.01) { /* a step that is taken back */
            library->save(restored, &state);
            advance(library, restored, i, &restored_seed, again);
            library->restore(restored, state);
            restored_seed = earlier;
        }
        advance(library, restored, i, &restored_seed, again);
        state_error = larger(state_error, again, found);
        advance(copy, other, i, &other_seed, again);
        copy_error = larger(copy_error, again, found);
        if (i == n / 10)
            before = mallinfo2().uordblks;
    }
    printf("bytes_per_step %g\n", ((double) mallinfo2().uordblks - (double) before) / (0.9 * (double) n));
    printf("state_error %g\ncopy_error %g\n", state_error, copy_error);
    qsort(times, (size_t) n, sizeof *times, by_size);
    printf("median %.3f\nslowest %.3f\n", times[n / 2], times[n - 1]);
    free(times);
}

int main(int argc, char *argv[])
{
    int j;

    if (argc < FIXED + 2)
        return 2;
    n_inputs = argc - FIXED - 2;
    for (j = 0; j < n_inputs && j < MAX_INPUTS; j++)
        if (sscanf(argv[FIXED + 2 + j], "%u:%lf:%lf", &inputs[j], &low[j], &high[j]) != 3)
            return 2;
    for (j = 0; j < FORCES; j++)
        forces[j] = (fmi3ValueReference) (atoi(argv[FIXED + 1]) + j);
    {
        const Library libraries[2] = {opened(argv[1], argv[2]), opened(argv[3], argv[4])};
        const Library copy = opened(argv[5], argv[2]);

        measure_memory(libraries, strtol(argv[6], NULL, 10));
        measure_steps(libraries);
        run_long(&libraries[0], &copy, strtol(argv[7], NULL, 10));
    }
    return 0;
}
