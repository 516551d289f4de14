/* The terms of outputs and derivatives.  See terms.h. */
#include "terms.h"

#include "chain_rule.h"
#include "contact.h"
#include "hub.h"
#include "memory.h"
#include "slips.h"
#include "spin.h"

#include <math.h>

static size_t add(Term terms[], size_t n, Point point, unsigned slot, double factor)
{
    terms[n].point = point;
    terms[n].slot = slot;
    terms[n].factor = factor;
    return n + 1;
}

static size_t add_force(const State *state, Term terms[], size_t n, unsigned i, double factor)
{
    return add(terms, n, ACTING, chain_force(i), output_sign(state->contact.sense, i) * factor);
}

/* sqrt(x^2 + y^2), where x and y are the forces as a share of friction: force / (mu load). */
static size_t friction_terms(State *state, Term terms[MAX_TERMS])
{
    static const unsigned force[] = {LONGITUDINAL_FORCE, SIDE_FORCE};
    static const unsigned friction[] = {FRICTION_X, FRICTION_Y};
    const double load = state->contact.inputs[LOAD];
    double inputs[N_INPUTS], quantities[N_QUANTITIES], share[N_SLIPS] = {0.0, 0.0}, use, limit;
    size_t i, n = 0;

    slips_acting(state, inputs);
    memory_fill(state, inputs);
    model_quantities(inputs, model_parameters(state), quantities);
    for (i = 0; i < N_SLIPS; i++)
        if (load > 0.0 && quantities[friction[i]] != 0.0)
            share[i] = host_value(state, FIRST_OUTPUT + force[i]) / (quantities[friction[i]] * load);
    use = sqrt(share[0] * share[0] + share[1] * share[1]);
    for (i = 0; i < N_SLIPS; i++) {
        if (share[i] == 0.0)
            continue;
        limit = quantities[friction[i]] * load;
        n = add_force(state, terms, n, force[i], share[i] / use / limit);
        n = add(terms, n, ACTING, chain_quantity(friction[i]), -share[i] * share[i] / use * load / limit);
    }
    return use > 0.0 ? add(terms, n, GIVEN, LOAD, -use / load) : n;
}

#if LAGS
/* (sliding - |V| x) / length */
static size_t rate_terms(State *state, unsigned slip, Term terms[MAX_TERMS])
{
#if RELAXES
    static const unsigned lengths[] = {RELAXATION_X, RELAXATION_Y};
#endif
    const double rate = host_value(state, FIRST_DERIVATIVE + slip);
    LengthOrigin origin;
    const double length = slips_length(state, slip, &origin);
    size_t n = 0;

    if (!state_has_begun(state))
        return 0;
    n = add(terms, n, MOTION, SLIDING + slip, 1.0 / length);
    n = add(terms, n, MOTION, LAGGING + slip, -state->contact.rolling / length);
    n = add(terms, n, MOTION, ROLLING, -state->continuous.lagging[slip] / length);
#if RELAXES
    if (origin == MODEL_LENGTH)
        n = add(terms, n, GIVEN, chain_quantity(lengths[slip]), -rate / length);
#endif
    return origin == DEFAULTED_LENGTH ? add(terms, n, MOTION, DEFAULT_LENGTH, -rate / length) : n;
}
#endif

#if TWISTS
/* yawing - decay twist */
static size_t twist_terms(const State *state, Term terms[MAX_TERMS])
{
    const double twist = state->continuous.lagging[TWIST], way = state->contact.yawing < 0.0 ? -1.0 : 1.0;
    double by_yawing, by_speed;
    const double decay = slips_twist_decay(state, &by_yawing, &by_speed);
    size_t n = 0;

    if (!state_has_begun(state))
        return 0;
    n = add(terms, n, MOTION, YAWING, 1.0 - way * by_yawing * twist);
    n = add(terms, n, MOTION, ROLLING, -by_speed * twist);
    return add(terms, n, MOTION, LAGGING + TWIST, -decay);
}
#endif

#if N_MEMORY > 0
/* The derivatives of the states of effects are behind those of slips and twist. */
#define FIRST_MEMORY_RATE (FIRST_DERIVATIVE + FIRST_MEMORY - FIRST_STATE)

static size_t memory_terms(const State *state, unsigned i, unsigned quantity, Term terms[MAX_TERMS])
{
    if (!state_has_begun(state))
        return 0;
    return add(terms, 0, memory_is_direct(i) ? DIRECT : ACTING, chain_quantity(quantity), 1.0);
}
#endif

