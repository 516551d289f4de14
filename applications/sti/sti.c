/* The jobs of the Standard Tyre Interface.  See sti.h. */
#include "sti.h"

#include "wheel_kinematics.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#if !HUB || SPIN
#error "the Standard Tyre Interface needs the equations of hub inputs"
#endif

/* Where the road is if the host reports no contact: this many unloaded radii below the wheel centre, level. */
#define FAR_BELOW 1.5
/* The least friction that the model accepts, as of the input road_mu. */
#define MIN_FRICTION 0.01

/* ---------------------------------------------------------------- texts and numbers of the host */

void sti_write(Call *call, const char *text)
{
    size_t n = strlen(text);

    if (!call->text || call->text_size == 0)
        return;
    if (n >= call->text_size)
        n = call->text_size - 1;
    memset(call->text, call->padded ? ' ' : 0, call->text_size);
    memcpy(call->text, text, n);
}

static void write_line(const Instance *self, Status status, const char *category, const char *message)
{
    (void) status;
    (void) category;
    sti_write(self->environment, message);
}

static int problem(Call *call, int error, const char *format, ...)
{
    char line[STI_TEXT];
    va_list arguments;

    va_start(arguments, format);
    vsnprintf(line, sizeof line, format, arguments);
    va_end(arguments);
    sti_write(call, line);
    return error;
}

static int error_of(Status status)
{
    return status == STATUS_OK ? GOOD : status == STATUS_WARNING ? WARNING : status == STATUS_DISCARD ? DO_NOT_USE : FATAL;
}

/* The tire at its start values. */
static int begin(Instance *self, Call *call)
{
    const char *missing;

    memset(self, 0, sizeof *self);
    self->log_message = write_line;
    self->logger = (void (*)(void)) write_line;
    self->environment = call;
    self->logs_warnings = self->logs_discards = self->logs_errors = 1;
    self->state.kind = MODEL_EXCHANGE;
    missing = tire_find(NULL, &self->tire);
    if (missing) {
        sti_write(call, missing);
        return FATAL;
    }
    instance_reset(self);
    return GOOD;
}

/* ---------------------------------------------------------------- jobs before the simulation */

static int inquire(Call *call)
{
    *call->n_parameters = STI_PARAMETERS;
    *call->n_states = N_STATES;
    *call->n_results = STI_RESULTS;
    *call->n_work = STI_WORK;
    *call->n_integers = STI_INTEGERS;
    sti_write(call, TIRE_TITLE);
    return GOOD;
}

static int check_sizes(Call *call)
{
    if (*call->n_states < N_STATES)
        return problem(call, FATAL, "NDEQVR is %d, but the tire has %d states", *call->n_states, N_STATES);
    if (*call->n_results < STI_RESULTS)
        return problem(call, FATAL, "NVARS is %d, but the tire has %d results", *call->n_results, STI_RESULTS);
    if (*call->n_integers < STI_INTEGERS)
        return problem(call, FATAL, "NIWORK is %d, but the tire needs %d", *call->n_integers, STI_INTEGERS);
    if (*call->n_parameters < STI_PARAMETERS)
        return problem(call, FATAL, "NTYPAR is %d, but the tire has %d", *call->n_parameters, STI_PARAMETERS);
    return GOOD;
}

static double own(const Instance *self, size_t i) { return self->state.values[FIRST_PARAMETER + i]; }

double sti_radius(const Call *call) { return call->parameters[UNLOADED_RADIUS_OF_HOST]; }

/* Parameters and the states of a freely rolling tire. */
static int initialize(Call *call)
{
    Instance self;
    int error = check_sizes(call);

    if (error == GOOD)
        error = begin(&self, call);
    if (error != GOOD)
        return error;
    memset(call->parameters, 0, STI_PARAMETERS * sizeof *call->parameters);
    call->parameters[UNLOADED_RADIUS_OF_HOST] = own(&self, OWN_UNLOADED_RADIUS);
#ifdef OWN_VERTICAL_STIFFNESS
    call->parameters[STIFFNESS_OF_HOST] = own(&self, OWN_VERTICAL_STIFFNESS);
#endif
    call->parameters[DAMPING_OF_HOST] = own(&self, OWN_VERTICAL_DAMPING);
    call->integers[WARNED] = 0;
    sti_write(call, TIRE_TITLE);
    instance_enter_initialization(&self);
    error = error_of(instance_exit_initialization(&self));
    if (error == GOOD)
        error = error_of(instance_get_states(&self, call->initial, N_STATES));
    return error;
}

/* ---------------------------------------------------------------- evaluation */

