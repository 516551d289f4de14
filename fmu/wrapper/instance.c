/* See instance.h. */
#include "instance.h"

#include "slips.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char *const NAMES[] = VALUE_NAMES;
static const double START[] = START_VALUES;
static const double LOWER[] = LOWER_LIMITS;
static const double UPPER[] = UPPER_LIMITS;
static const unsigned char KINDS[] = VALUE_KINDS;

/* The generated header and the model's code have to agree on the number of values. */
#define HAS_ALL_VALUES(table) (sizeof(table) / sizeof *(table) == N_VALUES ? 1 : -1)
typedef char names_are_complete[HAS_ALL_VALUES(NAMES)];
typedef char starts_are_complete[HAS_ALL_VALUES(START)];
typedef char limits_are_complete[HAS_ALL_VALUES(LOWER) + HAS_ALL_VALUES(UPPER) - 1];
typedef char kinds_are_complete[HAS_ALL_VALUES(KINDS)];

/* Two points of time that differ by a host's rounding only. */
static int same_time(double a, double b) { return fabs(a - b) <= 1e-9 * (1.0 + fabs(b)); }

/* ---------------------------------------------------------------- life and log */

static void start_again(Instance *self)
{
    memset(&self->state, 0, sizeof self->state); /* padding too: equal states have equal bytes */
    memcpy(self->state.token, INSTANTIATION_TOKEN, sizeof INSTANTIATION_TOKEN);
    self->state.mode = INSTANTIATED;
    memcpy(self->state.values, START, sizeof START);
}

