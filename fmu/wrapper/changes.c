/* The changes of outputs and derivatives.  See changes.h. */
#include "changes.h"

#include "chain_rule.h"
#include "hub.h"
#include "effect_states.h"
#include "slips.h"
#include "spin.h"

#include <math.h>
#include <string.h>

void changes_begin(Changes *changes, State *state, double seeds[N_VALUES])
{
#if HUB
    double results[N_HUB_RESULTS];

    hub_differentiate(state, seeds, results);
#endif
    changes_at_contact(changes, state, seeds);
#if HUB
    memcpy(changes->tangent.motion + HUB_CHANGE, results, sizeof results);
#endif
#if SPIN
    spin_differentiate(state, seeds, changes->tangent.motion);
#endif
}

static double change_of_force(Changes *changes, unsigned i)
{
    return output_sign(changes->state->contact.sense, i) * change_of_slot(changes, ACTING, chain_force(i));
}

/* sqrt(x^2 + y^2), where x and y are the forces as a share of friction: force / (mu load). */
static double friction_change(Changes *changes)
{
    static const unsigned force[] = {LONGITUDINAL_FORCE, SIDE_FORCE};
    static const unsigned friction[] = {FRICTION_X, FRICTION_Y};
    const State *state = changes->state;
    const double load = state->contact.inputs[LOAD];
    double inputs[N_INPUTS], quantities[N_QUANTITIES], share[N_SLIPS] = {0.0, 0.0}, use, sum = 0.0;
    size_t i;

    slips_acting(state, inputs);
    memory_fill(state, inputs);
    model_quantities(inputs, model_parameters(state), quantities);
    for (i = 0; i < N_SLIPS; i++)
        if (load > 0.0 && quantities[friction[i]] != 0.0)
            share[i] = host_value(state, FIRST_OUTPUT + force[i]) / (quantities[friction[i]] * load);
    use = sqrt(share[0] * share[0] + share[1] * share[1]);
    for (i = 0; i < N_SLIPS; i++) {
        const double limit = quantities[friction[i]] * load;

        if (share[i] == 0.0)
            continue;
        sum += share[i] / use / limit * change_of_force(changes, force[i]);
        sum -= share[i] * share[i] / use * load / limit * change_of_slot(changes, ACTING, chain_quantity(friction[i]));
    }
    return use > 0.0 ? sum - use / load * change_of_slot(changes, GIVEN, LOAD) : sum;
}

#if LAGS
/* (sliding - |V| x) / length */
static double rate_change(Changes *changes, unsigned slip)
{
#if RELAXES
    static const unsigned lengths[] = {RELAXATION_X, RELAXATION_Y};
#endif
    const State *state = changes->state;
    const double *motion = changes->tangent.motion, rate = host_value(state, FIRST_DERIVATIVE + slip);
    LengthOrigin origin;
    const double length = slips_length(state, slip, &origin);
    double moved;

    if (!state_has_begun(state))
        return 0.0;
    moved = motion[SLIDING + slip] - state->contact.rolling * motion[LAGGING + slip] -
            state->continuous.lagging[slip] * motion[ROLLING];
#if RELAXES
    if (origin == MODEL_LENGTH)
        moved -= rate * change_of_slot(changes, GIVEN, chain_quantity(lengths[slip]));
#endif
    if (origin == DEFAULTED_LENGTH)
        moved -= rate * motion[DEFAULT_LENGTH];
    return moved / length;
}
#endif

#if TWISTS
/* yawing - decay twist */
static double twist_change(const Changes *changes)
{
    const State *state = changes->state;
    const double *motion = changes->tangent.motion, twist = state->continuous.lagging[TWIST];
    const double sense = state->contact.yawing < 0.0 ? -1.0 : 1.0;
    double by_yawing, by_speed;
    const double decay = slips_twist_decay(state, &by_yawing, &by_speed);

    if (!state_has_begun(state))
        return 0.0;
    return (1.0 - sense * by_yawing * twist) * motion[YAWING] - by_speed * twist * motion[ROLLING] -
           decay * motion[LAGGING + TWIST];
}
#endif

#if N_MEMORY > 0
/* The derivatives of the states of effects are behind those of slips and twist. */
#define FIRST_MEMORY_RATE (FIRST_DERIVATIVE + FIRST_MEMORY - FIRST_STATE)

