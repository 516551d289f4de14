/* Model Exchange: the host's solver integrates the states.  See instance.h. */
#include "instance.h"

#include "effect_states.h"
#include "outputs.h"
#include "spin.h"

#include <math.h>

static const double STATE_NOMINAL[] = STATE_NOMINALS;

static Status expect_array(const Instance *self, const double values[], size_t n, size_t expected, const char *what)
{
    if (n == expected)
        return instance_expect_pointer(self, values, n, what);
    return instance_refuse(self, STATUS_ERROR, "this FMU has %lu %s, not %lu", (unsigned long) expected, what,
                           (unsigned long) n);
}

Status instance_expect_exchange(const Instance *self, const char *what)
{
    if (!self)
        return STATUS_ERROR;
    if (self->state.kind != MODEL_EXCHANGE)
        return instance_refuse(self, STATUS_ERROR, "%s is allowed in Model Exchange only", what);
    return STATUS_OK;
}

Status instance_complete_step(Instance *self)
{
    if (instance_expect_exchange(self, "a completed integrator step") != STATUS_OK)
        return STATUS_ERROR;
    return instance_expect(self, CONTINUOUS, CONTINUOUS, "a completed integrator step");
}

Status instance_set_time(Instance *self, double time)
{
    if (instance_expect_exchange(self, "setting the time") != STATUS_OK ||
        instance_expect(self, CONTINUOUS, EVENT, "setting the time") != STATUS_OK)
        return STATUS_ERROR;
    if (!isfinite(time))
        return instance_refuse(self, STATUS_DISCARD, "the time must be finite, not %g", time);
    self->state.values[TIME] = time;
    return STATUS_OK;
}

/* The spin is the last state; the others are behind each other. */
static unsigned reference_of(size_t i) { return (unsigned) (SPIN && i == N_STATES ? SPIN_VALUE : FIRST_STATE + i); }

/* Copy states or derivatives from the values, in the host's signs. */
static Status copy_shown(Instance *self, size_t first, double shown[], size_t n, const char *what)
{
    size_t i;

    if (instance_expect_exchange(self, what) != STATUS_OK || expect_array(self, shown, n, N_CONTINUOUS, "states") != STATUS_OK)
        return STATUS_ERROR;
    if (self->state.mode == INSTANTIATED)
        return instance_refuse(self, STATUS_ERROR, "there are no %s while instantiated", what);
    state_compute_rates(&self->state);
    for (i = 0; i < n; i++)
        shown[i] = self->state.values[first == FIRST_STATE ? reference_of(i) : first + i];
    return instance_expect_finite(self, shown, n, what);
}

Status instance_get_states(Instance *self, double states[], size_t n)
{
    return copy_shown(self, FIRST_STATE, states, n, "states");
}

Status instance_get_rates(Instance *self, double rates[], size_t n)
{
    return copy_shown(self, FIRST_DERIVATIVE, rates, n, "derivatives");
}

Status instance_set_states(Instance *self, const double states[], size_t n)
{
    size_t i;

    if (instance_expect_exchange(self, "setting states") != STATUS_OK ||
        expect_array(self, states, n, N_CONTINUOUS, "states") != STATUS_OK ||
        instance_expect(self, CONTINUOUS, CONTINUOUS, "setting states") != STATUS_OK)
        return STATUS_ERROR;
    for (i = 0; i < n; i++)
        if (!isfinite(states[i]))
            return instance_refuse(self, STATUS_DISCARD, "%s must be finite, not %g",
                                   value_name(reference_of(i)), states[i]);
    for (i = 0; i < n; i++)
        state_set(&self->state, reference_of(i), states[i]);
    state_changed(&self->state);
    return STATUS_OK;
}

Status instance_get_nominals(Instance *self, double nominals[], size_t n)
{
    size_t i;

    if (instance_expect_exchange(self, "nominal values of states") != STATUS_OK ||
        expect_array(self, nominals, n, N_CONTINUOUS, "states") != STATUS_OK)
        return STATUS_ERROR;
    for (i = 0; i < n; i++)
        nominals[i] = STATE_NOMINAL[i];
    return STATUS_OK;
}

/* Where one changes sign, the derivative of a state along a path jumps; see effect_states.h.  The last one is that of the
   brake. */
Status instance_get_indicators(Instance *self, double indicators[], size_t n)
{
#if N_MEMORY > 0
    double rates[N_MEMORY], events[N_MEMORY];
    size_t i, k = 0;
#endif

    if (instance_expect_exchange(self, "event indicators") != STATUS_OK ||
        expect_array(self, indicators, n, N_INDICATORS, "event indicators") != STATUS_OK)
        return STATUS_ERROR;
    state_compute_outputs(&self->state);
#if N_MEMORY > 0
    memory_rates(&self->state, rates, events);
    for (i = 0; i < N_MEMORY; i++)
        if (memory_is_path(i))
            indicators[k++] = events[i];
#endif
#if SPIN
    indicators[N_INDICATORS - 1] = spin_indicator(&self->state);
#endif
    return instance_expect_finite(self, indicators, n, "an event indicator");
}
