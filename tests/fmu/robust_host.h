/* The host of robust.c in both versions of FMI: each call has one name for both, the log messages of the FMU are
 * counted, and a failed expectation is printed.
 */
#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static char last_message[512];
static int n_messages;

#if FMI == 2
#include "fmi2Functions.h"
typedef fmi2Component Tire;
typedef fmi2FMUstate Saved;
typedef fmi2Byte Byte;
#define CALL(name) fmi2##name
static void log_message(void *e, const char *i, fmi2Status s, const char *c, const char *message, ...)
{
    snprintf(last_message, sizeof last_message, "%s", message);
    n_messages++;
}
static fmi2CallbackFunctions callbacks = {log_message, calloc, free, NULL, NULL};
static fmi2CallbackFunctions silent = {NULL, calloc, free, NULL, NULL};
static Tire create(const char *token, int kind, int has_logger)
{
    return fmi2Instantiate("tire", kind ? fmi2ModelExchange : fmi2CoSimulation, token, NULL,
                           has_logger ? &callbacks : &silent, 0, 0);
}
static int initialize(Tire t, double start, double stop)
{
    return fmi2SetupExperiment(t, 0, 0.0, start, stop > start, stop) || fmi2EnterInitializationMode(t);
}
static int set(Tire t, const unsigned r[], size_t n, const double v[]) { return fmi2SetReal(t, r, n, v); }
static int get(Tire t, const unsigned r[], size_t n, double v[]) { return fmi2GetReal(t, r, n, v); }
static int step(Tire t, double point, double size) { return fmi2DoStep(t, point, size, 1); }
static int derive(Tire t, unsigned of, unsigned by, double *d)
{
    const double one = 1.0;
    return fmi2GetDirectionalDerivative(t, &of, 1, &by, 1, &one, d);
}
static int save(Tire t, Saved *s) { return fmi2GetFMUstate(t, s); }
static int restore(Tire t, Saved s) { return fmi2SetFMUstate(t, s); }
static int drop(Tire t, Saved *s) { return fmi2FreeFMUstate(t, s); }
static int measure(Tire t, Saved s, size_t *n) { return fmi2SerializedFMUstateSize(t, s, n); }
static int serialize(Tire t, Saved s, Byte b[], size_t n) { return fmi2SerializeFMUstate(t, s, b, n); }
static int deserialize(Tire t, const Byte b[], size_t n, Saved *s) { return fmi2DeSerializeFMUstate(t, b, n, s); }
#else
#include "fmi3Functions.h"
typedef fmi3Instance Tire;
typedef fmi3FMUState Saved;
typedef fmi3Byte Byte;
#define CALL(name) fmi3##name
static void log_message(void *e, fmi3Status s, const char *c, const char *message)
{
    snprintf(last_message, sizeof last_message, "%s", message);
    n_messages++;
}
static Tire create(const char *token, int kind, int has_logger)
{
    if (kind)
        return fmi3InstantiateModelExchange("tire", token, NULL, 0, 0, NULL, has_logger ? log_message : NULL);
    return fmi3InstantiateCoSimulation("tire", token, NULL, 0, 0, 0, 0, NULL, 0, NULL,
                                       has_logger ? log_message : NULL, NULL);
}
static int initialize(Tire t, double start, double stop)
{
    return fmi3EnterInitializationMode(t, 0, 0.0, start, stop > start, stop);
}
static int set(Tire t, const unsigned r[], size_t n, const double v[]) { return fmi3SetFloat64(t, r, n, v, n); }
static int get(Tire t, const unsigned r[], size_t n, double v[]) { return fmi3GetFloat64(t, r, n, v, n); }
static int step(Tire t, double point, double size)
{
    bool event, terminate, early;
    double reached;
    return fmi3DoStep(t, point, size, 1, &event, &terminate, &early, &reached);
}
static int derive(Tire t, unsigned of, unsigned by, double *d)
{
    const double one = 1.0;
    return fmi3GetDirectionalDerivative(t, &of, 1, &by, 1, &one, 1, d, 1);
}
static int save(Tire t, Saved *s) { return fmi3GetFMUState(t, s); }
static int restore(Tire t, Saved s) { return fmi3SetFMUState(t, s); }
static int drop(Tire t, Saved *s) { return fmi3FreeFMUState(t, s); }
static int measure(Tire t, Saved s, size_t *n) { return fmi3SerializedFMUStateSize(t, s, n); }
static int serialize(Tire t, Saved s, Byte b[], size_t n) { return fmi3SerializeFMUState(t, s, b, n); }
static int deserialize(Tire t, const Byte b[], size_t n, Saved *s) { return fmi3DeserializeFMUState(t, b, n, s); }
#endif

