/* Property files with random faults for a library that reads them.
 *
 *     fuzz_sti FILE SCRATCH COUNT
 *
 * Each time, a few bytes of FILE are changed, repeated, removed, or the file is cut; the result is SCRATCH, which the
 * library reads and, if it accepts the file, evaluates.  Prints how many files were accepted and refused.  Exits with 1
 * if IERR is none of the standard's, a refusal has no text, or a force is not finite without an error.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { TEXT = 256, MOST = 400, LARGEST = 1 << 17 };

typedef void AnyRoad(void);
#define BEGIN \
    int *, int *, int *, int *, double *, double *, double *, double *, double *, double *, double *, int *, double *, \
        int *, double *, int *, char *
void tirefmu_sti(BEGIN, int *, AnyRoad *, int *, int *, double *, int *, char *, int *, double *, double *, double *,
                 double *, char *, int *, int *, double *, int *, double *, int *, int *, int *);

static unsigned long long seed = 88172645463325252ull;

static unsigned long draw(unsigned long n)
{
    seed ^= seed << 13, seed ^= seed >> 7, seed ^= seed << 17;
    return (unsigned long) (seed % n);
}

static void road(int *job, int *tire, double *time, double *centre, double *axes, int *id, int *n, double *parameters,
                 int *n_name, char *name, int *name_size, int *n_shape, double *shape, double *radius, double *width,
                 int *touched, double *volume, double *penetration, double *point, double *normal, double *friction,
                 int *error, char *text, int *text_size)
{
    (void) job, (void) tire, (void) time, (void) axes, (void) id, (void) n, (void) parameters, (void) n_name, (void) name;
    (void) name_size, (void) n_shape, (void) shape, (void) width, (void) volume, (void) penetration, (void) text;
    (void) text_size, (void) radius;
    memcpy(point, centre, 3 * sizeof *point);
    point[2] = 0.0;
    normal[0] = normal[1] = 0.0;
    normal[2] = *friction = 1.0;
    *touched = 1;
    *error = 0;
}

static int zero, job, tire = 1, n_states, n_parameters, n_results, n_work, n_integers, error, size = TEXT, integers[MOST];
static double now, centre[3], axes[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1}, angle, velocity[3] = {10, 0.3, 0}, turning[3], spin = 33,
    states[MOST], parameters[MOST], results[6], initial[MOST], rates[MOST], variables[MOST], work[MOST], roads[1];
static char name[TEXT], road_name[TEXT], text[TEXT];

static int call(int requested)
{
    job = requested;
    memset(text, 0, sizeof text);
    tirefmu_sti(&zero, &zero, &job, &tire, &now, centre, axes, &angle, velocity, turning, &spin, &n_states, states,
                &n_parameters, parameters, &size, name, &size, (AnyRoad *) road, &zero, &zero, roads, &size, road_name,
                &size, results, results + 3, initial, rates, text, &size, &n_results, variables, &n_work, work,
                &n_integers, integers, &error);
    if (error < 0 || error > 3 || (error && !*text)) {
        printf("IERR %d: %s\n", error, text);
        exit(1);
    }
    return error;
}

static size_t spoil(char content[], size_t n)
{
    static const char signs[] = "=[]'\"$!{}()\n\r\t .+-eEdD0123456789NAIFxX,%/\\\xff";
    int i, faults = 1 + (int) draw(6);

    for (i = 0; i < faults; i++) {
        const size_t at = draw(n), length = 1 + draw(40), from = draw(n);

        switch (draw(5)) {
        case 0:
            content[at] = (char) draw(256);
            break;
        case 1:
            content[at] = signs[draw(sizeof signs)];
            break;
        case 2: /* repeat */
            if (at + length < n && from + length < n)
                memmove(content + at, content + from, length);
            break;
        case 3: /* remove */
            if (at + length < n) {
                memmove(content + at, content + at + length, n - at - length);
                n -= length;
            }
            break;
        default:
            if (draw(20) == 0)
                n = at + 1;
        }
    }
    return n;
}

int main(int argc, char *argv[])
{
    static char original[LARGEST], content[LARGEST];
    long count, i, accepted = 0;
    size_t n, m;
    FILE *file;
    int k;

    if (argc != 4 || strlen(argv[2]) >= TEXT || !(file = fopen(argv[1], "rb")))
        return 2;
    n = fread(original, 1, sizeof original, file);
    fclose(file);
    strcpy(name, argv[2]);
    count = strtol(argv[3], NULL, 10);
    call(1);
    for (i = 0; i < count; i++) {
        memcpy(content, original, n);
        m = spoil(content, n);
        file = fopen(argv[2], "wb");
        if (!file || fwrite(content, 1, m, file) != m || fclose(file) != 0)
            return 2;
        if (call(2) > 1) {
            memcpy(states, initial, sizeof states);
            if (call(0) < 2)
                return 1; /* a tire that was not read has no forces */
            continue;
        }
        accepted++;
        memcpy(states, initial, sizeof states);
        centre[2] = 0.95 * parameters[6];
        if (call(0) < 2)
            for (k = 0; k < 6; k++)
                if (!isfinite(results[k])) {
                    printf("force %d is not finite\n", k);
                    return 1;
                }
    }
    printf("%ld accepted, %ld refused\n", accepted, count - accepted);
    return 0;
}
