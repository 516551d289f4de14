/* Slips that lag: dx/dt = |V| / sigma (u - x) on kappa and tan(alpha).  See slips.h.
 *
 * With inputs held over a step V, sigma and u are constant and the exponential is the solution itself: the result
 * does not depend on how a stretch of time is cut into steps.
 */
#include "slips.h"

#include <math.h>
#include <string.h>

/* Below this relaxation length a slip acts at once, m. */
#define AT_ONCE 1e-6
/* In Model Exchange the state of a slip that acts at once follows within this length: short, and not stiff, m. */
#define FOLLOWING 0.1
/* Below this speed a slip is not what the wheel slides over it, m/s. */
#define STANDING 1e-12

static void find_lengths(State *state)
{
    contact_find(state);
    if (!state->lengths_known)
        model_relaxation(state->contact.inputs, state->values + FIRST_PARAMETER, state->lengths);
    state->lengths_known = 1;
}

/* So written that a length of NaN does not lag. */
int slips_lag(State *state, size_t slip)
{
    find_lengths(state);
    return state->lengths[slip] > AT_ONCE;
}

static double given(const State *state, size_t slip)
{
    const Contact *contact = &state->contact;
    return slip == LATERAL ? tan(contact->inputs[ALPHA]) : contact->sense * contact->inputs[KAPPA];
}

static double bounded(const State *state, size_t slip)
{
    const double bound = state->contact.bounds[slip], x = state->lagging[slip];
    return x > bound ? bound : x < -bound ? -bound : x;
}

static double acting(State *state, size_t slip)
{
    return state_has_begun(state) && slips_lag(state, slip) ? bounded(state, slip) : given(state, slip);
}

void slips_acting(State *state, double inputs[N_INPUTS])
{
    find_lengths(state);
    memcpy(inputs, state->contact.inputs, N_INPUTS * sizeof *inputs);
    inputs[KAPPA] = state->contact.sense * acting(state, LONGITUDINAL);
    inputs[ALPHA] = atan(acting(state, LATERAL));
}

void slips_begin(State *state)
{
    size_t i;

    contact_find(state);
    for (i = 0; i < N_SLIPS; i++)
        state->lagging[i] = given(state, i);
}

int slips_settle(State *state)
{
    double settled;
    size_t i;
    int moved = 0;

    for (i = 0; i < N_SLIPS; i++) {
        settled = acting(state, i);
        moved |= settled != state->lagging[i];
        state->lagging[i] = settled;
    }
    return moved;
}

void slips_advance(State *state, double h)
{
    const Contact *contact = &state->contact;
    double rolled;
    size_t i;

    for (i = 0; i < N_SLIPS; i++) {
        if (!slips_lag(state, i)) {
            state->lagging[i] = given(state, i);
            continue;
        }
        state->lagging[i] = bounded(state, i);
        if (contact->speed > STANDING) {
            rolled = h * (contact->speed / state->lengths[i]);
            state->lagging[i] = exp(-rolled) * state->lagging[i] - expm1(-rolled) * contact->toward[i];
        } else {
            state->lagging[i] += contact->sliding[i] * (h / state->lengths[i]);
        }
        state->lagging[i] = bounded(state, i);
    }
}

double slips_length(State *state, size_t slip, int *of_model)
{
    *of_model = slips_lag(state, slip);
    return *of_model ? state->lengths[slip] : FOLLOWING;
}

void slips_differentiate(State *state, const double seeds[N_VALUES], Tangent *tangent)
{
    const double *moved = seeds + FIRST_STATE;
    const double x = state->lagging[LATERAL];

    memcpy(tangent->acting, tangent->given, sizeof tangent->acting);
    memcpy(tangent->moved + LAGGING, moved, N_SLIPS * sizeof *moved);
    if (!state_has_begun(state))
        return;
    if (slips_lag(state, LONGITUDINAL))
        tangent->acting[KAPPA] = state->contact.sense * moved[LONGITUDINAL];
    if (slips_lag(state, LATERAL))
        tangent->acting[ALPHA] = moved[LATERAL] / (1.0 + x * x);
}

/* A slip at its bound does not go on outward. */
static double rate(State *state, size_t slip)
{
    const Contact *contact = &state->contact;
    const double x = state->lagging[slip];
    int of_model;
    const double found = (contact->sliding[slip] - contact->speed * x) / slips_length(state, slip, &of_model);

    return fabs(x) >= contact->bounds[slip] && found * x > 0.0 ? 0.0 : found;
}

void slips_show(State *state, double slips[], double rates[])
{
    size_t i;

    for (i = 0; i < N_SLIPS; i++) {
        /* A solver's state is what the solver set. */
        slips[i] = state->kind == MODEL_EXCHANGE && state_has_begun(state) ? state->lagging[i] : acting(state, i);
        rates[i] = state_has_begun(state) ? rate(state, i) : 0.0;
    }
}
