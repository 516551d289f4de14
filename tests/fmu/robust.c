/* Misuse of one FMU by a host, case by case: expected status, log message, and an unchanged state.
 *
 *     robust TOKEN
 *
 * Linked with the FMU's sources, so that sanitizers check both; FMI is 2 or 3.  Prints "NAME ok" or the failed
 * expectation of each case, and exits with 1 if any failed.  The tire is one of MF6.1 with lagging slips and slip
 * inputs.
 */
#include "robust_host.h"

static void input_nan(void) { WITH(t) UNTOUCHED(t, DISCARD, set_one(t, KAPPA, NAN)); }
static void input_infinite(void) { WITH(t) UNTOUCHED(t, DISCARD, set_one(t, LOAD, INFINITY)); }
static void input_minus_infinite(void) { WITH(t) UNTOUCHED(t, DISCARD, set_one(t, SPEED, -INFINITY)); }
static void parameter_nan(void) { WITH(t) UNTOUCHED(t, DISCARD, set_one(t, FIRST_PARAMETER, NAN)); }
static void parameter_infinite(void) { WITH(t) UNTOUCHED(t, DISCARD, set_one(t, FIRST_PARAMETER, INFINITY)); }
static void parameter_above_max(void) { WITH(t) UNTOUCHED(t, DISCARD, set_one(t, BOUNDED, 1e6)); }
static void parameter_below_min(void) { WITH(t) UNTOUCHED(t, DISCARD, set_one(t, BOUNDED, -1e6)); }

static void one_bad_of_many(void)
{
    static const unsigned references[] = {KAPPA, ALPHA, LOAD};
    static const double values[] = {0.1, 0.1, NAN};
    WITH(t) UNTOUCHED(t, DISCARD, set(t, references, 3, values));
}

static void unknown_reference_set(void) { WITH(t) UNTOUCHED(t, ERROR, set_one(t, 4000000000u, 1.0)); }
static void output_set(void) { WITH(t) UNTOUCHED(t, ERROR, set_one(t, FY, 1.0)); }
static void time_set(void) { WITH(t) UNTOUCHED(t, ERROR, set_one(t, TIME, 1.0)); }

static void unknown_reference_read(void)
{
    const unsigned r = 100000;
    double v = 7.0;
    WITH(t)
    {
        UNTOUCHED(t, ERROR, get(t, &r, 1, &v));
        EXPECT(v == 7.0);
    }
}

static void lifted_wheel(void)
{
    double found[N_FORCES];
    WITH(t)
    {
        for (double load = 0.0; load > -1e4; load = load * 10.0 - 1.0) {
            EXPECT(set_one(t, LOAD, load) == OK);
            forces(t, found);
            for (int i = 0; i < N_FORCES; i++)
                EXPECT(found[i] == 0.0);
        }
        EXPECT(step(t, 0.01, 0.1) == OK);
    }
}

static void standstill(void)
{
    static const double speeds[] = {1e-3, 1e-9, 1e-300, 0.0, -0.0, -1e-300, -1e-9, -1e-3};
    double found[N_FORCES];
    WITH(t)
    {
        for (int i = 0; i < 8; i++) {
            EXPECT(set_one(t, SPEED, speeds[i]) == OK);
            EXPECT(step(t, 0.01 + 0.1 * i, 0.1) == OK);
            forces(t, found);
            EXPECT(all_finite(found, N_FORCES));
        }
    }
}

static void locked_spinning_reverse(void)
{
    double found[N_FORCES];
    WITH(t)
    {
        for (int i = 0; i < 12; i++) {
            EXPECT(set_one(t, KAPPA, (double[]){-1.0, -5.0, 50.0, 1e6}[i % 4]) == OK);
            EXPECT(set_one(t, SPEED, i % 3 ? 20.0 : -20.0) == OK);
            EXPECT(step(t, 0.01 + i, 1.0) == OK);
            forces(t, found);
            EXPECT(all_finite(found, N_FORCES));
        }
    }
}

static void enormous_but_finite(void)
{
    double found[N_FORCES];
    WITH(t)
    {
        EXPECT(set_one(t, LOAD, 1e7) == OK && set_one(t, ALPHA, 1.5707) == OK && set_one(t, SPEED, 1e4) == OK);
        EXPECT(step(t, 0.01, 10.0) == OK);
        forces(t, found);
        EXPECT(all_finite(found, N_FORCES));
    }
}


