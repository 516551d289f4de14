/* The life cycle of an instance.  See instance.h. */
#include "instance.h"

#include "effect_states.h"
#include "outputs.h"
#include "slips.h"
#include "spin.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static void start_again(Instance *self)
{
    const int kind = self->state.kind;

    memset(&self->state, 0, sizeof self->state); /* padding too: equal states have equal bytes */
    memcpy(self->state.token, self->tire.token, sizeof self->state.token);
    self->state.kind = (int) kind;
    self->state.mode = INSTANTIATED;
#ifdef DISTANCE
    self->state.continuous.distance = self->tire.starts[FIRST_STATE + N_STATES - 1];
#endif
#if N_MEMORY > 0
    memcpy(self->state.continuous.memory, self->tire.starts + FIRST_MEMORY, sizeof self->state.continuous.memory);
#endif
    self->warned = 0;
    memcpy(self->state.values, self->tire.starts, sizeof self->state.values);
}

Instance *instance_create(const char *name, const char *token, const char *resources, Kind kind, int logs_events,
                          LogCallback *log_message, void (*logger)(void), void *environment)
{
    Instance *self = calloc(1, sizeof *self);
    const char *given_name = name ? name : "", *problem;

    if (!self)
        return NULL;
    self->log_message = log_message;
    self->logger = logger;
    self->environment = environment;
    self->logs_events = logs_events;
    self->logs_warnings = self->logs_discards = self->logs_errors = 1;
    self->state.kind = (int) kind;
    self->name = malloc(strlen(given_name) + 1);
    if (!self->name) {
        free(self);
        return NULL;
    }
    strcpy(self->name, given_name);
    problem = tire_find(resources, &self->tire);
    if (problem) {
        instance_refuse(self, STATUS_ERROR, "%s", problem);
        instance_free(self);
        return NULL;
    }
    if (!token || strcmp(token, self->tire.token) != 0) {
        instance_refuse(self, STATUS_ERROR, "the token of the model description differs from the token of this binary");
        instance_free(self);
        return NULL;
    }
    start_again(self);
    return self;
}

void instance_free(Instance *self)
{
    if (self)
        free(self->name);
    free(self);
}

static Status expect_mode(const Instance *self, Mode mode, const char *what)
{
    return instance_expect(self, mode, mode, what);
}

Status instance_set_experiment(Instance *self, double start, int stop_defined, double stop)
{
    if (expect_mode(self, INSTANTIATED, "setting up the experiment") != STATUS_OK)
        return STATUS_ERROR;
    if (!isfinite(start) || (stop_defined && !(stop >= start)))
        return instance_refuse(self, STATUS_ERROR, "an experiment cannot run from t = %g to t = %g", start,
                               stop_defined ? stop : HUGE_VAL);
    self->state.values[TIME] = start;
    self->state.stop_defined = stop_defined != 0;
    self->state.stop_time = stop_defined ? stop : 0.0;
    return STATUS_OK;
}

Status instance_enter_initialization(Instance *self)
{
    if (expect_mode(self, INSTANTIATED, "initialization") != STATUS_OK)
        return STATUS_ERROR;
    self->state.mode = INITIALIZATION;
    return STATUS_OK;
}

Status instance_exit_initialization(Instance *self)
{
    if (expect_mode(self, INITIALIZATION, "the end of initialization") != STATUS_OK)
        return STATUS_ERROR;
    state_find_contact(&self->state);
    slips_begin(&self->state);
#if N_MEMORY > 0
    memory_begin(&self->state);
#endif
#if SPIN
    if (self->state.kind == MODEL_EXCHANGE)
        spin_settle(&self->state);
    else
        spin_begin(&self->state);
#endif
    if (*self->tire.note)
        instance_refuse(self, STATUS_OK, "%s", self->tire.note);
    self->state.mode = self->state.kind == MODEL_EXCHANGE || self->has_event_mode ? EVENT : STEPPING;
    return STATUS_OK;
}

Status instance_terminate(Instance *self)
{
    if (!self)
        return STATUS_ERROR;
    if (!state_has_begun(&self->state) || self->state.mode == TERMINATED)
        return expect_mode(self, self->state.kind == MODEL_EXCHANGE ? CONTINUOUS : STEPPING, "terminating");
    self->state.mode = TERMINATED;
    return STATUS_OK;
}

Status instance_reset(Instance *self)
{
    if (!self)
        return STATUS_ERROR;
    start_again(self);
    return STATUS_OK;
}
