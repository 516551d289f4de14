/* One tire instance for both FMI versions: its values, its modes and the allowed calls.
 *
 * Hand-written C99.  fmi2.c and fmi3.c translate calls; the checks of allowed calls are here only.
 *
 * A function either completes, or it rejects the call and changes nothing.
 *   STATUS_DISCARD  a value is not finite or outside its declared limits, or a result would not be finite
 *   STATUS_ERROR    the standard or this FMU does not allow the call, or a pointer is NULL
 * The host's logger receives one line for each rejected call.
 */
#ifndef INSTANCE_H
#define INSTANCE_H

#include "state.h"

/* The same numbers in FMI 2 and FMI 3. */
typedef enum { STATUS_OK = 0, STATUS_WARNING = 1, STATUS_DISCARD = 2, STATUS_ERROR = 3 } Status;

typedef struct Instance Instance;

/* Calls the host's logger, whose type depends on the FMI version, with one line. */
typedef void LogCallback(const Instance *self, Status status, const char *category, const char *message);

struct Instance {
    State state;
    Tire tire;
    LogCallback *log_message;
    void (*logger)(void); /* the host's function; `log_message` converts its type */
    void *environment;
    char *name;
    int logs_events, logs_warnings, logs_discards, logs_errors;
    unsigned warned; /* bits: inputs of the model of whose ranges the log has a warning; the last one: of standing */
    int has_event_mode, returns_early; /* what the host uses in Co-Simulation */
};

/* Without `logs_events` the host gets warnings and errors only. */
Instance *instance_create(const char *name, const char *token, const char *resources, Kind kind, int logs_events,
                          LogCallback *log_message, void (*logger)(void), void *environment);
void instance_free(Instance *self);

/* Log why a call is rejected, or with STATUS_OK an assumption; returns `status`.  `self` may be NULL: then nothing is logged. */
Status instance_refuse(const Instance *self, Status status, const char *format, ...);
Status instance_unsupported(const Instance *self, const char *function);
/* For calls about variables of a type that this FMU lacks: accepted for zero variables, rejected otherwise. */
Status instance_lacks_type(const Instance *self, size_t n, const char *type);
Status instance_choose_log(Instance *self, int on, size_t n, const char *const categories[]);

/* Reject a NULL pointer to n > 0 values; `what` names the values. */
Status instance_expect_pointer(const Instance *self, const void *pointer, size_t n, const char *what);
/* Reject a value that is not finite or outside the limits of its variable.  Limits that the tire's own value violates do
   not apply. */
Status instance_expect_allowed(const Instance *self, unsigned reference, double value);
int instance_allows(const Instance *self, unsigned reference, double value);
/* Reject results that are not finite. */
Status instance_expect_finite(const Instance *self, const double values[], size_t n, const char *what);
/* Reject the call unless the instance is in one of two modes. */
Status instance_expect(const Instance *self, Mode mode, Mode other, const char *what);

/* The life cycle, and steps of Co-Simulation: life_cycle.c, stepping.c. */
Status instance_set_experiment(Instance *self, double start, int stop_defined, double stop);
Status instance_enter_initialization(Instance *self);
Status instance_exit_initialization(Instance *self);
Status instance_step(Instance *self, double point, double size);
/* Whether an event has happened in the last step, which the host handles in event mode. */
int instance_had_event(const Instance *self);
/* The inputs change with these rates over the next step, from their present values. */
Status instance_set_slopes(Instance *self, const unsigned references[], size_t n, const int orders[],
                           const double slopes[]);
Status instance_terminate(Instance *self);
Status instance_reset(Instance *self);

/* Events: events.c.  With early return, a step ends behind the first event in it. */
Status instance_use_events(Instance *self, int event_mode, int early_return);
Status instance_enter_event(Instance *self);
Status instance_enter_continuous(Instance *self);
Status instance_enter_stepping(Instance *self);
Status instance_update_discrete(Instance *self, int *states_changed);

/* Model Exchange: continuous.c. */
Status instance_expect_exchange(const Instance *self, const char *what);
Status instance_complete_step(Instance *self);
Status instance_set_time(Instance *self, double time);
Status instance_get_states(Instance *self, double states[], size_t n);
Status instance_set_states(Instance *self, const double states[], size_t n);
Status instance_get_rates(Instance *self, double rates[], size_t n);
Status instance_get_nominals(Instance *self, double nominals[], size_t n);
Status instance_get_indicators(Instance *self, double indicators[], size_t n);

/* Values: access.c. */
Status instance_expect_known(const Instance *self, const unsigned references[], size_t n);
Status instance_get(Instance *self, const unsigned references[], size_t n, double values[]);
Status instance_set(Instance *self, const unsigned references[], size_t n, const double values[]);
/* sensitivity = (d unknowns / d knowns) seed; adjoint: sensitivity = seed (d unknowns / d knowns). */
Status instance_derivative(Instance *self, const unsigned unknowns[], size_t n_unknowns,
                           const unsigned knowns[], size_t n_knowns, const double seed[],
                           double sensitivity[]);
Status instance_adjoint(Instance *self, const unsigned unknowns[], size_t n_unknowns, const unsigned knowns[],
                        size_t n_knowns, const double seed[], double sensitivity[]);

/* Saved states.  `*slot` is NULL or a state saved before, which is then reused. */
Status instance_save(Instance *self, void **slot);
Status instance_restore(Instance *self, const void *saved);
Status instance_drop(const Instance *self, void **slot);
Status instance_serialized_size(Instance *self, const void *saved, size_t *size);
Status instance_serialize(Instance *self, const void *saved, void *bytes, size_t size);
Status instance_deserialize(Instance *self, const void *bytes, size_t size, void **slot);

#endif
