/* One tire instance for both FMI versions: its values, its modes and the allowed calls.
 *
 * Hand-written C99.  fmi2.c and fmi3.c translate calls; the checks of allowed calls are here only.
 *
 * A function either completes, or it rejects the call and changes nothing.
 *   STATUS_DISCARD  a value is not finite or outside its declared limits, or a result would not be finite
 *   STATUS_ERROR    the standard or this FMU does not allow the call, or a pointer is NULL
 * The host's logger receives one line for each rejected call.
 */
#ifndef INSTANCE_H
#define INSTANCE_H

#include <stddef.h>

#include "model_config.h"

/* A value reference is an index into one array of doubles. */
enum {
    TIME = 0,
    FIRST_INPUT = 1,
    FIRST_COMPUTED = FIRST_INPUT + N_HOST_INPUTS - N_COMPUTED_INPUTS, /* motion of the wheel, for hub inputs */
    FIRST_OUTPUT = FIRST_INPUT + N_HOST_INPUTS,
    FIRST_PARAMETER = FIRST_OUTPUT + N_OUTPUTS,
    FIRST_STATE = FIRST_PARAMETER + N_HOST_PARAMETERS,
    FIRST_MEMORY = FIRST_STATE + LAGS * 2 + TWISTS, /* the states of effects; the distance is behind them */
    FIRST_DERIVATIVE = FIRST_STATE + N_STATES,
    N_CONTINUOUS = N_STATES + SPIN, /* of Model Exchange: the spin is the last one */
    FIRST_EXTRA = FIRST_DERIVATIVE + N_CONTINUOUS,
    N_VALUES = FIRST_EXTRA + N_EXTRAS,
    SPIN_VALUE = SPIN ? FIRST_INPUT + SPIN_PLACE : 0,
    SPIN_RATE = FIRST_DERIVATIVE + N_STATES
};

#include "road.h"
#include "tire.h"

/* The kind of a value: a stored one can be set until initialization ends; a hidden one is not visible to the host and
   has its start value. */
enum { INDEPENDENT, INPUT, OUTPUT, PARAMETER, LOCAL, STORED, HIDDEN };

/* The source of an extra output; see EXTRAS in model_config.h. */
enum {
    FRICTION_USE,
    KAPPA_GIVEN,
    ALPHA_GIVEN,
    ALPHA_LAGGED,
    BRAKE_EVENT,
    FIRST_QUANTITY,
    FIRST_PATH = FIRST_QUANTITY + N_QUANTITIES,
    FIRST_HUB = FIRST_PATH + N_MEMORY
};

/* What an FMU with hub inputs computes: the results of the generated function wheel_motion, of which the first ones are
   MOTION, then load, deflection, the forces of the generated function hub_wrench, and the torque of the brake. */
enum {
    N_MOTION_RESULTS = 5,
    RADIUS_RESULT = N_MOTION_RESULTS,
    RADIUS_RATE_RESULT,
    LOAD_RESULT = N_MOTION_RESULTS + 5,
    DEFLECTION_RESULT,
    WRENCH_RESULT,
    BRAKE_RESULT = WRENCH_RESULT + 12,
    N_HUB_RESULTS
};

/* The same numbers in FMI 2 and FMI 3. */
typedef enum { STATUS_OK = 0, STATUS_WARNING = 1, STATUS_DISCARD = 2, STATUS_ERROR = 3 } Status;

typedef enum { CO_SIMULATION, MODEL_EXCHANGE } Kind;

/* After initialization, Co-Simulation is in STEPPING; Model Exchange is in EVENT or CONTINUOUS. */
typedef enum { INSTANTIATED, INITIALIZATION, STEPPING, EVENT, CONTINUOUS, TERMINATED } Mode;

/* The lagged quantities: kappa, tan(alpha) and, if the wheel can turn on the spot, the twist of its contact patch. */
enum { LONGITUDINAL, LATERAL, N_SLIPS, TWIST = N_SLIPS, N_LAGGING = N_SLIPS + TWISTS };

