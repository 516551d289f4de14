/* Reading and setting of values.  See instance.h. */
#include "instance.h"

#include "outputs.h"

#include <math.h>

static const char *const MODEL_INPUTS[] = MODEL_INPUT_NAMES;

Status instance_expect_known(const Instance *self, const unsigned references[], size_t n)
{
    size_t i;

    if (instance_expect_pointer(self, references, n, "value references") != STATUS_OK)
        return STATUS_ERROR;
    for (i = 0; i < n; i++)
        if (references[i] >= self->tire.count || value_kind(references[i]) == HIDDEN)
            return instance_refuse(self, STATUS_ERROR, "there is no value reference %u", references[i]);
    return STATUS_OK;
}

typedef char inputs_have_bits[N_INPUTS < 8 * sizeof(unsigned) ? 1 : -1];

/* Whether the log has no warning of this bit yet; it then gets one. */
static int warns_first(Instance *self, unsigned i)
{
    const int first = !(self->warned >> i & 1u);

    self->warned |= 1u << i;
    return first;
}

/* Log once of each input that it is outside the valid range of the tire, and once that the wheel stands: hosts pass 0 for
   inputs that nobody sets. */
static void watch_inputs(Instance *self)
{
    double (*ranges)[2] = self->tire.ranges;
    unsigned i;

    for (i = 0; i < N_INPUTS; i++) {
        const double x = self->state.contact.inputs[i];

        if ((x < ranges[i][0] || x > ranges[i][1]) && warns_first(self, i))
            instance_refuse(self, STATUS_WARNING, "%s = %g is outside %g ... %g, the valid range of the tire",
                            MODEL_INPUTS[i], x, ranges[i][0], ranges[i][1]);
    }
#ifdef HOST_SPEED
    if (self->state.values[FIRST_INPUT + HOST_SPEED] == 0.0 && warns_first(self, N_INPUTS))
        instance_refuse(self, STATUS_WARNING, "%s = 0: the wheel stands, or the host does not set its speed",
                        value_name(FIRST_INPUT + HOST_SPEED));
#endif
}

Status instance_get(Instance *self, const unsigned references[], size_t n, double values[])
{
    size_t i;

    if (instance_expect_known(self, references, n) != STATUS_OK ||
        instance_expect_pointer(self, values, n, "values") != STATUS_OK)
        return STATUS_ERROR;
    for (i = 0; i < n; i++) {
        if (value_kind(references[i]) == OUTPUT || value_kind(references[i]) == LOCAL || value_kind(references[i]) == STORED) {
            if (self->state.known < OUTPUTS_KNOWN) {
                state_compute_outputs(&self->state);
                watch_inputs(self);
            }
            if (references[i] >= FIRST_EXTRA)
                state_compute_extras(&self->state);
            else if (references[i] >= FIRST_DERIVATIVE)
                state_compute_rates(&self->state);
        }
        values[i] = self->state.values[references[i]];
    }
    for (i = 0; i < n; i++)
        if (instance_expect_finite(self, values + i, 1, value_name(references[i])) != STATUS_OK)
            return STATUS_DISCARD;
    return STATUS_OK;
}

/* Whether the host may set this value in the present mode.  In continuous-time mode hosts also set states as other
   values, and parameters that have not changed. */
static Status expect_settable(const Instance *self, unsigned reference, double value)
{
    const int kind = value_kind(reference), mode = self->state.mode;

    if (kind == INPUT || (kind == STORED && mode <= INITIALIZATION) || (mode == CONTINUOUS && value_is_state(reference)))
        return STATUS_OK;
    if (kind == PARAMETER && (mode != CONTINUOUS || value == self->state.values[reference]))
        return STATUS_OK;
    if (kind == PARAMETER)
        return instance_refuse(self, STATUS_ERROR, "%s can be set in event mode, not in continuous-time mode",
                               value_name(reference));
    return instance_refuse(self, STATUS_ERROR, "%s cannot be set", value_name(reference));
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

        if (expect_settable(self, r, values[i]) != STATUS_OK)
            return STATUS_ERROR;
        if (instance_expect_allowed(self, r, values[i]) != STATUS_OK)
            return STATUS_DISCARD;
    }
    for (i = 0; i < n; i++) {
        self->state.values[references[i]] = values[i];
        if (value_kind(references[i]) != INPUT && value_is_state(references[i]))
            state_set(&self->state, references[i], values[i]);
    }
    state_changed(&self->state);
    return STATUS_OK;
}
