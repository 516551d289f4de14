/* Motion, load and forces of a wheel at its hub.  See hub.h. */
#include "hub.h"

#include "contact.h"
#include "memory.h"
#include "root.h"
#include "slips.h"
#include "wheel_kinematics.h"

#include <math.h>
#include <string.h>

/* The largest deflection at which the spring is evaluated, per free radius. */
#define DEEPEST 0.9
/* Loads at which the deflection is tried, up to 200 times the nominal one.  Large slip forces make a tire softer in some
   models, so that a deflection may belong to two loads, the lower of which acts, or to none: then the nearest one acts. */
#define MAX_LOADS 25
#define LOAD_GROWTH 1.25
/* The search ends at an error of a few units in the last place of the loaded radius. */
#define ACCURACY 4e-16

/* By output of the model: its place among the contact forces of hub_wrench. */
static const unsigned FORCE[] = CONTACT_FORCES;

/* wheel_motion reads the first inputs of the host, and its results are those of the hub. */
typedef char motion_fits[WHEEL_MOTION_ARGUMENTS <= N_HOST_INPUTS && (int) WHEEL_MOTION_RESULTS == LOAD_RESULT ? 1 : -1];
typedef char wrench_fits[(int) HUB_WRENCH_RESULTS == BRAKE_RESULT - WRENCH_RESULT ? 1 : -1];

static double parameter(const State *state, size_t i) { return state->values[FIRST_PARAMETER + i]; }

#ifdef LOADED_RADIUS
/* The model's loaded radius under a load. */
static double radius_under(State *state, double load)
{
    double inputs[N_INPUTS], quantities[N_QUANTITIES];

    state->values[FIRST_INPUT + HOST_LOAD] = load;
    contact_find(state);
    slips_find_lengths(state);
    slips_acting(state, inputs);
    memory_fill(state, inputs);
    model_quantities(inputs, model_parameters(state), quantities);
    return quantities[LOADED_RADIUS];
}

static double radius_error(void *context, double load)
{
    State *state = context;
    return radius_under(state, load) - state->hub.radius;
}

static void find_spring(State *state)
{
    Hub *hub = &state->hub;
    const double given = hub->results[RADIUS_RESULT], free_radius = radius_under(state, 0.0);
    const double least = (1.0 - DEEPEST) * free_radius;
    Sample low, high = {parameter(state, OWN_FNOMIN), 0.0}, nearest;
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
            hub->spring = root_between(radius_error, state, low, high, ACCURACY * free_radius);
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
static void find_spring(State *state)
{
    const double free_radius = parameter(state, OWN_UNLOADED_RADIUS);
    Hub *hub = &state->hub;

    hub->radius = hub->results[RADIUS_RESULT];
    hub->spring = hub->radius >= free_radius ? 0.0 : parameter(state, OWN_VERTICAL_STIFFNESS) * (free_radius - hub->radius);
}
#endif

static double total_load(const State *state)
{
    const double radius = state->hub.results[RADIUS_RESULT], rate = state->hub.results[RADIUS_RATE_RESULT];
    const double bottom = parameter(state, OWN_BOTTOM_RADIUS) - radius;
    double load = state->hub.spring;

    if (load > 0.0)
        load -= parameter(state, OWN_VERTICAL_DAMPING) * rate;
    if (bottom > 0.0)
        load += parameter(state, OWN_BOTTOM_STIFF) * bottom;
    return load < 0.0 ? 0.0 : load;
}

void hub_find(State *state)
{
    static const int scaled[] = FRICTION_PARAMETERS;
    Hub *hub = &state->hub;
    size_t i;

    wheel_motion(state->values + FIRST_INPUT, hub->results);
    memcpy(state->values + FIRST_COMPUTED, hub->results, N_MOTION_RESULTS * sizeof *hub->results);
    memcpy(hub->parameters, state->values + FIRST_PARAMETER, sizeof hub->parameters);
    for (i = 0; scaled[i] >= 0; i++)
        hub->parameters[scaled[i]] *= state->values[FIRST_INPUT + HOST_FRICTION];
    hub->results[DEFLECTION_RESULT] = parameter(state, OWN_UNLOADED_RADIUS) - hub->results[RADIUS_RESULT];
    find_spring(state);
    hub->results[LOAD_RESULT] = state->values[FIRST_INPUT + HOST_LOAD] = total_load(state);
}

void hub_arguments(const State *state, double arguments[])
{
    const double *inputs = state->values + FIRST_INPUT;
    size_t i;

    memcpy(arguments + HUB_WRENCH_R_11, inputs + WHEEL_MOTION_R_11, 9 * sizeof *arguments);
    memcpy(arguments + HUB_WRENCH_road_nx, inputs + WHEEL_MOTION_road_nx, 3 * sizeof *arguments);
    arguments[HUB_WRENCH_R_l] = state->hub.results[RADIUS_RESULT];
    memset(arguments + HUB_WRENCH_Fx, 0, (HUB_WRENCH_ARGUMENTS - HUB_WRENCH_Fx) * sizeof *arguments);
    for (i = 0; i < N_OUTPUTS; i++)
        arguments[HUB_WRENCH_Fx + FORCE[i]] = state->values[FIRST_OUTPUT + i];
    arguments[HUB_WRENCH_Fz] = state->hub.results[LOAD_RESULT];
}

void hub_add_forces(State *state)
{
    double arguments[HUB_WRENCH_ARGUMENTS];

    hub_arguments(state, arguments);
    hub_wrench(arguments, state->hub.results + WRENCH_RESULT);
}
