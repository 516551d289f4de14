/* The load that the spring of a tire carries at a loaded radius.  See hub.h. */
#include "hub.h"

#include "contact.h"
#include "loaded_radius.h"
#include "effect_states.h"
#include "root.h"
#include "slips.h"

/* The largest deflection at which the spring is evaluated, per free radius. */
#define DEEPEST 0.9
/* Loads at which the deflection is tried, up to 200 times the nominal one.  Large slip forces make a tire softer in some
   models, so that a deflection may belong to two loads, the lower of which acts, or to none: then the nearest one acts. */
#define MAX_LOADS 25
#define LOAD_GROWTH 1.25
/* The search ends at an error of a few units in the last place of the loaded radius. */
#define RADIUS_ACCURACY 4e-16

#ifdef LOADED_RADIUS
/* The model's loaded radius under a load. */
static double radius_under(State *state, double load)
{
    double inputs[N_INPUTS], forces[N_OUTPUTS] = {0.0};

    state->values[FIRST_INPUT + HOST_LOAD] = load;
    contact_find(state);
    slips_find_lengths(state);
    slips_acting(state, inputs);
    memory_fill(state, inputs);
#if RADIUS_READS_FORCES
    model_forces(inputs, model_parameters(state), forces);
#endif
    return loaded_radius(inputs, forces, model_parameters(state));
}

static double radius_error(void *context, double load)
{
    State *state = context;
    return radius_under(state, load) - state->hub.radius;
}

void hub_find_spring(State *state)
{
    Hub *hub = &state->hub;
    const double given = hub->results[RADIUS_RESULT], free_radius = radius_under(state, 0.0);
    const double least = (1.0 - DEEPEST) * free_radius;
    Sample low, high = {hub_parameter(state, OWN_FNOMIN), 0.0}, nearest;
    int i;

    hub->radius = given < least ? least : given;
    low.x = 0.0;
    low.value = free_radius - hub->radius;
    nearest = low;
    if (!(low.value > 0.0)) {
        hub->spring = low.value <= 0.0 ? 0.0 : low.value; /* NaN remains */
        return;
    }
    for (i = 0; i < MAX_LOADS; i++) {
        high.value = radius_error(state, high.x);
        if (!(high.value > 0.0)) {
            hub->spring = root_between(radius_error, state, low, high, RADIUS_ACCURACY * free_radius);
            return;
        }
        low = high;
        if (low.value < nearest.value)
            nearest = low;
        high.x *= LOAD_GROWTH;
    }
    hub->spring = nearest.x;
}
#else
void hub_find_spring(State *state)
{
    const double free_radius = hub_parameter(state, OWN_UNLOADED_RADIUS);
    Hub *hub = &state->hub;

    hub->radius = hub->results[RADIUS_RESULT];
    hub->spring = hub->radius >= free_radius ? 0.0 : hub_parameter(state, OWN_VERTICAL_STIFFNESS) * (free_radius - hub->radius);
}
#endif