static void step_zero(void) /* accepted, because some hosts begin with it; it changes nothing */
{
    double before[N_FORCES], after[N_FORCES];
    WITH(t)
    {
        forces(t, before);
        EXPECT(step(t, 0.01, 0.0) == OK && step(t, 0.02, 0.0) == ERROR);
        forces(t, after);
        EXPECT(!memcmp(before, after, sizeof before));
        EXPECT(step(t, 0.01, 0.01) == OK);
    }
}

static void step_negative(void) { WITH(t) UNTOUCHED(t, ERROR, step(t, 0.01, -0.1)); }
static void step_nan(void) { WITH(t) UNTOUCHED(t, ERROR, step(t, 0.01, NAN)); }
static void step_infinite(void) { WITH(t) UNTOUCHED(t, ERROR, step(t, 0.01, INFINITY)); }
static void step_from_elsewhere(void) { WITH(t) UNTOUCHED(t, ERROR, step(t, 0.5, 0.01)); }
static void step_from_nan(void) { WITH(t) UNTOUCHED(t, ERROR, step(t, NAN, 0.01)); }

static void step_beyond_stop(void)
{
    Tire t = create(token, 0, 1);
    EXPECT(initialize(t, 0.0, 1.0) == OK && CALL(ExitInitializationMode)(t) == OK);
    UNTOUCHED(t, ERROR, step(t, 0.0, 1.5));
    EXPECT(step(t, 0.0, 1.0) == OK);
    CALL(FreeInstance)(t);
}

static void step_before_initialization(void)
{
    Tire t = create(token, 0, 1);
    UNTOUCHED(t, ERROR, step(t, 0.0, 0.1));
    CALL(FreeInstance)(t);
}

static void step_while_initializing(void)
{
    Tire t = create(token, 0, 1);
    EXPECT(initialize(t, 0.0, 0.0) == OK);
    UNTOUCHED(t, ERROR, step(t, 0.0, 0.1));
    CALL(FreeInstance)(t);
}

static void initialized_twice(void) { WITH(t) UNTOUCHED(t, ERROR, CALL(ExitInitializationMode)(t)); }
static void start_time_nan(void)
{
    Tire t = create(token, 0, 1);
    EXPECT(initialize(t, NAN, 0.0) == ERROR || initialize(t, NAN, 0.0) == 1);
    CALL(FreeInstance)(t);
}

static void terminated(void)
{
    WITH(t)
    {
        EXPECT(CALL(Terminate)(t) == OK);
        UNTOUCHED(t, ERROR, step(t, 0.01, 0.1));
        UNTOUCHED(t, ERROR, set_one(t, KAPPA, 0.1));
        UNTOUCHED(t, ERROR, CALL(Terminate)(t));
        EXPECT(isfinite(get_one(t, FY)));
    }
}

static void solver_calls_in_cosimulation(void)
{
    double x[2];
    WITH(t)
    {
        UNTOUCHED(t, ERROR, CALL(EnterContinuousTimeMode)(t));
        UNTOUCHED(t, ERROR, CALL(GetContinuousStates)(t, x, 2));
        UNTOUCHED(t, ERROR, CALL(SetTime)(t, 1.0));
    }
}

static void step_in_model_exchange(void)
{
    double x[2] = {0.0, NAN}, y[3];
    Tire t = create(token, 1, 1);
    EXPECT(initialize(t, 0.0, 0.0) == OK && CALL(ExitInitializationMode)(t) == OK);
    UNTOUCHED(t, ERROR, step(t, 0.0, 0.1));
    UNTOUCHED(t, ERROR, CALL(SetContinuousStates)(t, x, 2));
    EXPECT(CALL(EnterContinuousTimeMode)(t) == OK);
    UNTOUCHED(t, DISCARD, CALL(SetContinuousStates)(t, x, 2));
    UNTOUCHED(t, ERROR, CALL(GetContinuousStates)(t, y, 3));
    EXPECT(set_one(t, FIRST_PARAMETER, get_one(t, FIRST_PARAMETER)) == OK);
    UNTOUCHED(t, ERROR, set_one(t, FIRST_PARAMETER, 0.9 * get_one(t, FIRST_PARAMETER)));
    UNTOUCHED(t, DISCARD, CALL(SetTime)(t, NAN));
    CALL(FreeInstance)(t);
}

