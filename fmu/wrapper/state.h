/* The state of a tire instance: its values, what a step integrates, and what is computed from them.
 *
 * The files that compute have an order, in which each calls earlier ones only: values, contact (slip_inputs or
 * wheel_inputs), slips, standstill, memory, hub, spin, outputs, spin_steps.  They know
 * nothing of the instance and its log (instance.h).
 *
 * A name is that of one thing in all files, also if it is static: a compiler takes longer to start than for a file, so
 * that many files are one unit (binaries.py).
 */
#ifndef STATE_H
#define STATE_H

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

/* What a step integrates. */
typedef struct {
    double lagging[N_LAGGING]; /* since the end of initialization; see slips.h */
    double distance;           /* rolled, m */
#if N_MEMORY > 0
    double memory[N_MEMORY]; /* the states of effects; see effect_states.h */
#endif
} Continuous;

/* How far values are computed for the present inputs, parameters, states and mode; each needs the ones before it. */
typedef enum { NOTHING, LOAD_KNOWN, CONTACT_KNOWN, OUTPUTS_KNOWN, RATES_KNOWN, EXTRAS_KNOWN } Known;

/* Everything that changes in an instance: a copy is a saved state, the bytes a serialized one. */
typedef struct {
    char token[TOKEN_SIZE]; /* identifies the FMU of a serialized state */
    int kind, mode;
    int known; /* see outputs.h */
#if HUB
    Hub hub;
#endif
#if SPIN
    int brake_sense; /* see spin.h */
    int event; /* whether the brake has locked, released or changed its direction in the last step */
#endif
    int stop_defined;
    double stop_time;
    Continuous continuous;
    double lengths[N_SLIPS];
    int length_is_default[N_SLIPS];
    Contact contact;
    int interpolates; /* whether a slope is not 0 */
    double slopes[N_HOST_INPUTS]; /* of the inputs over the next step */
    double values[N_VALUES];
} State;

/* Whether initialization is complete: lagged slips have their own values. */
static inline int state_has_begun(const State *state) { return state->mode >= STEPPING; }
/* Invalidate computed values: inputs, parameters, states or the mode have changed. */
static inline void state_changed(State *state) { state->known = NOTHING; }
/* Set the value of a state by its reference, in the host's signs. */
void state_set(State *state, unsigned reference, double value);

/* ---------------------------------------------------------------- values: values.c */

/* By value reference: its kind, and -1 where host and model use opposite signs. */
extern const unsigned char value_kinds[];
extern const signed char value_directions[];

const char *value_name(unsigned reference);
static inline int value_kind(unsigned reference) { return value_kinds[reference]; }
/* Whether it is a continuous state. */
int value_is_state(unsigned reference);
/* The source of an extra output. */
int value_shows(unsigned reference);
/* The size of a value or its nominal value, whichever is larger; 1 if both are unknown. */
double value_scale(const State *state, unsigned reference);
static inline double value_direction(unsigned reference) { return value_directions[reference]; }
/* An input or a wheel parameter in the model's signs. */
static inline double host_value(const State *state, size_t reference)
{
    return state->values[reference] * value_directions[reference];
}
/* The parameters as the model reads them: with hub inputs, the friction of the road scales some of them. */
static inline const double *model_parameters(const State *state)
{
#if HUB
    return state->hub.parameters;
#else
    return state->values + FIRST_PARAMETER;
#endif
}
/* The sign of an output in a direction of travel: a model whose equations are those of forward rolling is mirrored. */
double output_sign(double sense, size_t output);

#endif
