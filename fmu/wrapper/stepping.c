/* Steps of Co-Simulation.  See instance.h. */
#include "instance.h"

#include "outputs.h"
#include "spin.h"
#include "steps.h"

#include <math.h>
#include <string.h>

/* Whether two times differ by rounding of the host only. */
static int same_time(double a, double b) { return fabs(a - b) <= 1e-9 * (1.0 + fabs(b)); }

#if N_STATES > 0
/* Integrate the states, and refuse those that are not finite.  `size` becomes the integrated time. */
static Status advance(Instance *self, double *size)
{
    State *state = &self->state;
    Status status;

#if SPIN
    *size = spin_advance(state, *size, self->returns_early);
#else
    state_integrate(state, *size);
#endif
    status = instance_expect_finite(self, state->continuous.lagging, N_LAGGING, "a lagged slip");
    if (status == STATUS_OK)
        status = instance_expect_finite(self, &state->continuous.distance, 1, "the distance");
#if N_MEMORY > 0
    if (status == STATUS_OK)
        status = instance_expect_finite(self, state->continuous.memory, N_MEMORY, "a state");
#endif
#if SPIN
    if (status == STATUS_OK)
        status = instance_expect_finite(self, state->values + FIRST_INPUT + HOST_SPIN, 1, "the spin");
#endif
    return status;
}
#endif

/* Integrate with constant inputs; `size` as above. */
static Status advance_held(Instance *self, double *size)
{
#if N_STATES > 0
    if (advance(self, size) != STATUS_OK)
        return STATUS_DISCARD;
#if defined DISTANCE || HUB
    state_changed(&self->state); /* the model reads the distance; the load depends on the slips */
#endif
#else
    (void) self, (void) size;
#endif
    return STATUS_OK;
}

/* Set the inputs to their values at a time after the start of the step. */
static Status move_inputs(Instance *self, const double start[], double time)
{
    State *state = &self->state;
    double x;
    size_t i;

    for (i = 0; i < N_HOST_INPUTS; i++) {
        const size_t reference = FIRST_INPUT + i;

        if (state->slopes[i] == 0.0)
            continue;
        x = start[reference] + state->slopes[i] * time;
        if (instance_expect_allowed(self, (unsigned) reference, x) != STATUS_OK)
            return STATUS_DISCARD;
        state->values[reference] = x;
    }
    state_changed(state);
    return STATUS_OK;
}

/* Integrate over a step in which inputs have slopes, as FMI 2 has them: they have their mean value in each part of it, and
   at its end their last value. */
static Status advance_sloped(Instance *self, double size)
{
    const int parts = step_parts(size);
    double part = size / parts, start[FIRST_OUTPUT];
    Status status = STATUS_OK;
    int i;

    memcpy(start, self->state.values, sizeof start);
    for (i = 0; i < parts && status == STATUS_OK; i++) {
        status = move_inputs(self, start, (i + 0.5) * part);
        if (status == STATUS_OK)
            status = advance_held(self, &part);
    }
    if (status == STATUS_OK)
        status = move_inputs(self, start, size);
    memset(self->state.slopes, 0, sizeof self->state.slopes);
    self->state.interpolates = 0;
    return status;
}

/* Integrate a step, or change nothing; `size` becomes the integrated time.  A step of a wheel whose inputs are constant
   changes the integrated states alone, and what is computed from them. */
static Status integrate(Instance *self, double *size)
{
    if (HUB || self->state.interpolates) {
        const State before = self->state;
        const Status status = before.interpolates ? advance_sloped(self, *size) : advance_held(self, size);

        if (status != STATUS_OK)
            self->state = before;
        return status;
    } else {
        const Continuous before = self->state.continuous;
        const Status status = advance_held(self, size);

        if (status != STATUS_OK) {
            self->state.continuous = before;
            state_changed(&self->state);
        }
        return status;
    }
}

Status instance_set_slopes(Instance *self, const unsigned references[], size_t n, const int orders[],
                           const double slopes[])
{
    size_t i;

    if (instance_expect_known(self, references, n) != STATUS_OK ||
        instance_expect_pointer(self, orders, n, "orders") != STATUS_OK ||
        instance_expect_pointer(self, slopes, n, "derivatives") != STATUS_OK ||
        instance_expect(self, STEPPING, STEPPING, "setting derivatives of inputs") != STATUS_OK)
        return STATUS_ERROR;
    for (i = 0; i < n; i++) {
        if (value_kind(references[i]) != INPUT || orders[i] != 1)
            return instance_refuse(self, STATUS_ERROR, "only inputs have derivatives, of order 1");
        if (!isfinite(slopes[i]))
            return instance_refuse(self, STATUS_DISCARD, "the derivative of %s must be finite, not %g",
                                   value_name(references[i]), slopes[i]);
    }
    for (i = 0; i < n; i++)
        self->state.slopes[references[i] - FIRST_INPUT] = slopes[i];
    self->state.interpolates = 0;
    for (i = 0; i < N_HOST_INPUTS; i++)
        if (self->state.slopes[i] != 0.0)
            self->state.interpolates = 1;
    return STATUS_OK;
}

int instance_had_event(const Instance *self)
{
#if SPIN
    return self->state.event;
#else
    (void) self;
    return 0;
#endif
}

Status instance_step(Instance *self, double point, double size)
{
    double intended, integrated;

    if (instance_expect(self, STEPPING, STEPPING, "a step") != STATUS_OK)
        return STATUS_ERROR;
    if (!isfinite(size) || size < 0.0)
        return instance_refuse(self, STATUS_ERROR, "the step size must be positive and finite, not %g", size);
    if (!isfinite(point) || !same_time(point, self->state.values[TIME]))
        return instance_refuse(self, STATUS_ERROR, "the step starts at t = %.17g, the last one ended at %.17g",
                               point, self->state.values[TIME]);
    if (!isfinite(point + size))
        return instance_refuse(self, STATUS_ERROR, "the step ends at t = %g", point + size);
    if (self->state.stop_defined && point + size > self->state.stop_time &&
        !same_time(point + size, self->state.stop_time))
        return instance_refuse(self, STATUS_ERROR, "the step ends at t = %.17g, after the stop time %.17g",
                               point + size, self->state.stop_time);
    if (size == 0.0) /* FMI does not allow it, but some hosts begin with such a step */
        return STATUS_OK;
    intended = integrated = step_intended(point, size);
    if (integrate(self, &integrated) != STATUS_OK)
        return STATUS_DISCARD;
    /* From the host's times, so that rounding errors do not accumulate. */
    self->state.values[TIME] = point + (integrated < intended ? integrated : size);
    return STATUS_OK;
}