#if HUB
/* A result for the hub: a sum over the contact forces, and the change at constant forces. */
static size_t hub_terms(const State *state, unsigned result, Term terms[MAX_TERMS])
{
    size_t n = add(terms, 0, MOTION, HUB_CHANGE + result, 1.0);
    double by[N_OUTPUTS];
    unsigned i;

    if (result < WRENCH_RESULT)
        return n;
    hub_by_forces(state, result, by);
    for (i = 0; i < N_OUTPUTS; i++)
        n = add_force(state, terms, n, i, by[i]);
    return n;
}
#endif

#if SPIN
/* `factor` times the moment of the tire about the spin axis, and an entry of the motion. */
static size_t spin_terms(State *state, unsigned entry, double factor, Term terms[MAX_TERMS])
{
    size_t i, n = factor != 0.0 ? hub_terms(state, SPIN_MOMENT, terms) : 0;

    for (i = 0; i < n; i++)
        terms[i].factor *= factor;
    return add(terms, n, MOTION, entry, 1.0);
}

/* The torque of a brake that holds balances the others. */
static size_t brake_terms(State *state, Term terms[MAX_TERMS])
{
    const int balances = state->kind == MODEL_EXCHANGE && spin_is_held(state);
    return spin_terms(state, HUB_CHANGE + BRAKE_RESULT, balances ? -1.0 : 0.0, terms);
}
#endif

/* In the model's signs. */
static size_t find(State *state, unsigned unknown, Term terms[MAX_TERMS])
{
    int shown;

#if HUB
    if (unknown == FIRST_INPUT + HOST_LOAD)
        return hub_terms(state, LOAD_RESULT, terms);
#if SPIN
    if (unknown == SPIN_VALUE)
        return add(terms, 0, MOTION, SPIN_MOVED, 1.0);
    if (unknown == SPIN_RATE)
        return spin_terms(state, SPIN_PUSHED, spin_gain(state), terms);
#endif
    if (unknown < FIRST_OUTPUT)
        return hub_terms(state, unknown - FIRST_COMPUTED, terms);
#endif
    if (unknown < FIRST_PARAMETER)
        return add_force(state, terms, 0, unknown - FIRST_OUTPUT, 1.0);
#if LAGS
    if (unknown < FIRST_DERIVATIVE + N_SLIPS)
        return rate_terms(state, unknown - FIRST_DERIVATIVE, terms);
#endif
#if TWISTS
    if (unknown == FIRST_DERIVATIVE + TWIST)
        return twist_terms(state, terms);
#endif
#if N_MEMORY > 0
    if (unknown >= FIRST_MEMORY_RATE && unknown < FIRST_MEMORY_RATE + N_MEMORY)
        return memory_terms(state, unknown - FIRST_MEMORY_RATE, memory_derivative(unknown - FIRST_MEMORY_RATE), terms);
#endif
    if (unknown < FIRST_EXTRA)
        return add(terms, 0, MOTION, ROLLING, 1.0); /* of the distance */
    shown = value_shows(unknown);
#if SPIN
    if (shown == BRAKE_EVENT)
        return spin_terms(state, spin_is_held(state) ? SPIN_MARGIN : SPIN_MOVED, spin_margin_by_moment(state), terms);
    if (shown == FIRST_HUB + BRAKE_RESULT)
        return brake_terms(state, terms);
#endif
    if (shown == FRICTION_USE)
        return friction_terms(state, terms);
#if HUB
    if (shown >= FIRST_HUB)
        return hub_terms(state, (unsigned) (shown - FIRST_HUB), terms);
#endif
#if N_MEMORY > 0
    if (shown >= FIRST_PATH)
        return memory_terms(state, (unsigned) (shown - FIRST_PATH), memory_event((size_t) (shown - FIRST_PATH)), terms);
#endif
    if (shown == KAPPA_GIVEN)
        return add(terms, 0, GIVEN, KAPPA, state->contact.sense);
    if (shown == ALPHA_GIVEN || shown == ALPHA_LAGGED)
        return add(terms, 0, shown == ALPHA_GIVEN ? GIVEN : ACTING, ALPHA, 1.0);
    return add(terms, 0, ACTING, chain_quantity((unsigned) (shown - FIRST_QUANTITY)), 1.0);
}

size_t terms_find(State *state, unsigned unknown, Term terms[MAX_TERMS])
{
    const size_t n = find(state, unknown, terms);
    size_t i;

    for (i = 0; i < n; i++)
        terms[i].factor *= value_direction(unknown);
    return n;
}
