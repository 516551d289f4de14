/* Values: get, set, and compute.  See instance.h. */
#include "instance.h"

#include "contact.h"
#include "hub.h"
#include "memory.h"
#include "slips.h"
#include "spin.h"

#include <math.h>
#include <string.h>

static const char *const NAMES[] = VALUE_NAMES;
static const double NOMINAL[] = NOMINAL_VALUES;
static const unsigned char KINDS[] = VALUE_KINDS;
static const int EXTRA[] = EXTRAS;
/* -1 where host and model use opposite signs. */
static const signed char DIRECTIONS[] = VALUE_DIRECTIONS;
/* By output of the model: its sign for a wheel that rolls backward. */
static const signed char BACKWARD[] = BACKWARD_SIGNS;
static const char *const MODEL_INPUTS[] = MODEL_INPUT_NAMES;

/* The generated header and the model's code must have the same number of values. */
#define HAS(table, n) (sizeof(table) / sizeof *(table) == (n) ? 1 : -1)
typedef char names_are_complete[HAS(NAMES, N_VALUES)];
typedef char sizes_are_complete[HAS(NOMINAL, N_VALUES)];
typedef char kinds_are_complete[HAS(KINDS, N_VALUES)];
typedef char directions_are_complete[HAS(DIRECTIONS, N_VALUES)];
typedef char extras_are_complete[HAS(EXTRA, N_EXTRAS)];

const char *value_name(unsigned reference) { return NAMES[reference]; }

int value_kind(unsigned reference) { return KINDS[reference]; }

double value_scale(const State *state, unsigned reference)
{
    const double size = fabs(state->values[reference]);
    const double nominal = NOMINAL[reference] > 0.0 ? NOMINAL[reference] : 1.0;

    return size > nominal || KINDS[reference] == PARAMETER ? (size > 0.0 ? size : 1.0) : nominal;
}

int value_shows(unsigned reference) { return EXTRA[reference - FIRST_EXTRA]; }

double value_direction(unsigned reference) { return DIRECTIONS[reference]; }

double output_sign(double sense, size_t output) { return sense < 0.0 ? BACKWARD[output] : 1.0; }

double host_value(const State *state, size_t reference)
{
    return state->values[reference] * DIRECTIONS[reference];
}

const double *model_parameters(const State *state)
{
#if HUB
    return state->hub.parameters;
#else
    return state->values + FIRST_PARAMETER;
#endif
}

Status instance_expect_known(const Instance *self, const unsigned references[], size_t n)
{
    size_t i;

    if (instance_expect_pointer(self, references, n, "value references") != STATUS_OK)
        return STATUS_ERROR;
    for (i = 0; i < n; i++)
        if (references[i] >= self->tire.count || KINDS[references[i]] == HIDDEN)
            return instance_refuse(self, STATUS_ERROR, "there is no value reference %u", references[i]);
    return STATUS_OK;
}

/* ---------------------------------------------------------------- computing */

#if N_MEMORY > 0
/* Before the end of initialization a state is in equilibrium, or has its start value. */
static void show_memory(State *state, double states[], double rates[])
{
    double inputs[N_INPUTS], events[N_MEMORY];
    size_t i;

    memcpy(inputs, state->contact.inputs, sizeof inputs);
    memory_fill(state, inputs);
    for (i = 0; i < N_MEMORY; i++)
        states[i] = inputs[memory_input(i)];
    memory_rates(state, rates, events);
}
#endif

/* Write the states and their derivatives to the values, in the host's signs. */
static void show_states(State *state)
{
#if N_STATES > 0
    double *states = state->values + FIRST_STATE, *rates = state->values + FIRST_DERIVATIVE;
    size_t i;

    slips_show(state, states, rates);
#if N_MEMORY > 0
    show_memory(state, states + FIRST_MEMORY - FIRST_STATE, rates + FIRST_MEMORY - FIRST_STATE);
#endif
#ifdef DISTANCE
    states[N_STATES - 1] = state->distance;
    rates[N_STATES - 1] = state->contact.speed;
#endif
    for (i = 0; i < N_STATES; i++) {
        states[i] *= DIRECTIONS[FIRST_STATE + i];
        rates[i] *= DIRECTIONS[FIRST_DERIVATIVE + i];
    }
#else
    (void) state;
#endif
}