Instance *instance_create(const char *name, const char *token, Tell *tell, void (*logger)(void),
                          void *environment)
{
    Instance *self = calloc(1, sizeof *self);
    const char *known_as = name ? name : "";

    if (!self)
        return NULL;
    self->tell = tell;
    self->logger = logger;
    self->environment = environment;
    self->tells_discards = self->tells_errors = 1;
    self->name = malloc(strlen(known_as) + 1);
    if (!self->name) {
        free(self);
        return NULL;
    }
    strcpy(self->name, known_as);
    if (!token || strcmp(token, INSTANTIATION_TOKEN) != 0) {
        instance_refuse(self, STATUS_ERROR, "the token of the model description is not that of this binary");
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

Status instance_refuse(const Instance *self, Status status, const char *format, ...)
{
    char message[256];
    va_list arguments;

    if (!self || !self->logger || !(status == STATUS_DISCARD ? self->tells_discards : self->tells_errors))
        return status;
    va_start(arguments, format);
    vsnprintf(message, sizeof message, format, arguments);
    va_end(arguments);
    self->tell(self, status, status == STATUS_DISCARD ? "logStatusDiscard" : "logStatusError", message);
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
    int discards = n == 0, errors = n == 0;
    size_t i;

    if (!self)
        return STATUS_ERROR;
    for (i = 0; i < n; i++) {
        if (strcmp(categories[i], "logStatusDiscard") == 0)
            discards = 1;
        else if (strcmp(categories[i], "logStatusError") == 0)
            errors = 1;
        else
            return instance_refuse(self, STATUS_ERROR, "unknown log category");
    }
    if (discards)
        self->tells_discards = on;
    if (errors)
        self->tells_errors = on;
    return STATUS_OK;
}

/* ---------------------------------------------------------------- modes */

static const char *mode_name(int mode)
{
    static const char *const names[] = {"instantiated", "initializing", "stepping", "terminated"};
    return names[mode];
}

static Status expect_mode(const Instance *self, Mode mode, const char *what)
{
    if (!self)
        return STATUS_ERROR;
    if (self->state.mode != (int) mode)
        return instance_refuse(self, STATUS_ERROR, "%s is allowed while %s, not while %s", what,
                               mode_name(mode), mode_name(self->state.mode));
    return STATUS_OK;
}

Status instance_set_experiment(Instance *self, double start, int stop_defined, double stop)
{
    if (expect_mode(self, INSTANTIATED, "setting up the experiment") != STATUS_OK)
        return STATUS_ERROR;
    if (!isfinite(start) || (stop_defined && !(stop >= start)))
        return instance_refuse(self, STATUS_ERROR, "times from %g to %g are no experiment", start,
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
    self->state.mode = STEPPING;
    return STATUS_OK;
}

Status instance_step(Instance *self, double point, double size)
{
    if (expect_mode(self, STEPPING, "a step") != STATUS_OK)
        return STATUS_ERROR;
    if (!isfinite(size) || size <= 0.0)
        return instance_refuse(self, STATUS_ERROR, "a step size has to be positive and finite, not %g", size);
    if (!isfinite(point) || !same_time(point, self->state.values[TIME]))
        return instance_refuse(self, STATUS_ERROR, "the step starts at t = %.17g, the last one ended at %.17g",
                               point, self->state.values[TIME]);
    if (!isfinite(point + size))
        return instance_refuse(self, STATUS_ERROR, "the step ends at t = %g", point + size);
    if (self->state.stop_defined && point + size > self->state.stop_time &&
        !same_time(point + size, self->state.stop_time))
        return instance_refuse(self, STATUS_ERROR, "the step ends at t = %.17g, after the stop time %.17g",
                               point + size, self->state.stop_time);
    slips_advance(&self->state, size);
    self->state.values[TIME] = point + size; /* the host's own clock: no error adds up */
    return STATUS_OK;
}

Status instance_terminate(Instance *self)
{
    if (expect_mode(self, STEPPING, "terminating") != STATUS_OK)
        return STATUS_ERROR;
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

/* ---------------------------------------------------------------- values */

static Status expect_known(const Instance *self, const unsigned references[], size_t n)
{
    size_t i;

    if (!self)
        return STATUS_ERROR;
    for (i = 0; i < n; i++)
        if (references[i] >= N_VALUES || KINDS[references[i]] == HIDDEN)
            return instance_refuse(self, STATUS_ERROR, "there is no value reference %u", references[i]);
    return STATUS_OK;
}

void state_compute_outputs(State *state)
{
    double inputs[N_INPUTS];

    if (state->outputs_known)
        return;
    slips_acting(state, inputs);
    model_forces(inputs, state->values + FIRST_PARAMETER, state->values + FIRST_OUTPUT);
    state->outputs_known = 1;
}

Status instance_get(Instance *self, const unsigned references[], size_t n, double values[])
{
    size_t i;

    if (expect_known(self, references, n) != STATUS_OK)
        return STATUS_ERROR;
    for (i = 0; i < n; i++) {
        if (KINDS[references[i]] == OUTPUT || KINDS[references[i]] == LOCAL)
            state_compute_outputs(&self->state);
        values[i] = self->state.values[references[i]];
    }
    return STATUS_OK;
}

Status instance_set(Instance *self, const unsigned references[], size_t n, const double values[])
{
    size_t i;
    unsigned r;

    if (expect_known(self, references, n) != STATUS_OK)
        return STATUS_ERROR;
    if (self->state.mode == TERMINATED)
        return instance_refuse(self, STATUS_ERROR, "values cannot be set while terminated");
    for (i = 0; i < n; i++) {
        r = references[i];
        if (KINDS[r] != INPUT && KINDS[r] != PARAMETER)
            return instance_refuse(self, STATUS_ERROR, "%s cannot be set", NAMES[r]);
        if (!isfinite(values[i]))
            return instance_refuse(self, STATUS_DISCARD, "%s has to be finite, not %g", NAMES[r], values[i]);
        if (values[i] < LOWER[r] || values[i] > UPPER[r])
            return instance_refuse(self, STATUS_DISCARD, "%s = %g is outside %g ... %g", NAMES[r], values[i],
                                   LOWER[r], UPPER[r]);
    }
    for (i = 0; i < n; i++)
        self->state.values[references[i]] = values[i];
    self->state.outputs_known = self->state.lengths_known = 0;
    return STATUS_OK;
}

/* Fill in the Jacobians that the knowns need, or refuse what is no output by input or parameter. */
static Status jacobians(Instance *self, const unsigned unknowns[], size_t n_unknowns,
                        const unsigned knowns[], size_t n_knowns, double by_inputs[], double by_parameters[])
{
    const double *parameters = self->state.values + FIRST_PARAMETER;
    double inputs[N_INPUTS];
    int needs_inputs = 0, needs_parameters = 0;
    size_t i;

    for (i = 0; i < n_unknowns; i++)
        if (KINDS[unknowns[i]] != OUTPUT)
            return instance_refuse(self, STATUS_ERROR, "%s is no output", NAMES[unknowns[i]]);
    for (i = 0; i < n_knowns; i++) {
        if (KINDS[knowns[i]] == INPUT)
            needs_inputs = 1;
        else if (KINDS[knowns[i]] == PARAMETER)
            needs_parameters = 1;
        else
            return instance_refuse(self, STATUS_ERROR, "%s is no input or parameter", NAMES[knowns[i]]);
    }
    slips_acting(&self->state, inputs);
    if (needs_inputs)
        model_jacobian_inputs(inputs, parameters, by_inputs);
    if (needs_parameters)
        model_jacobian_parameters(inputs, parameters, by_parameters);
    return STATUS_OK;
}

/* The derivative of an output by one input or parameter. */
static double partial(const State *state, unsigned unknown, unsigned known, const double by_inputs[],
                      const double by_parameters[])
{
    size_t row = unknown - FIRST_OUTPUT, column = known - FIRST_INPUT;

    if (known < FIRST_PARAMETER)
        return slips_follow(state, column) ? by_inputs[row * N_INPUTS + column] : 0.0;
    column = known - FIRST_PARAMETER;
    /* Behind the coefficients stand options, between whose values nothing changes. */
    return column < N_COEFFICIENTS ? by_parameters[row * N_COEFFICIENTS + column] : 0.0;
}

Status instance_derivative(Instance *self, const unsigned unknowns[], size_t n_unknowns,
                           const unsigned knowns[], size_t n_knowns, const double seed[],
                           double sensitivity[])
{
    double by_inputs[N_OUTPUTS * N_INPUTS], by_parameters[N_OUTPUTS * N_COEFFICIENTS];
    size_t i, j;

    if (expect_known(self, unknowns, n_unknowns) != STATUS_OK || expect_known(self, knowns, n_knowns) != STATUS_OK)
        return STATUS_ERROR;
    if (jacobians(self, unknowns, n_unknowns, knowns, n_knowns, by_inputs, by_parameters) != STATUS_OK)
        return STATUS_ERROR;
    for (i = 0; i < n_unknowns; i++) {
        sensitivity[i] = 0.0;
        for (j = 0; j < n_knowns; j++)
            sensitivity[i] += seed[j] * partial(&self->state, unknowns[i], knowns[j], by_inputs, by_parameters);
    }
    return STATUS_OK;
}
