/* One tire behind both FMI versions: its values, its modes and its rules.
 *
 * Hand-written, plain C99.  fmi2.c and fmi3.c only translate; what is allowed is decided here, once.
 *
 * The rule of every function: it does all of what was asked or, refusing, changes nothing.
 *   STATUS_DISCARD  a value is not finite or outside its declared limits
 *   STATUS_ERROR    a call that the standard or this FMU does not allow
 * Each refusal is told to the host's logger in one line.
 */
#ifndef INSTANCE_H
#define INSTANCE_H

#include <stddef.h>

#include "model_config.h"

/* A value reference is an index into one array of doubles. */
enum {
    TIME = 0,
    FIRST_INPUT = 1,
    FIRST_OUTPUT = FIRST_INPUT + N_INPUTS,
    FIRST_PARAMETER = FIRST_OUTPUT + N_OUTPUTS,
    FIRST_LOCAL = FIRST_PARAMETER + N_PARAMETERS,
    N_VALUES = FIRST_LOCAL + N_LOCALS
};

/* What a value is to the host; a hidden one is read by the model only and keeps its start value. */
enum { INDEPENDENT, INPUT, OUTPUT, PARAMETER, LOCAL, HIDDEN };

/* The same numbers in FMI 2 and FMI 3. */
typedef enum { STATUS_OK = 0, STATUS_DISCARD = 2, STATUS_ERROR = 3 } Status;

typedef enum { INSTANTIATED, INITIALIZATION, STEPPING, TERMINATED } Mode;

/* kappa and tan(alpha) */
enum { LONGITUDINAL, LATERAL, N_SLIPS };

/* All that can change in an instance.  No pointers: a copy is a saved state, its bytes a serialized one. */
typedef struct {
    char token[sizeof INSTANTIATION_TOKEN]; /* tells a serialized state of another FMU */
    int mode;
    int outputs_known; /* the outputs in `values` belong to the inputs, parameters and lagging slips there */
    int lengths_known; /* the relaxation lengths belong to the inputs and parameters */
    int stop_defined;
    double stop_time;
    double lagging[N_SLIPS]; /* since the end of initialization; see slips.h */
    double lengths[N_SLIPS];
    double values[N_VALUES];
} State;

typedef struct Instance Instance;

/* Hands one line to the host's logger in the manner of its FMI version. */
typedef void Tell(const Instance *self, Status status, const char *category, const char *message);

struct Instance {
    State state;
    Tell *tell;
    void (*logger)(void); /* the host's own function, of the type that `tell` knows */
    void *environment;
    char *name;
    int tells_discards, tells_errors;
};

Instance *instance_create(const char *name, const char *token, Tell *tell, void (*logger)(void),
                          void *environment);
void instance_free(Instance *self);

/* Tell why a call is refused; returns `status`.  `self` may be NULL: then nobody can be told. */
Status instance_refuse(const Instance *self, Status status, const char *format, ...);
Status instance_unsupported(const Instance *self, const char *function);
/* For calls about variables of a type that this FMU lacks: fine for none of them, refused otherwise. */
Status instance_lacks_type(const Instance *self, size_t n, const char *type);
Status instance_choose_log(Instance *self, int on, size_t n, const char *const categories[]);

Status instance_set_experiment(Instance *self, double start, int stop_defined, double stop);
Status instance_enter_initialization(Instance *self);
Status instance_exit_initialization(Instance *self);
Status instance_step(Instance *self, double point, double size);
Status instance_terminate(Instance *self);
Status instance_reset(Instance *self);

/* Direct feedthrough: outputs are computed when they are asked for, once after inputs or parameters changed. */
void state_compute_outputs(State *state);

Status instance_get(Instance *self, const unsigned references[], size_t n, double values[]);
Status instance_set(Instance *self, const unsigned references[], size_t n, const double values[]);
/* sensitivity = (d unknowns / d knowns) seed, for outputs by inputs and parameters, lagging slips held. */
Status instance_derivative(Instance *self, const unsigned unknowns[], size_t n_unknowns,
                           const unsigned knowns[], size_t n_knowns, const double seed[],
                           double sensitivity[]);

/* Saved states.  `*slot` is NULL or a state saved before, which is then reused. */
Status instance_save(Instance *self, void **slot);
Status instance_restore(Instance *self, const void *saved);
Status instance_drop(Instance *self, void **slot);
Status instance_serialized_size(Instance *self, const void *saved, size_t *size);
Status instance_serialize(Instance *self, const void *saved, void *bytes, size_t size);
Status instance_deserialize(Instance *self, const void *bytes, size_t size, void **slot);

#endif