void state_compute_outputs(State *state)
{
    double inputs[N_INPUTS], *forces = state->values + FIRST_OUTPUT;
    size_t i;

    if (state->outputs_known)
        return;
    contact_find(state);
    slips_acting(state, inputs);
    contact_forces(state, inputs, forces);
    for (i = 0; i < N_OUTPUTS; i++)
        forces[i] *= DIRECTIONS[FIRST_OUTPUT + i];
#if HUB
    hub_add_forces(state);
#endif
#if SPIN
    spin_show(state);
#endif
    show_states(state);
    state->outputs_known = 1;
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

void state_compute_extras(State *state)
{
    double inputs[N_INPUTS], quantities[N_QUANTITIES], found;
    size_t i;
#if N_MEMORY > 0
    double rates[N_MEMORY], events[N_MEMORY];
#endif

    if (state->extras_known)
        return;
    state_compute_outputs(state);
    slips_acting(state, inputs);
    model_quantities(inputs, model_parameters(state), quantities);
#if N_MEMORY > 0
    memory_rates(state, rates, events);
#endif
    for (i = 0; i < N_EXTRAS; i++) {
        if (EXTRA[i] == FRICTION_USE)
            found = friction_use(state, quantities);
#if HUB
        else if (EXTRA[i] >= FIRST_HUB)
            found = state->hub.results[EXTRA[i] - FIRST_HUB];
#endif
#if SPIN
        else if (EXTRA[i] == BRAKE_EVENT)
            found = spin_indicator(state);
#endif
#if N_MEMORY > 0
        else if (EXTRA[i] >= FIRST_PATH)
            found = events[EXTRA[i] - FIRST_PATH];
#endif
        else if (EXTRA[i] == KAPPA_GIVEN)
            found = state->contact.sense * state->contact.inputs[KAPPA];
        else if (EXTRA[i] == ALPHA_GIVEN)
            found = state->contact.inputs[ALPHA];
        else if (EXTRA[i] == ALPHA_LAGGED)
            found = inputs[ALPHA];
        else
            found = quantities[EXTRA[i] - FIRST_QUANTITY];
        state->values[FIRST_EXTRA + i] = found * DIRECTIONS[FIRST_EXTRA + i];
    }
    state->extras_known = 1;
}

/* Log once that an input is outside the valid range of the tire. */
static void watch_range(Instance *self)
{
    double (*ranges)[2] = self->tire.ranges;
    size_t i;

    if (self->warned)
        return;
    for (i = 0; i < N_INPUTS; i++) {
        const double x = self->state.contact.inputs[i];

        if (x < ranges[i][0] || x > ranges[i][1]) {
            self->warned = 1;
            instance_refuse(self, STATUS_WARNING, "%s = %g is outside %g ... %g, the valid range of the tire",
                            MODEL_INPUTS[i], x, ranges[i][0], ranges[i][1]);
            return;
        }
    }
}

/* ---------------------------------------------------------------- reading and setting */

Status instance_get(Instance *self, const unsigned references[], size_t n, double values[])
{
    size_t i;

    if (instance_expect_known(self, references, n) != STATUS_OK ||
        instance_expect_pointer(self, values, n, "values") != STATUS_OK)
        return STATUS_ERROR;
    for (i = 0; i < n; i++) {
        if (KINDS[references[i]] == OUTPUT || KINDS[references[i]] == LOCAL || KINDS[references[i]] == STORED) {
            if (!self->state.outputs_known) {
                state_compute_outputs(&self->state);
                watch_range(self);
            }
            if (references[i] >= FIRST_EXTRA)
                state_compute_extras(&self->state);
        }
        values[i] = self->state.values[references[i]];
    }
    for (i = 0; i < n; i++)
        if (instance_expect_finite(self, values + i, 1, NAMES[references[i]]) != STATUS_OK)
            return STATUS_DISCARD;
    return STATUS_OK;
}

/* Whether the host may set this value in the present mode. */
static Status expect_settable(const Instance *self, unsigned reference)
{
    const int kind = KINDS[reference], mode = self->state.mode;

    if (kind == INPUT || (kind == STORED && mode <= INITIALIZATION))
        return STATUS_OK;
    if (kind == PARAMETER && mode != CONTINUOUS)
        return STATUS_OK;
    if (kind == PARAMETER)
        return instance_refuse(self, STATUS_ERROR, "%s can be set in event mode, not in continuous-time mode",
                               NAMES[reference]);
    return instance_refuse(self, STATUS_ERROR, "%s cannot be set", NAMES[reference]);
}

/* Set the start value of the distance or of the state of an effect; that of the spin is the value itself. */
static void store(State *state, unsigned reference, double value)
{
    if (reference < FIRST_STATE)
        return;
#if N_MEMORY > 0
    if (reference < FIRST_MEMORY + N_MEMORY) {
        state->memory[reference - FIRST_MEMORY] = value * DIRECTIONS[reference];
        return;
    }
#endif
    (void) reference;
    state->distance = value;
}

Status instance_set(Instance *self, const unsigned references[], size_t n, const double values[])
{
    size_t i;

    if (instance_expect_known(self, references, n) != STATUS_OK ||
        instance_expect_pointer(self, values, n, "values") != STATUS_OK)
        return STATUS_ERROR;
    if (self->state.mode == TERMINATED)
        return instance_refuse(self, STATUS_ERROR, "values cannot be set while terminated");
    for (i = 0; i < n; i++) {
        const unsigned r = references[i];

        if (expect_settable(self, r) != STATUS_OK)
            return STATUS_ERROR;
        if (!isfinite(values[i]))
            return instance_refuse(self, STATUS_DISCARD, "%s must be finite, not %g", NAMES[r], values[i]);
        if (values[i] < self->tire.lower[r] || values[i] > self->tire.upper[r])
            return instance_refuse(self, STATUS_DISCARD, "%s = %g is outside %g ... %g", NAMES[r], values[i],
                                   self->tire.lower[r], self->tire.upper[r]);
    }
    for (i = 0; i < n; i++) {
        self->state.values[references[i]] = values[i];
        if (KINDS[references[i]] == STORED)
            store(&self->state, references[i], values[i]);
    }
    state_changed(&self->state);
    return STATUS_OK;
}
