/* Lagged slips: dx/dt = |V| / sigma (u - x) for kappa and tan(alpha), and the twist of the contact patch.  See slips.h.
 *
 * The inputs are constant over a step, so V, sigma and u are constant and the law of a lag is the exact solution.  The
 * result does not depend on the step size.
 */
#include "slips.h"

#include "state_laws.h"

#include <math.h>
#include <string.h>

/* Below this relaxation length a slip has no lag, m. */
#define SHORTEST_LENGTH 1e-6
/* Relaxation length of a state without lag in Model Exchange, and of the twist: short, but not stiff, m. */
#define FOLLOWING_LENGTH 0.1
/* The twist at which turning on the spot reaches the friction torque, rad; tirefmu's own value. */
#define SATURATION_TWIST 0.1
/* Below this speed the quotient of sliding and speed is not used, m/s. */
#define STANDSTILL_SPEED 1e-12

/* Wheel inputs need a lag at standstill, where slip is 0/0: a length that the tire does not have is DEFAULT_SIGMA. */
static int defaulted(const double length)
{
#if WHEEL
    return !(length > SHORTEST_LENGTH);
#else
    (void) length;
    return 0;
#endif
}

static double default_length(const State *state)
{
#if WHEEL
    return state->values[FIRST_PARAMETER + DEFAULT_SIGMA];
#else
    (void) state;
    return 0.0;
#endif
}

void slips_find_lengths(State *state)
{
    size_t i;

#if RELAXES
    model_relaxation(state->contact.inputs, model_parameters(state), state->lengths);
#else
    memset(state->lengths, 0, sizeof state->lengths);
#endif
    for (i = 0; i < N_SLIPS; i++) {
        state->length_is_default[i] = defaulted(state->lengths[i]);
        if (state->length_is_default[i])
            state->lengths[i] = default_length(state);
    }
}

/* False for a length of NaN. */
int slips_lag(const State *state, size_t slip) { return state->lengths[slip] > SHORTEST_LENGTH; }

static double given(const State *state, size_t slip)
{
    const Contact *contact = &state->contact;
    return slip == LATERAL ? tan(contact->inputs[ALPHA]) : contact->sense * contact->inputs[KAPPA];
}

static double bounded(const State *state, size_t slip)
{
    const double bound = state->contact.bounds[slip], x = state->continuous.lagging[slip];
    return x > bound ? bound : x < -bound ? -bound : x;
}

static double acting(const State *state, size_t slip)
{
    return state_has_begun(state) && slips_lag(state, slip) ? bounded(state, slip) : given(state, slip);
}

void slips_acting(const State *state, double inputs[N_INPUTS])
{
    memcpy(inputs, state->contact.inputs, N_INPUTS * sizeof *inputs);
    inputs[KAPPA] = state->contact.sense * acting(state, LONGITUDINAL);
    inputs[ALPHA] = atan(acting(state, LATERAL));
}

void slips_begin(State *state)
{
    size_t i;

    for (i = 0; i < N_SLIPS; i++)
        state->continuous.lagging[i] = given(state, i);
}

int slips_settle(State *state)
{
    size_t i;
    int moved = 0;

    for (i = 0; i < N_SLIPS; i++) {
        const double settled = acting(state, i);

        moved |= settled != state->continuous.lagging[i];
        state->continuous.lagging[i] = settled;
    }
    return moved;
}

#if TWISTS
double slips_twist(const State *state)
{
    const double share = state_has_begun(state) ? state->continuous.lagging[TWIST] / SATURATION_TWIST : 0.0;
    return share > 1.0 ? 1.0 : share < -1.0 ? -1.0 : share;
}

double slips_twist_decay(const State *state, double *by_yawing, double *by_speed)
{
    *by_yawing = 1.0 / SATURATION_TWIST;
    *by_speed = 1.0 / FOLLOWING_LENGTH;
    return fabs(state->contact.yawing) * *by_yawing + state->contact.rolling * *by_speed;
}