static void reset_and_reused(void)
{
    double first[N_FORCES], second[N_FORCES];
    WITH(t)
    {
        forces(t, first);
        EXPECT(set_one(t, FIRST_PARAMETER, NAN) == DISCARD && step(t, 77.0, 1.0) == ERROR);
        EXPECT(CALL(Reset)(t) == OK);
        EXPECT(initialize(t, 0.0, 0.0) == OK && CALL(ExitInitializationMode)(t) == OK);
        EXPECT(set_one(t, KAPPA, 0.05) == OK && set_one(t, ALPHA, -0.08) == OK && set_one(t, GAMMA, 0.03) == OK);
        EXPECT(set_one(t, LOAD, 4100.0) == OK && set_one(t, SPEED, 21.0) == OK && step(t, 0.0, 0.01) == OK);
        forces(t, second);
        EXPECT(!memcmp(first, second, sizeof first));
    }
}

static void state_into_another_instance(void)
{
    double first[N_FORCES], second[N_FORCES];
    Tire other = running();
    Saved s = NULL;
    WITH(t)
    {
        EXPECT(set_one(other, KAPPA, -0.3) == OK && step(other, 0.01, 0.3) == OK);
        EXPECT(save(t, &s) == OK && restore(other, s) == OK && drop(t, &s) == OK && s == NULL);
        EXPECT(step(t, 0.01, 0.02) == OK && step(other, 0.01, 0.02) == OK);
        forces(t, first);
        forces(other, second);
        EXPECT(!memcmp(first, second, sizeof first));
    }
    CALL(FreeInstance)(other);
}

static void serialized_state_from_outside(void)
{
    Byte *bytes;
    Saved s = NULL;
    size_t n, i;
    WITH(t)
    {
        n = bytes_of(t, &bytes);
        EXPECT(deserialize(t, bytes, n - 1, &s) == ERROR && deserialize(t, bytes, 0, &s) == ERROR);
        for (i = 0; i < n; i += 7) { /* any byte may have changed: rejected, or a valid state */
            Byte original = bytes[i];
            bytes[i] = (Byte) (original ^ 0xff);
            if (deserialize(t, bytes, n, &s) == OK)
                EXPECT(drop(t, &s) == OK);
            bytes[i] = original;
        }
        EXPECT(deserialize(t, bytes, n, &s) == OK && restore(t, s) == OK && drop(t, &s) == OK);
        EXPECT(step(t, 0.01, 0.01) == OK);
        free(bytes);
    }
}

static void no_state_to_restore(void) { WITH(t) UNTOUCHED(t, ERROR, restore(t, NULL)); }
static void small_buffer(void)
{
    Byte few[4];
    Saved s = NULL;
    WITH(t)
    {
        EXPECT(save(t, &s) == OK && serialize(t, s, few, sizeof few) == ERROR && drop(t, &s) == OK);
        EXPECT(drop(t, &s) == OK && drop(t, NULL) == OK);
    }
}

static void wrong_token(void)
{
    n_messages = 0;
    EXPECT(create("{00000000-0000-0000-0000-000000000000}", 0, 1) == NULL && n_messages == 1);
    EXPECT(create(NULL, 0, 1) == NULL);
}

static void no_logger(void)
{
    Tire t = create(token, 0, 0);
    EXPECT(t && step(t, 0.0, -1.0) == ERROR && set_one(t, KAPPA, NAN) == DISCARD);
    CALL(FreeInstance)(t);
}

static void no_instance(void)
{
    double v;
    EXPECT(step(NULL, 0.0, 0.1) == ERROR && set_one(NULL, KAPPA, 0.1) == ERROR && get(NULL, NULL, 0, &v) == ERROR);
    EXPECT(CALL(Reset)(NULL) == ERROR && CALL(Terminate)(NULL) == ERROR && restore(NULL, NULL) == ERROR);
    CALL(FreeInstance)(NULL);
}

static void derivatives_of_invalid_variables(void)
{
    double d = 0.0;
    WITH(t)
    {
        UNTOUCHED(t, ERROR, derive(t, KAPPA, LOAD, &d));
        UNTOUCHED(t, ERROR, derive(t, FY, FX, &d));
        UNTOUCHED(t, ERROR, derive(t, FY, 4000000000u, &d));
        EXPECT(derive(t, FY, LOAD, &d) == OK && isfinite(d));
    }
}