enum { OK = 0, DISCARD = 2, ERROR = 3 };
/* Value references of such a tire. */
enum { TIME, KAPPA, ALPHA, GAMMA, LOAD, PRESSURE, SPEED, PHIT, FX, FY, MZ, MX, MY, FIRST_PARAMETER, BOUNDED = LMUX_REFERENCE };
enum { N_FORCES = 5 };

static const char *token, *case_name;
static int failures, wrong;

#define EXPECT(condition) ((condition) ? (void) 0 : report_failure(#condition, __LINE__))

static void report_failure(const char *what, int line)
{
    printf("%s: line %d: failed: %s (last message: %s)\n", case_name, line, what, last_message);
    wrong = 1;
}

static int set_one(Tire t, unsigned r, double v) { return set(t, &r, 1, &v); }

static double get_one(Tire t, unsigned r)
{
    double v = NAN;
    return get(t, &r, 1, &v) == OK ? v : NAN;
}

static void forces(Tire t, double found[N_FORCES])
{
    static const unsigned references[] = {FX, FY, MZ, MX, MY};
    EXPECT(get(t, references, N_FORCES, found) == OK);
}

static int all_finite(const double v[], int n)
{
    for (int i = 0; i < n; i++)
        if (!isfinite(v[i]))
            return 0;
    return 1;
}

/* A running instance: initialized, with inputs set, after one step. */
static Tire running(void)
{
    static const unsigned references[] = {KAPPA, ALPHA, GAMMA, LOAD, SPEED};
    static const double point[] = {0.05, -0.08, 0.03, 4100.0, 21.0};
    Tire t = create(token, 0, 1);

    EXPECT(t != NULL);
    EXPECT(initialize(t, 0.0, 0.0) == OK);
    EXPECT(CALL(ExitInitializationMode)(t) == OK);
    EXPECT(set(t, references, 5, point) == OK);
    EXPECT(step(t, 0.0, 0.01) == OK);
    last_message[0] = 0;
    n_messages = 0;
    return t;
}

static size_t bytes_of(Tire t, Byte **bytes)
{
    Saved s = NULL;
    size_t n = 0;

    EXPECT(save(t, &s) == OK && measure(t, s, &n) == OK);
    *bytes = malloc(n);
    EXPECT(serialize(t, s, *bytes, n) == OK);
    EXPECT(drop(t, &s) == OK);
    return n;
}

/* A call has this status, logs one message, and does not change a bit of the state. */
#define UNTOUCHED(t, status, call)                                           \
    do {                                                                     \
        Byte *before_, *after_;                                              \
        size_t n_ = bytes_of(t, &before_);                                   \
        int n_messages_ = n_messages;                                        \
        EXPECT((call) == (status));                                          \
        EXPECT(n_messages == n_messages_ + 1 && last_message[0]);            \
        EXPECT(bytes_of(t, &after_) == n_ && !memcmp(before_, after_, n_));  \
        free(before_);                                                       \
        free(after_);                                                        \
    } while (0)

#define WITH(t) for (Tire t = running(), done_ = NULL; !done_; CALL(FreeInstance)(t), done_ = t)