/* What the rates of lagged quantities depend on in addition to the model: |V|, sliding velocities, the yaw rate, the
   default relaxation length, and the lagged quantities; then the results for the hub at constant contact forces, and
   the change of the spin, of its rate by torques and inertia, and of the margin of a brake that holds. */
enum {
    ROLLING,
    SLIDING,
    YAWING = SLIDING + N_SLIPS,
    DEFAULT_LENGTH,
    LAGGING,
    HUB_CHANGE = LAGGING + N_LAGGING,
    SPIN_MOVED = HUB_CHANGE + HUB * N_HUB_RESULTS,
    SPIN_PUSHED,
    SPIN_MARGIN,
    N_MOTION = SPIN ? SPIN_MARGIN + 1 : SPIN_MOVED
};

/* The kinematics at the contact point; see contact.h. */
typedef struct {
    double inputs[N_INPUTS];
    double target[N_SLIPS];
    double sliding[N_SLIPS];
    double bounds[N_SLIPS];
    double friction[N_SLIPS], stiffness[N_SLIPS];
    double sense, frame;
    double speed, rolling;
    double yawing;
} Contact;

#if HUB
/* The wheel at its hub; see hub.h. */
typedef struct {
    double results[N_HUB_RESULTS];
    double spring; /* load without damping and bottoming, N */
    double radius; /* loaded radius at which the spring is evaluated, m */
    double parameters[N_PARAMETERS];
} Hub;
#endif

/* Everything that changes in an instance: a copy is a saved state, the bytes a serialized one.  The road is that of the
   instance, also after a state has been restored. */
typedef struct {
    char token[TOKEN_SIZE]; /* identifies the FMU of a serialized state */
    int kind, mode;
    /* Whether computed values are valid for the present inputs, parameters, states and mode. */
    int contact_known, lengths_known, outputs_known, extras_known;
#if HUB
    int hub_known;
    Hub hub;
#endif
#if ROAD
    const RoadGrid *road;
#endif
#if SPIN
    int brake_sense; /* see spin.h */
    int event; /* whether the brake has locked, released or changed its direction in the last step */
#endif
    int stop_defined;
    double stop_time;
    double lagging[N_LAGGING]; /* since the end of initialization; see slips.h */
    double distance;         /* rolled, m */
#if N_MEMORY > 0
    double memory[N_MEMORY]; /* the states of effects; see memory.h */
#endif
    double lengths[N_SLIPS];
    int length_is_default[N_SLIPS];
    Contact contact;
    int interpolates; /* whether a slope is not 0 */
    double slopes[N_HOST_INPUTS]; /* of the inputs over the next step */
    double values[N_VALUES];
} State;

typedef struct Instance Instance;

/* Calls the host's logger, whose type depends on the FMI version, with one line. */
typedef void LogCallback(const Instance *self, Status status, const char *category, const char *message);

struct Instance {
    State state;
    Tire tire;
    RoadGrid *road; /* or NULL */
    LogCallback *log_message;
    void (*logger)(void); /* the host's function; `log_message` converts its type */
    void *environment;
    char *name;
    int logs_events, logs_warnings, logs_discards, logs_errors;
    int warned;
    int has_event_mode, returns_early; /* what the host uses in Co-Simulation */
};

/* Without `logs_events` the host gets warnings and errors only. */
Instance *instance_create(const char *name, const char *token, const char *resources, Kind kind, int logs_events,
                          LogCallback *log_message, void (*logger)(void), void *environment);
void instance_free(Instance *self);

/* Log why a call is rejected, or with STATUS_OK an assumption; returns `status`.  `self` may be NULL: then nothing is logged. */
Status instance_refuse(const Instance *self, Status status, const char *format, ...);
Status instance_unsupported(const Instance *self, const char *function);
/* For calls about variables of a type that this FMU lacks: accepted for zero variables, rejected otherwise. */
Status instance_lacks_type(const Instance *self, size_t n, const char *type);
Status instance_choose_log(Instance *self, int on, size_t n, const char *const categories[]);

