/* A multibody program of one wheel, which calls a tire by the Standard Tyre Interface.
 *
 *     sti_host ENTRY JOBS [FAULT] < MOTION > RESULTS
 *
 * ENTRY is the subroutine (tirefmu_sti_, tirefmu_sti, dtyre_), JOBS the values of JOBFLG before the simulation, such as
 * 1,2,11,6.  A row of MOTION has time, DIS, TRAMAT, VEL, OMEGA and OMEGAR: 20 numbers.  The program integrates the states
 * of the tire by Euler's explicit method from row to row, and writes FORCES, TORQUE, states, derivatives and VARINF.
 * The road is a slope with waves.  Exits with IERR if a call fails; the text of the tire is on the error output.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { TEXT = 256, ROW = 20, MOST = 400 };

/* Fortran passes the lengths of texts behind the last argument. */
typedef void AnyRoad(void);
#define BEGIN \
    int *, int *, int *, int *, double *, double *, double *, double *, double *, double *, double *, int *, double *, \
        int *, double *, int *, char *
#define ROAD int *, int *, double *, int *, char *
#define RESULT double *, double *, double *, double *, char *
#define WORK int *, double *, int *, double *, int *, int *, int *
void tirefmu_sti_(BEGIN, AnyRoad *, ROAD, RESULT, WORK, size_t, size_t, size_t);
void dtyre_(BEGIN, AnyRoad *, ROAD, RESULT, WORK, size_t, size_t, size_t);
void tirefmu_sti(BEGIN, int *, AnyRoad *, ROAD, int *, RESULT, int *, WORK);

static double height(const double at[2], double slopes[2], double *friction)
{
    slopes[0] = 0.02 + 0.008 * cos(0.8 * at[0]);
    slopes[1] = 0.01;
    *friction = 0.8 + 0.2 * tanh(at[1]);
    return 0.02 * at[0] + 0.01 * sin(0.8 * at[0]) + 0.01 * at[1];
}

static int road_calls, failing;

/* The plane at the wheel centre; touched if the centre is less than the unloaded radius above it. */
static void place_plane(const double *centre, double radius, int *touched, double *point, double *normal, double *friction,
                        int *error)
{
    double slopes[2];

    road_calls++;
    memcpy(point, centre, 2 * sizeof *point);
    point[2] = height(centre, slopes, friction);
    normal[0] = -slopes[0] / hypot(1.0, hypot(slopes[0], slopes[1]));
    normal[1] = -slopes[1] / hypot(1.0, hypot(slopes[0], slopes[1]));
    normal[2] = 1.0 / hypot(1.0, hypot(slopes[0], slopes[1]));
    *touched = (centre[2] - point[2]) * normal[2] < radius;
    *error = failing ? 2 : 0;
}

static void adams_road(int *job, int *tire, double *time, double *centre, double *axes, int *id, int *n,
                       double *parameters, int *n_name, char *name, int *n_shape, double *shape, double *radius,
                       double *width, int *touched, double *volume, double *penetration, double *point, double *normal,
                       double *friction, int *error, char *text, size_t name_size, size_t text_size)
{
    (void) job, (void) tire, (void) time, (void) axes, (void) id, (void) n, (void) parameters, (void) n_name;
    (void) n_shape, (void) shape, (void) width, (void) volume, (void) penetration;
    if (name_size != TEXT || text_size != TEXT || strncmp(name, "road.rdf", 8) != 0)
        exit(10);
    memcpy(text, "no road here", 12);
    place_plane(centre, *radius, touched, point, normal, friction, error);
}

static void motionsolve_road(int *job, int *tire, double *time, double *centre, double *axes, int *id, int *n,
                             double *parameters, int *n_name, char *name, int *name_size, int *n_shape, double *shape,
                             double *radius, double *width, int *touched, double *volume, double *penetration,
                             double *point, double *normal, double *friction, int *error, char *text, int *text_size)
{
    (void) job, (void) tire, (void) time, (void) axes, (void) id, (void) n, (void) parameters, (void) n_name;
    (void) n_shape, (void) shape, (void) width, (void) volume, (void) penetration;
    if (*name_size != TEXT || *text_size != TEXT || strcmp(name, "road.rdf") != 0)
        exit(10);
    strcpy(text, "no road here");
    place_plane(centre, *radius, touched, point, normal, friction, error);
}

