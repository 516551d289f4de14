/* Event mode, of Model Exchange and of Co-Simulation in FMI 3.  See instance.h. */
#include "instance.h"

#include "outputs.h"
#include "slips.h"
#include "spin.h"

Status instance_use_events(Instance *self, int event_mode, int early_return)
{
    if (event_mode && !SPIN)
        return instance_refuse(self, STATUS_ERROR, "this FMU has no event mode in Co-Simulation");
    self->has_event_mode = event_mode;
    self->returns_early = early_return;
    return STATUS_OK;
}

/* FMI 2 also allows it in event mode. */
Status instance_enter_event(Instance *self)
{
    const Mode from = self && self->state.kind == MODEL_EXCHANGE ? CONTINUOUS : STEPPING;

    if (!self || (from == STEPPING && !self->has_event_mode))
        return instance_refuse(self, STATUS_ERROR, "event mode is not in use");
    if (instance_expect(self, from, from == CONTINUOUS ? EVENT : from, "event mode") != STATUS_OK)
        return STATUS_ERROR;
    self->state.mode = EVENT;
    return STATUS_OK;
}

Status instance_enter_continuous(Instance *self)
{
    if (instance_expect_exchange(self, "continuous-time mode") != STATUS_OK ||
        instance_expect(self, EVENT, EVENT, "continuous-time mode") != STATUS_OK)
        return STATUS_ERROR;
    self->state.mode = CONTINUOUS;
    return STATUS_OK;
}

Status instance_enter_stepping(Instance *self)
{
    if (!self || self->state.kind != CO_SIMULATION)
        return instance_refuse(self, STATUS_ERROR, "step mode is allowed in Co-Simulation only");
    if (instance_expect(self, EVENT, EVENT, "step mode") != STATUS_OK)
        return STATUS_ERROR;
    self->state.mode = STEPPING;
    return STATUS_OK;
}

/* In Co-Simulation the steps have already changed the discrete states. */
Status instance_update_discrete(Instance *self, int *states_changed)
{
    if (instance_expect(self, EVENT, EVENT, "an update of discrete states") != STATUS_OK ||
        instance_expect_pointer(self, states_changed, 1, "the event information") != STATUS_OK)
        return STATUS_ERROR;
    *states_changed = 0;
    if (self->state.kind == MODEL_EXCHANGE) {
        state_find_contact(&self->state);
        *states_changed = slips_settle(&self->state);
        if (*states_changed)
            state_changed(&self->state);
#if SPIN
        *states_changed |= spin_settle(&self->state);
#endif
    }
    return STATUS_OK;
}
