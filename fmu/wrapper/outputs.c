/* What follows from inputs, parameters and states.  See outputs.h. */
#include "outputs.h"

#include "contact.h"
#include "hub.h"
#include "effect_states.h"
#include "slips.h"
#include "spin.h"
#include "state_laws.h"

#include <math.h>
#include <string.h>

void state_find_contact(State *state)
{
#if HUB
    if (state->known < LOAD_KNOWN)
        hub_find(state);
#endif
    if (state->known >= CONTACT_KNOWN)
        return;
    contact_find(state);
    slips_find_lengths(state);
    state->known = CONTACT_KNOWN;
}

/* Write the states to the values, in the host's signs. */
static void show_states(State *state)
{
#if N_STATES > 0
    double *states = state->values + FIRST_STATE;
    size_t i;

    slips_show(state, states);
#if N_MEMORY > 0
    memory_show(state, states + FIRST_MEMORY - FIRST_STATE);
#endif
#ifdef DISTANCE
    states[N_STATES - 1] = state->continuous.distance;
#endif
    for (i = 0; i < N_STATES; i++)
        states[i] *= value_direction((unsigned) (FIRST_STATE + i));
#else
    (void) state;
#endif
}

void state_compute_outputs(State *state)
{
    double inputs[N_INPUTS], *forces = state->values + FIRST_OUTPUT;
    size_t i;

    if (state->known >= OUTPUTS_KNOWN)
        return;
    state_find_contact(state);
    slips_acting(state, inputs);
    memory_fill(state, inputs);
    contact_forces(state, inputs, forces);
    for (i = 0; i < N_OUTPUTS; i++)
        forces[i] *= value_direction((unsigned) (FIRST_OUTPUT + i));
#if HUB
    hub_add_forces(state);
#endif
#if SPIN
    spin_show(state);
#endif
    show_states(state);
    state->known = OUTPUTS_KNOWN;
}

void state_compute_rates(State *state)
{
#if N_STATES > 0
    double *rates = state->values + FIRST_DERIVATIVE;
    size_t i;
#endif
#if N_MEMORY > 0
    double events[N_MEMORY];
#endif

    state_compute_outputs(state);
    if (state->known >= RATES_KNOWN)
        return;
#if N_STATES > 0
    slips_show_rates(state, rates);
#if N_MEMORY > 0
    memory_rates(state, rates + FIRST_MEMORY - FIRST_STATE, events);
#endif
#ifdef DISTANCE
    rates[N_STATES - 1] = state->contact.speed;
#endif
    for (i = 0; i < N_STATES; i++)
        rates[i] *= value_direction((unsigned) (FIRST_DERIVATIVE + i));
#endif
    state->known = RATES_KNOWN;
}

static double share(double force, double limit) { return limit != 0.0 ? force / limit : 0.0; }

/* The force as a share of the friction ellipse: 1 on the ellipse. */
static double friction_use(const State *state, const double quantities[])
{
    const double *forces = state->values + FIRST_OUTPUT, load = state->contact.inputs[LOAD];
    const double x = share(forces[LONGITUDINAL_FORCE], quantities[FRICTION_X] * load);
    const double y = share(forces[SIDE_FORCE], quantities[FRICTION_Y] * load);

    return load > 0.0 ? sqrt(x * x + y * y) : 0.0;
}

/* In the model's signs; `inputs` are those with the acting slips and states, `events` those of memory_rates. */
static double extra(const State *state, int shown, const double inputs[], const double quantities[],
                    const double events[])
{
#if HUB
    if (shown >= FIRST_HUB)
        return state->hub.results[shown - FIRST_HUB];
#endif
    if (shown >= FIRST_PATH)
        return events[shown - FIRST_PATH];
    if (shown >= FIRST_QUANTITY)
        return quantities[shown - FIRST_QUANTITY];
#if SPIN
    if (shown == BRAKE_EVENT)
        return spin_indicator(state);
#endif
    if (shown == FRICTION_USE)
        return friction_use(state, quantities);
    if (shown == KAPPA_GIVEN)
        return state->contact.sense * state->contact.inputs[KAPPA];
    return shown == ALPHA_GIVEN ? state->contact.inputs[ALPHA] : inputs[ALPHA];
}

void state_compute_extras(State *state)
{
    double inputs[N_INPUTS], quantities[N_QUANTITIES];
    double rates[N_MEMORY + 1], events[N_MEMORY + 1] = {0.0};
    size_t i;

    state_compute_rates(state);
    if (state->known >= EXTRAS_KNOWN)
        return;
    slips_acting(state, inputs);
    memory_fill(state, inputs);
    model_quantities(inputs, model_parameters(state), quantities);
    memory_rates(state, rates, events);
    for (i = 0; i < N_EXTRAS; i++) {
        const unsigned reference = (unsigned) (FIRST_EXTRA + i);
        state->values[reference] =
            extra(state, value_shows(reference), inputs, quantities, events) * value_direction(reference);
    }
    state->known = EXTRAS_KNOWN;
}

#if N_STATES > 0
void state_integrate(State *state, double h)
{
    Continuous *continuous = &state->continuous;

    state_find_contact(state);
#if N_MEMORY > 0
    memory_advance(state, h);
#else
    slips_advance(state, h);
#endif
    continuous->distance = state_sum_linear(continuous->distance, state->contact.speed, state->contact.speed, h);
    state->known = CONTACT_KNOWN;
}
#endif
