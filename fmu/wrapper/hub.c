/* Motion, load and forces of a wheel at its hub.  See hub.h. */
#include "hub.h"

#include "wheel_kinematics.h"

#include <string.h>

/* wheel_motion reads the first inputs of the host, and its results are those of the hub. */
typedef char motion_fits[WHEEL_MOTION_ARGUMENTS <= N_HOST_INPUTS && (int) WHEEL_MOTION_RESULTS == LOAD_RESULT ? 1 : -1];
typedef char wrench_fits[(int) HUB_WRENCH_RESULTS == BRAKE_RESULT - WRENCH_RESULT ? 1 : -1];

static double total_load(const State *state)
{
    const double radius = state->hub.results[RADIUS_RESULT], rate = state->hub.results[RADIUS_RATE_RESULT];
    const double bottom = hub_parameter(state, OWN_BOTTOM_RADIUS) - radius;
    double load = state->hub.spring;

    if (load > 0.0)
        load -= hub_parameter(state, OWN_VERTICAL_DAMPING) * rate;
    if (bottom > 0.0)
        load += hub_parameter(state, OWN_BOTTOM_STIFF) * bottom;
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
    hub->results[DEFLECTION_RESULT] = hub_parameter(state, OWN_UNLOADED_RADIUS) - hub->results[RADIUS_RESULT];
    hub_find_spring(state);
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
        arguments[HUB_WRENCH_Fx + HUB_FORCE[i]] = state->values[FIRST_OUTPUT + i];
    arguments[HUB_WRENCH_Fz] = state->hub.results[LOAD_RESULT];
}

void hub_add_forces(State *state)
{
    double arguments[HUB_WRENCH_ARGUMENTS];

    hub_arguments(state, arguments);
    hub_wrench(arguments, state->hub.results + WRENCH_RESULT);
}