static double memory_change(Changes *changes, unsigned i, unsigned quantity)
{
    if (!state_has_begun(changes->state))
        return 0.0;
    return change_of_slot(changes, memory_is_direct(i) ? DIRECT : ACTING, chain_quantity(quantity));
}
#endif

#if HUB
/* A result for the hub: a sum over the contact forces, and the change at constant forces. */
static double hub_change(Changes *changes, unsigned result)
{
    double by[N_OUTPUTS], sum = changes->tangent.motion[HUB_CHANGE + result];
    unsigned i;

    if (result < WRENCH_RESULT)
        return sum;
    hub_by_forces(changes->state, result, by);
    for (i = 0; i < N_OUTPUTS; i++)
        sum += by[i] * change_of_force(changes, i);
    return sum;
}
#endif

#if SPIN
/* An entry of the motion, and `factor` times the moment of the tire about the spin axis. */
static double spin_change(Changes *changes, unsigned entry, double factor)
{
    const double sum = changes->tangent.motion[entry];
    return factor != 0.0 ? sum + factor * hub_change(changes, SPIN_MOMENT) : sum;
}

/* The torque of a brake that holds balances the others. */
static double brake_change(Changes *changes)
{
    const int balances = changes->state->kind == MODEL_EXCHANGE && spin_is_held(changes->state);
    return spin_change(changes, HUB_CHANGE + BRAKE_RESULT, balances ? -1.0 : 0.0);
}
#endif

/* In the model's signs. */
static double find_change(Changes *changes, unsigned unknown)
{
    int shown;

#if HUB
    if (unknown == FIRST_INPUT + HOST_LOAD)
        return hub_change(changes, LOAD_RESULT);
#if SPIN
    if (unknown == SPIN_VALUE)
        return changes->tangent.motion[SPIN_MOVED];
    if (unknown == SPIN_RATE)
        return spin_change(changes, SPIN_PUSHED, spin_gain(changes->state));
#endif
    if (unknown < FIRST_OUTPUT)
        return hub_change(changes, unknown - FIRST_COMPUTED);
#endif
    if (unknown < FIRST_PARAMETER)
        return change_of_force(changes, unknown - FIRST_OUTPUT);
#if LAGS
    if (unknown < FIRST_DERIVATIVE + N_SLIPS)
        return rate_change(changes, unknown - FIRST_DERIVATIVE);
#endif
#if TWISTS
    if (unknown == FIRST_DERIVATIVE + TWIST)
        return twist_change(changes);
#endif
#if N_MEMORY > 0
    if (unknown >= FIRST_MEMORY_RATE && unknown < FIRST_MEMORY_RATE + N_MEMORY)
        return memory_change(changes, unknown - FIRST_MEMORY_RATE, memory_derivative(unknown - FIRST_MEMORY_RATE));
#endif
    if (unknown < FIRST_EXTRA)
        return changes->tangent.motion[ROLLING]; /* of the distance */
    shown = value_shows(unknown);
#if SPIN
    if (shown == BRAKE_EVENT)
        return spin_change(changes, spin_is_held(changes->state) ? SPIN_MARGIN : SPIN_MOVED,
                           spin_margin_by_moment(changes->state));
    if (shown == FIRST_HUB + BRAKE_RESULT)
        return brake_change(changes);
#endif
    if (shown == FRICTION_USE)
        return friction_change(changes);
#if HUB
    if (shown >= FIRST_HUB)
        return hub_change(changes, (unsigned) (shown - FIRST_HUB));
#endif
#if N_MEMORY > 0
    if (shown >= FIRST_PATH)
        return memory_change(changes, (unsigned) (shown - FIRST_PATH), memory_event((size_t) (shown - FIRST_PATH)));
#endif
    if (shown == KAPPA_GIVEN)
        return changes->state->contact.sense * change_of_slot(changes, GIVEN, KAPPA);
    if (shown == ALPHA_GIVEN || shown == ALPHA_LAGGED)
        return change_of_slot(changes, shown == ALPHA_GIVEN ? GIVEN : ACTING, ALPHA);
    return change_of_slot(changes, ACTING, chain_quantity((unsigned) (shown - FIRST_QUANTITY)));
}

double change_of_value(Changes *changes, unsigned unknown)
{
    return find_change(changes, unknown) * value_direction(unknown);
}