static void height_road(double *time, double *at, int *wants_slopes, int *job, int *tire, int *id, int *n,
                        double *parameters, int *n_name, char *name, int *n_surface, int *kind, double *z, double *slopes,
                        double *curvatures, int *n_derivatives, double *surface, int *error, size_t name_size)
{
    (void) time, (void) job, (void) tire, (void) id, (void) n, (void) parameters, (void) n_name, (void) curvatures;
    if (name_size != TEXT || *wants_slopes != 1 || *n_surface < 1 || strncmp(name, "road.rdf", 8) != 0)
        exit(10);
    road_calls++;
    *kind = 2;
    *z = height(at, slopes, surface);
    *n_derivatives = 1;
    *error = failing ? 2 : 0;
}

/* What a host has for a tire. */
static int output_unit = 6, mode = 14, job, tire_id = 3, n_states, n_parameters, n_tire_name = TEXT, road_id = 1, n_road = 1,
           n_road_name = 8, n_results, n_work, n_integers, error, size = TEXT, integers[MOST];
static double row[ROW], angle, states[MOST], parameters[MOST], road_parameters[1], results[6], initial[MOST], rates[MOST],
    variables[MOST], work[MOST];
static char tire_name[TEXT], road_name[TEXT], text[TEXT + 1];
static const char *entry;

static void call(int requested)
{
#define FIRST                                                                                                      \
    &output_unit, &mode, &job, &tire_id, row, row + 1, row + 4, &angle, row + 13, row + 16, row + 19, &n_states, states, \
        &n_parameters, parameters, &n_tire_name, tire_name
#define PLACE &road_id, &n_road, road_parameters, &n_road_name, road_name
#define FOUND results, results + 3, initial, rates, text
#define LAST &n_results, variables, &n_work, work, &n_integers, integers, &error
    job = requested;
    if (strcmp(entry, "tirefmu_sti_") == 0)
        tirefmu_sti_(FIRST, (AnyRoad *) adams_road, PLACE, FOUND, LAST, TEXT, TEXT, TEXT);
    else if (strcmp(entry, "dtyre_") == 0)
        dtyre_(FIRST, (AnyRoad *) height_road, PLACE, FOUND, LAST, TEXT, TEXT, TEXT);
    else
        tirefmu_sti(FIRST, &size, (AnyRoad *) motionsolve_road, PLACE, &size, FOUND, &size, LAST);
    if (error) {
        fprintf(stderr, "%d %d: %s\n", job, error, text);
        if (error > 1)
            exit(error);
    }
}

static void print(const double values[], int n)
{
    int i;
    for (i = 0; i < n; i++)
        printf("%.17g ", values[i]);
}

static int read_row(double to[ROW])
{
    int i, n = 0;
    for (i = 0; i < ROW; i++)
        n += scanf("%lf", to + i) == 1;
    return n == ROW;
}

int main(int argc, char *argv[])
{
    double before, unknown = 0.0;
    char *jobs;
    int i;

    if (argc < 3 || !read_row(row))
        return 11;
    entry = argv[1];
    memset(tire_name, ' ', TEXT);
    memset(road_name, strcmp(entry, "tirefmu_sti") == 0 ? 0 : ' ', TEXT);
    memcpy(road_name, "road.rdf", 8);
    for (jobs = argv[2]; *jobs; jobs += *jobs == ',')
        call((int) strtol(jobs, &jobs, 10));
    fprintf(stderr, "%d states, %d parameters, %d results, %d %d: %.*s\n", n_states, n_parameters, n_results, n_work,
            n_integers, 40, text);
    if (argc == 4) { /* a fault that the tire has to report */
        if (strcmp(argv[3], "road") == 0)
            failing = 1;
        else if (strcmp(argv[3], "job") == 0)
            call(7);
        else if (strcmp(argv[3], "states") == 0)
            n_states--;
        else if (strcmp(argv[3], "results") == 0)
            n_results = 10;
        else if (strcmp(argv[3], "number") == 0)
            row[2] = unknown / unknown;
    }
    memcpy(states, initial, (size_t) n_states * sizeof *states);
    do {
        call(5); /* a differencing call changes nothing */
        call(0);
        print(results, 6);
        print(states, n_states);
        print(rates, n_states);
        print(variables, n_results);
        puts("");
        before = row[0];
        if (!read_row(row))
            break;
        for (i = 0; i < n_states; i++)
            states[i] += (row[0] - before) * rates[i];
    } while (1);
    call(99);
    fprintf(stderr, "%d road calls\n", road_calls);
    return 0;
}
