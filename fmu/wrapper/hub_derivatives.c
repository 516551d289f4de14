/* The changes of the hub's values.  See hub.h. */
#include "hub.h"

#include "chain_rule.h"
#include "slips.h"
#include "tangents.h"
#include "wheel_kinematics.h"

#include <string.h>

#ifdef LOADED_RADIUS
/* The change of the model's loaded radius. */
static double radius_change(State *state, const double seeds[N_VALUES])
{
    Changes changes;

    changes_at_contact(&changes, state, seeds);
    return change_of_slot(&changes, ACTING, chain_quantity(LOADED_RADIUS));
}

/* By the theorem of implicit functions: the loaded radius under the spring's load is the given one. */
static double spring_change(const State *state, const double seeds[N_VALUES], double radius)
{
    double at_load[N_VALUES], by_load[N_VALUES] = {0.0};
    const double given = state->hub.radius == state->hub.results[RADIUS_RESULT] ? radius : 0.0;
    State spring = *state;

    spring.values[FIRST_INPUT + HOST_LOAD] = state->hub.spring;
    contact_find(&spring);
    slips_find_lengths(&spring);
    memcpy(at_load, seeds, sizeof at_load);
    at_load[FIRST_INPUT + HOST_LOAD] = 0.0;
    by_load[FIRST_INPUT + HOST_LOAD] = 1.0;
    return (given - radius_change(&spring, at_load)) / radius_change(&spring, by_load);
}
#else
static double spring_change(const State *state, const double seeds[N_VALUES], double radius)
{
    const double deflection = hub_parameter(state, OWN_UNLOADED_RADIUS) - state->hub.radius;

    return seeds[FIRST_PARAMETER + OWN_VERTICAL_STIFFNESS] * deflection +
           hub_parameter(state, OWN_VERTICAL_STIFFNESS) * (seeds[FIRST_PARAMETER + OWN_UNLOADED_RADIUS] - radius);
}
#endif

static double load_change(const State *state, const double seeds[N_VALUES], const double changes[])
{
    const double *results = state->hub.results, *moved = seeds + FIRST_PARAMETER;
    const double bottom = hub_parameter(state, OWN_BOTTOM_RADIUS) - results[RADIUS_RESULT];
    double change = 0.0;

    if (!(results[LOAD_RESULT] > 0.0))
        return 0.0;
    if (state->hub.spring > 0.0)
        change = spring_change(state, seeds, changes[RADIUS_RESULT]) -
                 hub_parameter(state, OWN_VERTICAL_DAMPING) * changes[RADIUS_RATE_RESULT] -
                 moved[OWN_VERTICAL_DAMPING] * results[RADIUS_RATE_RESULT];
    if (bottom > 0.0)
        change += moved[OWN_BOTTOM_STIFF] * bottom +
                  hub_parameter(state, OWN_BOTTOM_STIFF) * (moved[OWN_BOTTOM_RADIUS] - changes[RADIUS_RESULT]);
    return change;
}

/* The changes of the forces at the wheel centre at constant contact forces. */
static void change_wrench(const State *state, const double seeds[N_VALUES], double changes[N_HUB_RESULTS])
{
    double arguments[HUB_WRENCH_ARGUMENTS], moved[HUB_WRENCH_ARGUMENTS] = {0.0}, wrench[HUB_WRENCH_RESULTS];
    const double *inputs = seeds + FIRST_INPUT;

    hub_arguments(state, arguments);
    memcpy(moved + HUB_WRENCH_R_11, inputs + WHEEL_MOTION_R_11, 9 * sizeof *moved);
    memcpy(moved + HUB_WRENCH_road_nx, inputs + WHEEL_MOTION_road_nx, 3 * sizeof *moved);
    moved[HUB_WRENCH_R_l] = changes[RADIUS_RESULT];
    moved[HUB_WRENCH_Fz] = changes[LOAD_RESULT];
    hub_wrench_tangent(arguments, moved, wrench, changes + WRENCH_RESULT);
}

void hub_differentiate(const State *state, double seeds[N_VALUES], double changes[N_HUB_RESULTS])
{
    static const int scaled[] = FRICTION_PARAMETERS;
    double motion[WHEEL_MOTION_RESULTS];
    size_t i;

    wheel_motion_tangent(state->values + FIRST_INPUT, seeds + FIRST_INPUT, motion, changes);
    memcpy(seeds + FIRST_COMPUTED, changes, N_MOTION_RESULTS * sizeof *seeds);
    changes[DEFLECTION_RESULT] = seeds[FIRST_PARAMETER + OWN_UNLOADED_RADIUS] - changes[RADIUS_RESULT];
    for (i = 0; scaled[i] >= 0; i++) {
        seeds[FIRST_PARAMETER + scaled[i]] *= state->values[FIRST_INPUT + HOST_FRICTION];
        seeds[FIRST_PARAMETER + scaled[i]] +=
            seeds[FIRST_INPUT + HOST_FRICTION] * state->values[FIRST_PARAMETER + scaled[i]];
    }
    changes[LOAD_RESULT] = seeds[FIRST_INPUT + HOST_LOAD] = load_change(state, seeds, changes);
    changes[BRAKE_RESULT] = 0.0;
    change_wrench(state, seeds, changes);
}

void hub_by_forces(const State *state, unsigned result, double by[N_OUTPUTS])
{
    double arguments[HUB_WRENCH_ARGUMENTS], wrench[HUB_WRENCH_RESULTS];
    size_t i;

    hub_arguments(state, arguments);
    for (i = 0; i < N_OUTPUTS; i++) {
        memset(arguments + HUB_WRENCH_Fx, 0, (HUB_WRENCH_ARGUMENTS - HUB_WRENCH_Fx) * sizeof *arguments);
        arguments[HUB_WRENCH_Fx + HUB_FORCE[i]] = 1.0;
        hub_wrench(arguments, wrench);
        by[i] = wrench[result - WRENCH_RESULT];
    }
}
