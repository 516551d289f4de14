/* The log of an instance, and what its calls expect.  See instance.h. */
#include "instance.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

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

static const double LIMITS_OF[][2] = VALUE_LIMITS;

typedef char limits_are_complete[sizeof LIMITS_OF / sizeof *LIMITS_OF == N_VALUES ? 1 : -1];

static int is_within(unsigned reference, double value)
{
    return value >= LIMITS_OF[reference][0] && value <= LIMITS_OF[reference][1];
}

int instance_allows(const Instance *self, unsigned reference, double value)
{
    return isfinite(value) && (is_within(reference, value) || !is_within(reference, self->tire.starts[reference]));
}

Status instance_expect_allowed(const Instance *self, unsigned reference, double value)
{
    if (instance_allows(self, reference, value))
        return STATUS_OK;
    if (!isfinite(value))
        return instance_refuse(self, STATUS_DISCARD, "%s must be finite, not %g", value_name(reference), value);
    return instance_refuse(self, STATUS_DISCARD, "%s = %g is outside %g ... %g", value_name(reference), value,
                           LIMITS_OF[reference][0], LIMITS_OF[reference][1]);
}

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