/* The inputs of an FMU with hub inputs, for a road. */
static void find_inputs(const Call *call, const Road *road, double inputs[WHEEL_MOTION_ARGUMENTS])
{
    const double *r = call->position, *n = road->normal;
    size_t i, j;

    memset(inputs, 0, WHEEL_MOTION_ARGUMENTS * sizeof *inputs);
    for (i = 0; i < 3; i++) {
        inputs[WHEEL_MOTION_r_x + i] = r[i];
        for (j = 0; j < 3; j++) {
            const double cosine = call->axes[3 * j + i]; /* TRAMAT is stored by columns */
            inputs[WHEEL_MOTION_R_11 + 3 * i + j] = cosine;
            inputs[WHEEL_MOTION_v_x + i] += cosine * call->velocity[j];
            inputs[WHEEL_MOTION_w_x + i] += cosine * call->turning[j];
        }
        inputs[WHEEL_MOTION_road_nx + i] = road->touched ? n[i] : i == 2;
    }
    inputs[WHEEL_MOTION_omega] = *call->spin;
    inputs[WHEEL_MOTION_road_z] =
        road->touched ? road->point[2] - (n[0] * (r[0] - road->point[0]) + n[1] * (r[1] - road->point[1])) / n[2]
                      : r[2] - FAR_BELOW * sti_radius(call);
}

/* The road below the wheel centre; of a road with a height at every place, the plane at the contact point that the
   first plane gives. */
static int find_road(Call *call, Road *road)
{
    double inputs[WHEEL_MOTION_ARGUMENTS], motion[WHEEL_MOTION_RESULTS];
    int warned, error = call->find_road(call, call->position, road);

    if (error > WARNING || !call->by_height)
        return error;
    find_inputs(call, road, inputs);
    wheel_motion(inputs, motion);
    warned = error;
    error = call->find_road(call, motion + WHEEL_MOTION_c_x, road);
    return error > warned ? error : warned;
}

static Status set_motion(Instance *self, const Call *call, const Road *road)
{
    enum { MAX_REFERENCES = WHEEL_MOTION_ARGUMENTS + 1 };
    unsigned references[MAX_REFERENCES];
    double inputs[MAX_REFERENCES];
    size_t i, n = WHEEL_MOTION_ARGUMENTS;

    find_inputs(call, road, inputs);
    for (i = 0; i < n; i++)
        references[i] = FIRST_INPUT + (unsigned) i;
    if (HOST_FRICTION > 0) {
        references[n] = FIRST_INPUT + HOST_FRICTION;
        inputs[n++] = road->friction < MIN_FRICTION ? MIN_FRICTION : road->friction;
    }
    return instance_set(self, references, n, inputs);
}

static int evaluate(Call *call)
{
    unsigned outputs[N_OUTPUTS], before;
    const double *results;
    Instance self;
    Road road = {1, {0.0, 0.0, 0.0}, {0.0, 0.0, 1.0}, 1.0};
    Status status;
    size_t i;
    int by_road, error = check_sizes(call);

    if (error == GOOD)
        error = begin(&self, call);
    if (error != GOOD)
        return error;
    by_road = find_road(call, &road);
    if (by_road > WARNING)
        return by_road;
    if (road.touched && !(road.normal[2] > 0.0))
        return problem(call, DO_NOT_USE, "tire %d: the normal of the road does not point up", *call->tire);
    self.warned = before = (unsigned) call->integers[WARNED] | 1u << N_INPUTS; /* every host gives the speed */
    self.state.mode = CONTINUOUS;
    for (i = 0; i < N_OUTPUTS; i++)
        outputs[i] = FIRST_OUTPUT + (unsigned) i;
    status = instance_set_time(&self, *call->time);
    if (status == STATUS_OK)
        status = set_motion(&self, call, &road);
    if (status == STATUS_OK)
        status = instance_set_states(&self, call->states, N_STATES);
    if (status == STATUS_OK) {
        double forces[N_OUTPUTS];

        status = instance_get(&self, outputs, N_OUTPUTS, forces);
    }
    results = self.state.hub.results;
    if (status == STATUS_OK)
        status = instance_expect_finite(&self, results, N_HUB_RESULTS, "a result");
    if (status == STATUS_OK)
        status = instance_get_rates(&self, call->rates, N_STATES);
    if (status != STATUS_OK)
        return error_of(status);
    memcpy(call->force, results + WRENCH_RESULT, 3 * sizeof *results);
    memcpy(call->moment, results + WRENCH_RESULT + 3, 3 * sizeof *results);
    memset(call->results, 0, STI_RESULTS * sizeof *call->results);
    call->show(&self, call->results);
    error = self.warned != before ? WARNING : by_road; /* the text is that of the warning */
    call->integers[WARNED] = (int) self.warned;
    return error;
}

int sti_call(Call *call)
{
    Road road = {1, {0.0, 0.0, 0.0}, {0.0, 0.0, 1.0}, 1.0};
    int error;

    switch (*call->job) {
    case NO_EVALUATION:
        return GOOD;
    case INQUIRE:
    case ACTUAL_SIZES:
        error = inquire(call);
        break;
    case INITIALIZE:
    case REINITIALIZE:
    case INITIAL_CONDITIONS:
        error = initialize(call);
        break;
    case NORMAL:
    case SUCCESSFUL_STEP:
    case DIFFERENCING:
        return evaluate(call);
    case FINAL:
        error = GOOD;
        break;
    default:
        return problem(call, DO_NOT_USE, "tire %d: JOBFLG %d is unknown", *call->tire, *call->job);
    }
    /* A road prepares and ends with its tires. */
    return error == GOOD ? call->find_road(call, call->position, &road) : error;
}