static double twist_rate(const State *state)
{
    double by_yawing, by_speed;
    return state->contact.yawing - slips_twist_decay(state, &by_yawing, &by_speed) * state->continuous.lagging[TWIST];
}

/* The exact solution: a twist that the yaw rate builds up to its saturation, and that rolling removes. */
static void advance_twist(State *state, double h)
{
    double by_yawing, by_speed;
    const double decay = slips_twist_decay(state, &by_yawing, &by_speed);

    if (decay > 0.0)
        state->continuous.lagging[TWIST] =
            state_lag_held(state->continuous.lagging[TWIST], state->contact.yawing / decay, decay * h);
}
#endif

void slips_advance(State *state, double h)
{
    const Contact *contact = &state->contact;
    double rolled;
    size_t i;

    for (i = 0; i < N_SLIPS; i++) {
        if (!slips_lag(state, i)) {
            state->continuous.lagging[i] = given(state, i);
            continue;
        }
        state->continuous.lagging[i] = bounded(state, i);
        if (contact->rolling > STANDSTILL_SPEED) {
            rolled = h * (contact->rolling / state->lengths[i]);
            state->continuous.lagging[i] = state_lag_held(state->continuous.lagging[i], contact->target[i], rolled);
        } else {
            state->continuous.lagging[i] += contact->sliding[i] * (h / state->lengths[i]);
        }
        state->continuous.lagging[i] = bounded(state, i);
    }
#if TWISTS
    advance_twist(state, h);
#endif
}

double slips_length(const State *state, size_t slip, LengthOrigin *origin)
{
    const int lags = slips_lag(state, slip);

    *origin = !lags ? CONSTANT_LENGTH : state->length_is_default[slip] ? DEFAULTED_LENGTH : MODEL_LENGTH;
    return lags ? state->lengths[slip] : FOLLOWING_LENGTH;
}

void slips_differentiate(const State *state, const double seeds[N_VALUES], Tangent *tangent)
{
    const double *moved = seeds + FIRST_STATE;
    const double x = state->continuous.lagging[LATERAL];

    memcpy(tangent->acting, tangent->given, sizeof tangent->acting);
    memcpy(tangent->motion + LAGGING, moved, N_LAGGING * sizeof *moved);
#if WHEEL
    tangent->motion[DEFAULT_LENGTH] = seeds[FIRST_PARAMETER + DEFAULT_SIGMA];
#endif
    if (!state_has_begun(state))
        return;
    if (slips_lag(state, LONGITUDINAL))
        tangent->acting[KAPPA] = state->contact.sense * moved[LONGITUDINAL];
    if (slips_lag(state, LATERAL))
        tangent->acting[ALPHA] = moved[LATERAL] / (1.0 + x * x);
}

/* Zero for a slip at its bound that would move outward. */
static double slip_rate(const State *state, size_t slip)
{
    const Contact *contact = &state->contact;
    const double x = state->continuous.lagging[slip];
    LengthOrigin origin;
    const double found = (contact->sliding[slip] - contact->rolling * x) / slips_length(state, slip, &origin);

    return fabs(x) >= contact->bounds[slip] && found * x > 0.0 ? 0.0 : found;
}

void slips_show(const State *state, double slips[])
{
    size_t i;

    for (i = 0; i < N_SLIPS; i++) /* in Model Exchange the state is the value that the solver set */
        slips[i] = state->kind == MODEL_EXCHANGE && state_has_begun(state) ? state->continuous.lagging[i] : acting(state, i);
#if TWISTS
    slips[TWIST] = state->continuous.lagging[TWIST];
#endif
}

void slips_show_rates(const State *state, double rates[])
{
    const int begun = state_has_begun(state);
    size_t i;

    for (i = 0; i < N_SLIPS; i++)
        rates[i] = begun ? slip_rate(state, i) : 0.0;
#if TWISTS
    rates[TWIST] = begun ? twist_rate(state) : 0.0;
#endif
}
