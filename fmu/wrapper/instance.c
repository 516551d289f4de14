/* The life cycle of an instance and its log.  See instance.h. */
#include "instance.h"

#include "contact.h"
#include "memory.h"
#include "slips.h"
#include "spin.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---------------------------------------------------------------- life cycle and log */

static void start_again(Instance *self)
{
    const int kind = self->state.kind;

    memset(&self->state, 0, sizeof self->state); /* padding too: equal states have equal bytes */
    memcpy(self->state.token, self->tire.token, sizeof self->state.token);
    self->state.kind = kind;
    self->state.mode = INSTANTIATED;
#ifdef DISTANCE
    self->state.distance = self->tire.starts[FIRST_STATE + N_STATES - 1];
#endif
#if N_MEMORY > 0
    memcpy(self->state.memory, self->tire.starts + FIRST_MEMORY, sizeof self->state.memory);
#endif
#if ROAD
    self->state.road = self->road;
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
#if ROAD
    if (!problem)
        problem = road_open(resources, &self->road);
#endif
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
    if (self) {
#if ROAD
        road_close(self->road);
#endif
        free(self->name);
    }
    free(self);
}

/* The log category of a status, or NULL if the host has switched it off. */
static const char *category(const Instance *self, Status status)
{
    if (status == STATUS_OK)
        return self->logs_events ? "logEvents" : NULL;
    if (status == STATUS_WARNING)
        return self->logs_warnings ? "logStatusWarning" : NULL;
    if (status == STATUS_DISCARD)
        return self->logs_discards ? "logStatusDiscard" : NULL;
    return self->logs_errors ? "logStatusError" : NULL;
}

Status instance_refuse(const Instance *self, Status status, const char *format, ...)
{
    char message[256];
    va_list arguments;

    if (!self || !self->logger || !category(self, status))
        return status;
    va_start(arguments, format);
    vsnprintf(message, sizeof message, format, arguments);
    va_end(arguments);
    self->log_message(self, status, category(self, status), message);
    return status;
}

Status instance_unsupported(const Instance *self, const char *function)
{
    return instance_refuse(self, STATUS_ERROR, "%s is not supported by this FMU", function);
}

Status instance_lacks_type(const Instance *self, size_t n, const char *type)
{
    if (self && n == 0)
        return STATUS_OK;
    return instance_refuse(self, STATUS_ERROR, "this FMU has no variables of type %s", type);
}

Status instance_choose_log(Instance *self, int on, size_t n, const char *const categories[])
{
    int events = n == 0, warnings = n == 0, discards = n == 0, errors = n == 0;
    size_t i;

    if (instance_expect_pointer(self, categories, n, "log categories") != STATUS_OK)
        return STATUS_ERROR;
    for (i = 0; i < n; i++) {
        if (instance_expect_pointer(self, categories[i], 1, "a log category") != STATUS_OK)
            return STATUS_ERROR;
        if (strcmp(categories[i], "logEvents") == 0)
            events = 1;
        else if (strcmp(categories[i], "logStatusWarning") == 0)
            warnings = 1;
        else if (strcmp(categories[i], "logStatusDiscard") == 0)
            discards = 1;
        else if (strcmp(categories[i], "logStatusError") == 0)
            errors = 1;
        else
            return instance_refuse(self, STATUS_ERROR, "unknown log category");
    }
    if (events)
        self->logs_events = on;
    if (warnings)
        self->logs_warnings = on;
    if (discards)
        self->logs_discards = on;
    if (errors)
        self->logs_errors = on;
    return STATUS_OK;
}

Status instance_expect_pointer(const Instance *self, const void *pointer, size_t n, const char *what)
{
    if (!self)
        return STATUS_ERROR;
    if (!pointer && n > 0)
        return instance_refuse(self, STATUS_ERROR, "the pointer to %s is NULL", what);
    return STATUS_OK;
}

Status instance_expect_finite(const Instance *self, const double values[], size_t n, const char *what)
{
    size_t i;

    for (i = 0; i < n; i++)
        if (!isfinite(values[i]))
            return instance_refuse(self, STATUS_DISCARD, "%s would be %g: the inputs or parameters are not those of a tire",
                                   what, values[i]);
    return STATUS_OK;
}

/* ---------------------------------------------------------------- modes */

static const char *mode_name(int mode)
{
    static const char *const names[] = {"instantiated",       "initializing", "stepping", "in event mode",
                                        "in continuous-time mode", "terminated"};
    return names[mode];
}

Status instance_expect(const Instance *self, Mode mode, Mode other, const char *what)
{
    if (!self)
        return STATUS_ERROR;
    if (self->state.mode != (int) mode && self->state.mode != (int) other)
        return instance_refuse(self, STATUS_ERROR, "%s is allowed while %s, not while %s", what,
                               mode_name((int) mode), mode_name(self->state.mode));
    return STATUS_OK;
}

static Status expect_mode(const Instance *self, Mode mode, const char *what)
{
    return instance_expect(self, mode, mode, what);
}

int state_has_begun(const State *state) { return state->mode >= STEPPING; }

void state_changed(State *state)
{
    state->contact_known = state->lengths_known = state->outputs_known = state->extras_known = 0;
#if HUB
    state->hub_known = 0;
#endif
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
