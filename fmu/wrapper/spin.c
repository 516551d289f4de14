/* The spin of the wheel as a state: torques, and the sense of the brake.  See spin.h. */
#include "spin.h"

#include <math.h>

static double drive_of(const State *state) { return state->values[FIRST_INPUT + HOST_DRIVE]; }

double spin_free_torque(const State *state) { return drive_of(state) + state->hub.results[SPIN_MOMENT]; }

static int sign_of(double x) { return x > 0.0 ? 1 : x < 0.0 ? -1 : 0; }

int spin_sense_at_rest(const State *state)
{
    return fabs(spin_free_torque(state)) <= spin_brake(state) ? 0 : sign_of(spin_free_torque(state));
}

/* Before the first event of Model Exchange, and in Co-Simulation, the sense follows from the present values. */
int spin_sense(const State *state)
{
    if (state->kind == MODEL_EXCHANGE && state_has_begun(state))
        return state->brake_sense;
    return spin_of(state) != 0.0 ? sign_of(spin_of(state)) : spin_sense_at_rest(state);
}

int spin_is_held(const State *state) { return spin_sense(state) == 0; }

static double braking(const State *state)
{
    return spin_is_held(state) ? -spin_free_torque(state) : -spin_sense(state) * spin_brake(state);
}

void spin_show(State *state)
{
    state->values[SPIN_RATE] =
        spin_is_held(state) ? 0.0 : (spin_free_torque(state) + braking(state)) * spin_gain(state);
    if (state->kind == MODEL_EXCHANGE)
        state->hub.results[BRAKE_RESULT] = braking(state);
}

double spin_indicator(const State *state)
{
    return spin_is_held(state) ? spin_brake(state) - fabs(spin_free_torque(state)) : spin_of(state);
}

double spin_gain(const State *state)
{
    return spin_is_held(state) ? 0.0 : 1.0 / state->values[FIRST_PARAMETER + OWN_WHEEL_INERTIA];
}

double spin_margin_by_moment(const State *state) { return spin_is_held(state) ? -sign_of(spin_free_torque(state)) : 0.0; }

void spin_differentiate(const State *state, const double seeds[N_VALUES], double motion[N_MOTION])
{
    const double driven = seeds[FIRST_INPUT + HOST_DRIVE], braked = seeds[FIRST_INPUT + HOST_BRAKE];
    const double heavier = seeds[FIRST_PARAMETER + OWN_WHEEL_INERTIA];
    const int sense = spin_sense(state);

    motion[SPIN_MOVED] = seeds[SPIN_VALUE];
    motion[SPIN_PUSHED] = spin_gain(state) * (driven - sense * braked - heavier * state->values[SPIN_RATE]);
    motion[SPIN_MARGIN] = braked + spin_margin_by_moment(state) * driven;
    if (state->kind == MODEL_EXCHANGE) /* in Co-Simulation it is the mean of the last step */
        motion[HUB_CHANGE + BRAKE_RESULT] = sense == 0 ? -driven : -sense * braked;
}