/* Reject a NULL pointer to n > 0 values; `what` names the values. */
Status instance_expect_pointer(const Instance *self, const void *pointer, size_t n, const char *what);
/* Reject results that are not finite. */
Status instance_expect_finite(const Instance *self, const double values[], size_t n, const char *what);
/* Reject the call unless the instance is in one of two modes. */
Status instance_expect(const Instance *self, Mode mode, Mode other, const char *what);
/* Whether initialization is complete: lagged slips have their own values. */
int state_has_begun(const State *state);
/* Invalidate computed values: inputs, parameters, states or the mode have changed. */
void state_changed(State *state);

Status instance_set_experiment(Instance *self, double start, int stop_defined, double stop);
Status instance_enter_initialization(Instance *self);
Status instance_exit_initialization(Instance *self);
Status instance_step(Instance *self, double point, double size);
/* Whether an event has happened in the last step, which the host handles in event mode. */
int instance_had_event(const Instance *self);
/* The inputs change with these rates over the next step, from their present values. */
Status instance_set_slopes(Instance *self, const unsigned references[], size_t n, const int orders[],
                           const double slopes[]);
Status instance_terminate(Instance *self);
Status instance_reset(Instance *self);

/* Events: events.c.  With early return, a step ends behind the first event in it. */
Status instance_use_events(Instance *self, int event_mode, int early_return);
Status instance_enter_event(Instance *self);
Status instance_enter_continuous(Instance *self);
Status instance_enter_stepping(Instance *self);
Status instance_update_discrete(Instance *self, int *states_changed);

/* Model Exchange: continuous.c. */
Status instance_expect_exchange(const Instance *self, const char *what);
Status instance_complete_step(Instance *self);
Status instance_set_time(Instance *self, double time);
Status instance_get_states(Instance *self, double states[], size_t n);
Status instance_set_states(Instance *self, const double states[], size_t n);
Status instance_get_rates(Instance *self, double rates[], size_t n);
Status instance_get_nominals(Instance *self, double nominals[], size_t n);
Status instance_get_indicators(Instance *self, double indicators[], size_t n);

/* Direct feedthrough: outputs are computed when the host reads them, once after each change.  Extra outputs need the
   model's named quantities, which are computed only if the host reads one of them. */
void state_compute_outputs(State *state);
/* Integrate the states of slips and effects over h seconds with constant inputs. */
void state_integrate(State *state, double h);
void state_compute_extras(State *state);

Status instance_expect_known(const Instance *self, const unsigned references[], size_t n);
const char *value_name(unsigned reference);
int value_kind(unsigned reference);
/* The source of an extra output. */
int value_shows(unsigned reference);
/* The size of a value or its nominal value, whichever is larger; 1 if both are unknown. */
double value_scale(const State *state, unsigned reference);

Status instance_get(Instance *self, const unsigned references[], size_t n, double values[]);
Status instance_set(Instance *self, const unsigned references[], size_t n, const double values[]);
/* sensitivity = (d unknowns / d knowns) seed; adjoint: sensitivity = seed (d unknowns / d knowns). */
Status instance_derivative(Instance *self, const unsigned unknowns[], size_t n_unknowns,
                           const unsigned knowns[], size_t n_knowns, const double seed[],
                           double sensitivity[]);
Status instance_adjoint(Instance *self, const unsigned unknowns[], size_t n_unknowns, const unsigned knowns[],
                        size_t n_knowns, const double seed[], double sensitivity[]);

/* Saved states.  `*slot` is NULL or a state saved before, which is then reused. */
Status instance_save(Instance *self, void **slot);
Status instance_restore(Instance *self, const void *saved);
Status instance_drop(const Instance *self, void **slot);
Status instance_serialized_size(Instance *self, const void *saved, size_t *size);
Status instance_serialize(Instance *self, const void *saved, void *bytes, size_t size);
Status instance_deserialize(Instance *self, const void *bytes, size_t size, void **slot);

#endif
