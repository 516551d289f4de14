/* A call of a tire by the Standard Tyre Interface (TYDEX-STI 1.4).
 *
 * sti_entries.c has the subroutines that hosts call; each puts its arguments into a `Call`.  sti.c evaluates it with the
 * equations of an FMU with hub inputs for Model Exchange: the host integrates the states.  Nothing is stored between
 * two calls except in the host's array IWRKAR, so that any number of tires and threads may call.
 */
#ifndef STI_H
#define STI_H

#include "instance.h"
#include "sti_tire.h"

/* Values of JOBFLG. */
enum {
    NO_EVALUATION = -1,
    NORMAL = 0,
    INQUIRE = 1,
    INITIALIZE = 2,
    REINITIALIZE = 3,
    SUCCESSFUL_STEP = 4,
    DIFFERENCING = 5,
    INITIAL_CONDITIONS = 6, /* MotionSolve */
    ACTUAL_SIZES = 11,      /* MotionSolve */
    FINAL = 99
};

/* Values of IERR. */
enum { GOOD = 0, WARNING = 1, DO_NOT_USE = 2, FATAL = 3 };

/* Lengths of the arrays, and the indices of values in them. */
enum {
    STI_TEXT = 256,
    STI_PARAMETERS = 16,
    STI_RESULTS = 75,
    STI_WORK = 1,
    STI_INTEGERS = 1,
    UNLOADED_RADIUS_OF_HOST = 6, /* as in TNO's order of TYPARR */
    STIFFNESS_OF_HOST = 14,
    DAMPING_OF_HOST = 15,
    WARNED = 0
};

/* The road below the tire: a plane. */
typedef struct {
    int touched;
    double point[3], normal[3], friction;
} Road;

typedef struct Call Call;

/* Calls the host's road for a place, global, m.  Returns its IERR. */
typedef int FindRoad(Call *call, const double place[3], Road *road);

struct Call {
    const int *job, *tire;
    const double *time, *position, *axes, *velocity, *turning, *spin;
    int *n_states;
    const double *states;
    int *n_parameters;
    double *parameters;
    void (*host_road)(void);
    int *road_id, *n_road;
    double *road_parameters;
    int *n_road_name;
    char *road_name;
    int *road_name_size;
    double *force, *moment, *initial, *rates;
    char *text;
    size_t text_size;
    int padded; /* with blanks as in Fortran; otherwise terminated as in C */
    int *n_results;
    double *results;
    int *n_work, *n_integers;
    int *integers;

    FindRoad *find_road;
    /* The road has a height and a slope at every place: the plane is the one at the contact point. */
    int by_height;
    /* Writes VARINF. */
    void (*show)(const Instance *self, double results[STI_RESULTS]);
};

/* Do the job of a call.  Returns IERR. */
int sti_call(Call *call);
/* Write a text of the tire. */
void sti_write(Call *call, const char *text);
/* The unloaded radius, m. */
double sti_radius(const Call *call);

#endif
