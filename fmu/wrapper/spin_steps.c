/* The spin of the wheel in steps and at events.  See spin.h. */
#include "spin.h"

#include "outputs.h"
#include "root.h"
#include "steps.h"

#include <math.h>

/* The error of a torque balance at which its solution ends, relative to the terms in it. */
#define TORQUE_ACCURACY 1e-13
#define MIN_SPIN 1e-3
#define MAX_DOUBLINGS 60
/* The sense of a brake without torque in Co-Simulation. */
#define RELEASED 2

/* A part of a step; `state` is at its end, for the spin tried last. */
typedef struct {
    State *state;
    Continuous begin;
    double spin, turning, moment; /* at the begin */
    double size, gain, brake;
} Part;

/* By how much the spin that the torques cause at the end of a part exceeds the given one.  The load is constant. */
static double excess(void *context, double spin)
{
    const Part *part = context;
    State *end = part->state;

    end->continuous = part->begin;
    end->values[SPIN_VALUE] = spin;
    end->values[FIRST_INPUT + HOST_TURNING] = part->turning + (spin - part->spin);
    end->known = LOAD_KNOWN;
    state_integrate(end, part->size);
    state_compute_outputs(end);
    return part->spin + part->gain * (spin_free_torque(end) + part->brake) - spin;
}

/* The spin at the end of a part. */
static double solve(Part *part)
{
    const double start = part->spin;
    const double accuracy = TORQUE_ACCURACY * (MIN_SPIN + fabs(start) + part->gain * fabs(part->moment));
    Sample a = {start, 0.0}, b;
    int i;

    a.value = excess(part, a.x);
    if (!(fabs(a.value) > accuracy))
        return a.x;
    /* The moment falls with the spin, so that the solution is between the ends, unless the tire slides. */
    b.x = start + a.value;
    b.value = excess(part, b.x);
    for (i = 0; i < MAX_DOUBLINGS && b.value * a.value > 0.0; i++) {
        b.x += b.x - start;
        b.value = excess(part, b.x);
    }
    if (b.value * a.value > 0.0) { /* the tire turns the wheel the faster, the faster it turns: one explicit step */
        b.x = start + a.value;
        excess(part, b.x);
        return b.x;
    }
    if (!(fabs(b.value) > accuracy))
        return b.x;
    return root_between(excess, part, a, b, accuracy);
}

/* Returns the torque of the brake. */
static double advance_spin(State *state, double size)
{
    const double capacity = spin_brake(state), gain = size / state->values[FIRST_PARAMETER + OWN_WHEEL_INERTIA];
    Part part = {.state = state, .begin = state->continuous, .spin = spin_of(state), .size = size, .gain = gain};

    part.turning = state->values[FIRST_INPUT + HOST_TURNING];
    part.moment = state->hub.results[SPIN_MOMENT];
    if (capacity > 0.0) {
        const double free_spin = excess(&part, 0.0);

        if (fabs(free_spin) <= gain * capacity)
            return -free_spin / gain; /* held; `state` is the one at zero spin */
        part.brake = free_spin > 0.0 ? -capacity : capacity;
    }
    solve(&part);
    return part.brake;
}

int spin_settle(State *state)
{
    const double before = spin_of(state);
    const int arrived = before * state->brake_sense <= 0.0 && state->brake_sense != 0;

    if (before == 0.0 || (arrived && spin_brake(state) > 0.0)) {
        state->values[SPIN_VALUE] = 0.0;
        state_changed(state);
        state_compute_outputs(state);
        state->brake_sense = spin_sense_at_rest(state);
        if (state->brake_sense != 0)
            state->values[SPIN_VALUE] = before;
    } else {
        state->brake_sense = before > 0.0 ? 1 : -1;
    }
    state_changed(state);
    return spin_of(state) != before;
}

static int sense_or_released(const State *state) { return spin_brake(state) > 0.0 ? spin_sense(state) : RELEASED; }

void spin_begin(State *state)
{
    state_compute_outputs(state);
    state->brake_sense = sense_or_released(state);
}

double spin_advance(State *state, double h, int stops_at_event)
{
    const int parts = step_parts(h);
    double braked = 0.0;
    int i = 0;

    state_compute_outputs(state);
    state->event = 0;
    while (i < parts && !(state->event && stops_at_event)) {
        int sense;

        braked += advance_spin(state, h / parts);
        i++;
        sense = sense_or_released(state);
        state->event |= sense != state->brake_sense && sense != RELEASED && state->brake_sense != RELEASED;
        state->brake_sense = sense;
    }
    state->hub.results[BRAKE_RESULT] = braked / i;
    return i < parts ? i * (h / parts) : h;
}
