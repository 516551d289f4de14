/* The spin of the wheel as a state.  See spin.h. */
#include "spin.h"

#include "contact.h"
#include "root.h"

#include <math.h>

/* The oscillation of the wheel on the tire's spring takes some 30 ms, s. */
#define LONGEST_PART 1e-3
/* A longer step has longer parts, so that it ends. */
#define MOST_PARTS 10000
/* The error of a torque balance at which its solution ends, relative to the terms in it. */
#define ACCURACY 1e-13
#define LEAST_SPIN 1e-3
#define MOST_DOUBLINGS 60
/* The sense of a brake without torque in Co-Simulation. */
#define RELEASED 2

/* A part of a step, and the state at its end for the spin tried last. */
typedef struct {
    const State *begin;
    State *end;
    double size, gain, brake;
} Part;

static double spin_of(const State *state) { return state->values[SPIN_VALUE]; }

/* By how much the spin that the torques cause at the end of a part exceeds the given one. */
static double excess(void *context, double spin)
{
    Part *part = context;
    State *end = part->end;
    double torque;

    *end = *part->begin;
    end->values[SPIN_VALUE] = spin;
    end->values[FIRST_INPUT + HOST_TURNING] += spin - spin_of(part->begin);
    end->contact_known = end->lengths_known = 0;
    state_integrate(end, part->size);
    end->outputs_known = end->extras_known = 0;
    state_compute_outputs(end);
    torque = end->values[FIRST_INPUT + HOST_DRIVE] + end->hub.results[SPIN_MOMENT] + part->brake;
    return spin_of(part->begin) + part->gain * torque - spin;
}

/* The spin at the end of a part. */
static double solve(Part *part)
{
    const double start = spin_of(part->begin);
    const double moment = part->begin->hub.results[SPIN_MOMENT];
    const double accuracy = ACCURACY * (LEAST_SPIN + fabs(start) + part->gain * fabs(moment));
    Sample a = {start, 0.0}, b;
    int i;

    a.value = excess(part, a.x);
    if (!(fabs(a.value) > accuracy))
        return a.x;
    /* The moment falls with the spin, so that the solution is between the ends, unless the tire slides. */
    b.x = start + a.value;
    b.value = excess(part, b.x);
    for (i = 0; i < MOST_DOUBLINGS && b.value * a.value > 0.0; i++) {
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
static double advance_part(State *state, double size)
{
    const double capacity = state->values[FIRST_INPUT + HOST_BRAKE];
    const double gain = size / state->values[FIRST_PARAMETER + OWN_WHEEL_INERTIA];
    State begin = *state;
    Part part = {NULL, state, size, gain, 0.0};

    part.begin = &begin;
    if (capacity > 0.0) {
        const double free_spin = excess(&part, 0.0);

        if (fabs(free_spin) <= gain * capacity)
            return -free_spin / gain; /* held; `state` is the one at zero spin */
        part.brake = free_spin > 0.0 ? -capacity : capacity;
    }
    solve(&part);
    return part.brake;
}

/* ---------------------------------------------------------------- continuous time */

static double drive_of(const State *state) { return state->values[FIRST_INPUT + HOST_DRIVE]; }

static double capacity_of(const State *state) { return state->values[FIRST_INPUT + HOST_BRAKE]; }

/* The torque on the wheel without that of the brake. */
static double free_torque(const State *state) { return drive_of(state) + state->hub.results[SPIN_MOMENT]; }

static int sign_of(double x) { return x > 0.0 ? 1 : x < 0.0 ? -1 : 0; }

/* Before the first event of Model Exchange, and in Co-Simulation, the sense follows from the present values. */
static int sense_of(const State *state)
{
    if (state->kind == MODEL_EXCHANGE && state_has_begun(state))
        return state->brake_sense;
    if (spin_of(state) != 0.0)
        return sign_of(spin_of(state));
    return fabs(free_torque(state)) <= capacity_of(state) ? 0 : sign_of(free_torque(state));
}

int spin_is_held(const State *state) { return sense_of(state) == 0; }

static double braking(const State *state)
{
    return spin_is_held(state) ? -free_torque(state) : -sense_of(state) * capacity_of(state);
}

int spin_settle(State *state)
{
    const double before = spin_of(state);
    const int arrived = before * state->brake_sense <= 0.0 && state->brake_sense != 0;

    if (before == 0.0 || (arrived && capacity_of(state) > 0.0)) {
        state->values[SPIN_VALUE] = 0.0;
        state_changed(state);
        state_compute_outputs(state);
        state->brake_sense = fabs(free_torque(state)) <= capacity_of(state) ? 0 : sign_of(free_torque(state));
        if (state->brake_sense != 0)
            state->values[SPIN_VALUE] = before;
    } else {
        state->brake_sense = sign_of(before);
    }
    state_changed(state);
    return spin_of(state) != before;
}

void spin_show(State *state)
{
    state->values[SPIN_RATE] =
        spin_is_held(state) ? 0.0 : (free_torque(state) + braking(state)) * spin_gain(state);
    if (state->kind == MODEL_EXCHANGE)
        state->hub.results[BRAKE_RESULT] = braking(state);
}

double spin_indicator(const State *state)
{
    return spin_is_held(state) ? capacity_of(state) - fabs(free_torque(state)) : spin_of(state);
}

double spin_gain(const State *state)
{
    return spin_is_held(state) ? 0.0 : 1.0 / state->values[FIRST_PARAMETER + OWN_WHEEL_INERTIA];
}

double spin_margin_by_moment(const State *state) { return spin_is_held(state) ? -sign_of(free_torque(state)) : 0.0; }

void spin_differentiate(const State *state, const double seeds[N_VALUES], double motion[N_MOTION])
{
    const double driven = seeds[FIRST_INPUT + HOST_DRIVE], braked = seeds[FIRST_INPUT + HOST_BRAKE];
    const double heavier = seeds[FIRST_PARAMETER + OWN_WHEEL_INERTIA];
    const int sense = sense_of(state);

    motion[SPIN_MOVED] = seeds[SPIN_VALUE];
    motion[SPIN_PUSHED] = spin_gain(state) * (driven - sense * braked - heavier * state->values[SPIN_RATE]);
    motion[SPIN_MARGIN] = braked + spin_margin_by_moment(state) * driven;
    if (state->kind == MODEL_EXCHANGE) /* in Co-Simulation it is the mean of the last step */
        motion[HUB_CHANGE + BRAKE_RESULT] = sense == 0 ? -driven : -sense * braked;
}

/* ---------------------------------------------------------------- steps */

static int sense_or_released(const State *state) { return capacity_of(state) > 0.0 ? sense_of(state) : RELEASED; }

void spin_begin(State *state)
{
    state_compute_outputs(state);
    state->brake_sense = sense_or_released(state);
}

double spin_advance(State *state, double h, int stops_at_event)
{
    /* The sizes of steps that are equal but for rounding have equal numbers of parts. */
    const double wanted = ceil(h / LONGEST_PART * (1.0 - 1e-9));
    const int parts = wanted < MOST_PARTS ? (int) wanted : MOST_PARTS;
    double braked = 0.0;
    int i = 0;

    state_compute_outputs(state);
    state->event = 0;
    while (i < parts && !(state->event && stops_at_event)) {
        int sense;

        braked += advance_part(state, h / parts);
        i++;
        sense = sense_or_released(state);
        state->event |= sense != state->brake_sense && sense != RELEASED && state->brake_sense != RELEASED;
        state->brake_sense = sense;
    }
    state->hub.results[BRAKE_RESULT] = braked / i;
    return i < parts ? i * (h / parts) : h;
}
