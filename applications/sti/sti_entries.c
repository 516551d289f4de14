/* The subroutines of the Standard Tyre Interface.  See sti.h.
 *
 *     tirefmu_sti_   Fortran, with the road of Adams: contact point, normal, friction
 *     tirefmu_sti    the same in C, as MotionSolve calls it: the length of each text is the next argument
 *     dtyre_         Fortran, with the road of STI 1.2: height and slopes
 *
 * A Fortran caller passes the lengths of texts behind the last argument.  The subroutines do not read them: the texts
 * have 256 characters.  They pass them to the host's road.
 */
#include "sti.h"

#include "wheel_kinematics.h"

#include <string.h>

#if defined _WIN32
#define STI_EXPORT __declspec(dllexport)
#else
#define STI_EXPORT __attribute__((visibility("default")))
#endif

enum { HIGH_ROAD_PROPERTIES = 1 };

/* The arguments of a tire up to the name of its file, and from the road's to that of its file. */
#define TIRE_ARGUMENTS                                                                                               \
    const int *ndev, const int *iswtch, const int *jobflg, const int *idtyre, const double *time, const double *dis, \
        const double *tramat, const double *angtwc, const double *vel, const double *omega, const double *omegar,    \
        int *ndeqvr, const double *deqvar, int *ntypar, double *typarr, const int *nchtds, const char *chtdst
#define ROAD_ARGUMENTS int *idroad, int *nropar, double *ropar, int *nchrds, char *chrdst
#define RESULT_ARGUMENTS double *forces, double *torque, double *deqini, double *deqder, char *tyrmod
#define WORK_ARGUMENTS \
    int *nvars, double *varinf, int *nwork, double *wrkarr, int *niwork, int *iwrkar, int *ierr

/* A call with these arguments. */
#define CALL_OF_ARGUMENTS                                                                                            \
    {                                                                                                                \
        .job = jobflg, .tire = idtyre, .time = time, .position = dis, .axes = tramat, .velocity = vel,               \
        .turning = omega, .spin = omegar, .n_states = ndeqvr, .states = deqvar, .n_parameters = ntypar,              \
        .parameters = typarr, .host_road = (void (*)(void)) road, .road_id = idroad, .n_road = nropar,               \
        .road_parameters = ropar, .n_road_name = nchrds, .road_name = chrdst, .force = forces, .moment = torque,     \
        .initial = deqini, .rates = deqder, .text = tyrmod, .n_results = nvars, .results = varinf, .n_work = nwork,  \
        .n_integers = niwork, .integers = iwrkar                                                                     \
    }
/* Arguments that no equation reads. */
#define UNUSED_ARGUMENTS (void) ndev, (void) iswtch, (void) angtwc, (void) wrkarr, (void) nchtds, (void) chtdst

/* ---------------------------------------------------------------- results */

/* Layout of HTire, of which CarSim's has the first ten values and the deflection. */
static void show_results(const Instance *self, double results[STI_RESULTS])
{
    const State *state = &self->state;
    const double *hub = state->hub.results;
    static const unsigned places[] = CONTACT_FORCES;
    size_t i;

    for (i = 0; i < N_OUTPUTS; i++)
        results[places[i]] = state->values[FIRST_OUTPUT + i];
    results[2] = hub[LOAD_RESULT];
    results[6] = state->contact.inputs[ALPHA];
    results[7] = state->contact.sense * state->contact.inputs[KAPPA];
    results[8] = hub[WHEEL_MOTION_gamma];
    memcpy(results + 25, hub + WHEEL_MOTION_c_x, 3 * sizeof *results);
    results[43] = hub[DEFLECTION_RESULT];
    results[47] = hub[WHEEL_MOTION_V_x];
    results[49] = hub[WHEEL_MOTION_wheel_speed];
}

/* Positions of TNO's layout. */
static void show_in_tno_order(const Instance *self, double results[STI_RESULTS])
{
    const double *hub = self->state.hub.results;

    results[1] = self->state.contact.sense * self->state.contact.inputs[KAPPA];
    results[9] = hub[LOAD_RESULT] > 0.0 ? hub[DEFLECTION_RESULT] : 0.0;
    results[11] = hub[RADIUS_RESULT];
    memcpy(results + 12, hub + WHEEL_MOTION_c_x, 3 * sizeof *results);
}

/* ---------------------------------------------------------------- roads */

typedef void AdamsRoad(const int *job, const int *tire, const double *time, const double *place, const double *axes,
                       int *id, int *n, double *parameters, int *n_name, char *name, const int *n_shape,
                       const double *shape, const double *radius, const double *width, int *touched, double *volume,
                       double *penetration, double *point, double *normal, double *friction, int *error, char *text,
                       size_t name_size, size_t text_size);
typedef void MotionSolveRoad(const int *job, const int *tire, const double *time, const double *place,
                             const double *axes, int *id, int *n, double *parameters, int *n_name, char *name,
                             int *name_size, const int *n_shape, const double *shape, const double *radius,
                             const double *width, int *touched, double *volume, double *penetration, double *point,
                             double *normal, double *friction, int *error, char *text, int *text_size);