static void derivatives_at_the_edges(void)
{
    static const double loads[] = {-10.0, 0.0, 4100.0}, speeds[] = {-5.0, 0.0, 20.0}, slips[] = {-1.0, 0.0, 0.3};
    double d;
    int i;
    unsigned known;

    WITH(t)
    for (i = 0; i < 27; i++) {
        EXPECT(set_one(t, LOAD, loads[i % 3]) == OK && set_one(t, SPEED, speeds[i / 3 % 3]) == OK);
        EXPECT(set_one(t, KAPPA, slips[i / 9]) == OK && set_one(t, ALPHA, -slips[i / 9]) == OK);
        for (known = KAPPA; known < FX; known++) {
            d = NAN;
            EXPECT(derive(t, FY, known, &d) == OK && isfinite(d));
        }
        EXPECT(derive(t, MZ, BOUNDED, &d) == OK && isfinite(d));
    }
}

static void a_thousand_instances(void)
{
    static Tire all[1000];
    double found[N_FORCES], expected[N_FORCES];
    int i;

    WITH(t) forces(t, expected);
    for (i = 0; i < 1000; i++)
        all[i] = running();
    for (i = 0; i < 1000; i++) {
        forces(all[i], found);
        EXPECT(!memcmp(found, expected, sizeof found));
        CALL(FreeInstance)(all[i]);
    }
}

typedef struct {
    Tire tire;
    double sum[N_FORCES];
} Thread;

static void *drive(void *argument)
{
    Thread *self = argument;
    double found[N_FORCES];
    int i, k;

    for (i = 0; i < 2000; i++) {
        set_one(self->tire, ALPHA, 0.1 * sin(0.01 * i));
        set_one(self->tire, KAPPA, 0.1 * cos(0.013 * i));
        forces(self->tire, found);
        step(self->tire, 0.01 + 0.001 * i, 0.001);
        for (k = 0; k < N_FORCES; k++)
            self->sum[k] += found[k];
    }
    return NULL;
}

static void eight_threads(void)
{
    Thread alone = {running(), {0}}, threads[8];
    pthread_t running_threads[8];
    int i;

    drive(&alone);
    for (i = 0; i < 8; i++)
        threads[i] = (Thread){running(), {0}};
    for (i = 0; i < 8; i++)
        EXPECT(pthread_create(&running_threads[i], NULL, drive, &threads[i]) == 0);
    for (i = 0; i < 8; i++) {
        pthread_join(running_threads[i], NULL);
        EXPECT(!memcmp(threads[i].sum, alone.sum, sizeof alone.sum));
        CALL(FreeInstance)(threads[i].tire);
    }
    CALL(FreeInstance)(alone.tire);
}

#define CASE(name) {#name, name}
static const struct {
    const char *name;
    void (*run)(void);
} CASES[] = {
    CASE(input_nan), CASE(input_infinite), CASE(input_minus_infinite), CASE(parameter_nan), CASE(parameter_infinite),
    CASE(parameter_above_max), CASE(parameter_below_min), CASE(one_bad_of_many), CASE(unknown_reference_set),
    CASE(unknown_reference_read), CASE(output_set), CASE(time_set), CASE(lifted_wheel), CASE(standstill),
    CASE(locked_spinning_reverse), CASE(enormous_but_finite), CASE(step_zero), CASE(step_negative), CASE(step_nan),
    CASE(step_infinite), CASE(step_from_elsewhere), CASE(step_from_nan), CASE(step_beyond_stop),
    CASE(step_before_initialization), CASE(step_while_initializing), CASE(initialized_twice), CASE(start_time_nan),
    CASE(terminated), CASE(solver_calls_in_cosimulation), CASE(step_in_model_exchange), CASE(reset_and_reused),
    CASE(state_into_another_instance), CASE(serialized_state_from_outside), CASE(no_state_to_restore),
    CASE(small_buffer), CASE(wrong_token), CASE(no_logger), CASE(no_instance), CASE(derivatives_of_invalid_variables),
    CASE(derivatives_at_the_edges), CASE(a_thousand_instances), CASE(eight_threads),
};

int main(int argc, char **argv)
{
    size_t i;

    if (argc != 2)
        return 2;
    token = argv[1];
    for (i = 0; i < sizeof CASES / sizeof *CASES; i++) {
        case_name = CASES[i].name;
        wrong = 0;
        last_message[0] = 0;
        CASES[i].run();
        if (!wrong)
            printf("%s ok\n", case_name);
        failures += wrong;
    }
    return failures != 0;
}