typedef void HeightRoad(const double *time, const double *place, const int *wants_slopes, const int *job, const int *tire,
                        int *id, int *n, double *parameters, int *n_name, char *name, const int *n_surface, int *kind,
                        double *z, double *slopes, double *curvatures, int *n_derivatives, double *surface, int *error,
                        size_t name_size);

/* The tire is a disk of its width: it has no points of a cross section. */
static const int N_SHAPE = 0;
static const double SHAPE[2] = {0.0, 0.0};

static int find_adams_road(Call *call, const double place[3], Road *road)
{
    double volume = 0.0, penetration = 0.0;
    const double radius = *call->job == INQUIRE ? 0.0 : sti_radius(call), width = TIRE_WIDTH;
    char text[STI_TEXT];
    int text_size = STI_TEXT, error = GOOD;

    memset(text, ' ', sizeof text);
    if (call->padded)
        ((AdamsRoad *) call->host_road)(call->job, call->tire, call->time, place, call->axes, call->road_id,
                                        call->n_road, call->road_parameters, call->n_road_name, call->road_name,
                                        &N_SHAPE, SHAPE, &radius, &width, &road->touched, &volume, &penetration,
                                        road->point, road->normal, &road->friction, &error, text, STI_TEXT, STI_TEXT);
    else
        ((MotionSolveRoad *) call->host_road)(call->job, call->tire, call->time, place, call->axes, call->road_id,
                                              call->n_road, call->road_parameters, call->n_road_name, call->road_name,
                                              call->road_name_size, &N_SHAPE, SHAPE, &radius, &width,
                                              &road->touched, &volume, &penetration, road->point, road->normal,
                                              &road->friction, &error, text, &text_size);
    if (error > WARNING) {
        text[sizeof text - 1] = 0;
        sti_write(call, text);
    }
    return error;
}

/* The jobs of this road: 1 before the simulation, 0, and 99 after it. */
static int find_high_road(Call *call, const double place[3], Road *road)
{
    static const int wants_slopes = 1, n_surface = HIGH_ROAD_PROPERTIES;
    const int job = *call->job == INITIALIZE ? 1 : *call->job == FINAL ? 99 : 0;
    double slopes[2] = {0.0, 0.0}, curvatures[3], surface[HIGH_ROAD_PROPERTIES] = {1.0};
    int kind = 0, n_derivatives = 0, error = GOOD;

    if (job == 0 && *call->job != NORMAL && *call->job != SUCCESSFUL_STEP && *call->job != DIFFERENCING)
        return GOOD;
    memcpy(road->point, place, sizeof road->point);
    ((HeightRoad *) call->host_road)(call->time, place, &wants_slopes, &job, call->tire, call->road_id, call->n_road,
                                     call->road_parameters, call->n_road_name, call->road_name, &n_surface, &kind,
                                     &road->point[2], slopes, curvatures, &n_derivatives, surface, &error, STI_TEXT);
    road->touched = 1;
    road->normal[0] = n_derivatives > 0 ? -slopes[0] : 0.0;
    road->normal[1] = n_derivatives > 0 ? -slopes[1] : 0.0;
    road->normal[2] = 1.0;
    road->friction = surface[0] > 0.0 ? surface[0] : 1.0; /* hosts write 0 where they have no friction */
    if (error > WARNING)
        sti_write(call, "the host's road reports an error");
    return error;
}

/* ---------------------------------------------------------------- subroutines */

STI_EXPORT void tirefmu_sti_(TIRE_ARGUMENTS, AdamsRoad *road, ROAD_ARGUMENTS, RESULT_ARGUMENTS, WORK_ARGUMENTS)
{
    Call call = CALL_OF_ARGUMENTS;

    UNUSED_ARGUMENTS;
    call.text_size = STI_TEXT;
    call.padded = 1;
    call.find_road = find_adams_road;
    call.show = show_results;
    *ierr = sti_call(&call);
}

STI_EXPORT void tirefmu_sti(TIRE_ARGUMENTS, const int *chtdst_size, MotionSolveRoad *road, ROAD_ARGUMENTS,
                            int *chrdst_size, RESULT_ARGUMENTS, const int *tyrmod_size, WORK_ARGUMENTS)
{
    Call call = CALL_OF_ARGUMENTS;

    UNUSED_ARGUMENTS;
    (void) chtdst_size;
    call.text_size = *tyrmod_size > 0 ? (size_t) *tyrmod_size : 0;
    call.road_name_size = chrdst_size;
    call.find_road = find_adams_road;
    call.show = show_results;
    *ierr = sti_call(&call);
}

STI_EXPORT void dtyre_(TIRE_ARGUMENTS, HeightRoad *road, ROAD_ARGUMENTS, RESULT_ARGUMENTS, WORK_ARGUMENTS)
{
    Call call = CALL_OF_ARGUMENTS;

    UNUSED_ARGUMENTS;
    call.text_size = STI_TEXT;
    call.padded = 1;
    call.find_road = find_high_road;
    call.by_height = 1;
    call.show = show_in_tno_order;
    *ierr = sti_call(&call);
}
