/* The states of effects.  See effect_states.h.
 *
 * Direct states and hystereses along lags have exact updates.  A state that is driven by forces is integrated in steps
 * that grow with the time since the inputs have changed: the drive is a parabola through start, middle and end of a
 * step, and the values there are found by iteration, as in tirefmu's evaluation of a table.  A step whose values are not
 * found is halved.  Temperatures change slowly: forces at the middle of the whole step, with the temperatures of its
 * start, heat the tire, and the nodes exchange heat exactly.  model_config.h has FIRST_STEP (a share of the shortest
 * time constant), GROWTH (the ratio of successive steps) and the limits of the iteration.
 */
#include "effect_states.h"

#include "slips.h"
#include "state_laws.h"

#include <math.h>
#include <string.h>

/* Iterations end when no value changes by more than this share. */
#define CONVERGED 1e-14

/* By state: the index of its input, its first line in the results of `state_lines`, its kind, whether it is direct, whether
   it has a start value of its own, its lags (indices of states, -1 for none), and its named quantities.  The speed of an
   oscillator is the state behind its position; both are direct. */
typedef enum { BALANCE, SUM, PATH, PLAY, POSITION, VELOCITY, NODE } Law;
typedef struct {
    int input, line;
    Law law;
    int direct, started;
    int lags[2];
    int derivative, event;
} Memory;

static const Memory TABLE[N_MEMORY] = MEMORY_TABLE;

int memory_is_path(size_t i) { return TABLE[i].law == PATH || TABLE[i].law == PLAY; }
int memory_is_direct(size_t i) { return TABLE[i].direct || memory_is_path(i); }
unsigned memory_derivative(size_t i) { return (unsigned) TABLE[i].derivative; }
unsigned memory_event(size_t i) { return (unsigned) TABLE[i].event; }

static int is_driven(size_t i) { return !memory_is_direct(i) && TABLE[i].law != NODE; }
static int settles(size_t i) { return TABLE[i].law != SUM && !memory_is_path(i); }

static double target(const double lines[], size_t i) { return lines[TABLE[i].line]; }
static double rate(const double lines[], size_t i) { return lines[TABLE[i].line + 1]; }

static void find_lines(const State *state, const double inputs[], double lines[])
{
    model_state_lines(inputs, model_parameters(state), lines);
}

static void put(const double memory[N_MEMORY], double inputs[N_INPUTS])
{
    size_t i;

    for (i = 0; i < N_MEMORY; i++)
        inputs[TABLE[i].input] = memory[i];
}

/* ---------------------------------------------------------------- start */

/* Equilibrium at constant inputs for states that have one, by damped iteration; `memory` holds the others. */
static void settle(const State *state, const double inputs[N_INPUTS], double memory[N_MEMORY])
{
    double filled[N_INPUTS], lines[N_STATE_LINES], before;
    size_t i, k;
    int moving = 1;

    memcpy(filled, inputs, sizeof filled);
    for (i = 0; i < N_MEMORY; i++)
        if (settles(i) && !TABLE[i].started)
            memory[i] = 0.0;
    for (k = 0; moving && k < 2 * MAX_ITERATIONS; k++) {
        put(memory, filled);
        find_lines(state, filled, lines);
        moving = 0;
        for (i = 0; i < N_MEMORY; i++) {
            if (!settles(i) || TABLE[i].started)
                continue;
            before = memory[i];
            memory[i] = k == 0 ? target(lines, i) : 0.5 * (before + target(lines, i));
            moving |= fabs(memory[i] - before) > CONVERGED * fabs(memory[i]);
        }
    }
}

static void find_states(const State *state, const double inputs[N_INPUTS], double memory[N_MEMORY])
{
    memcpy(memory, state->continuous.memory, N_MEMORY * sizeof *memory);
    if (!state_has_begun(state))
        settle(state, inputs, memory);
}

void memory_fill(const State *state, double inputs[N_INPUTS])
{
    double memory[N_MEMORY];

    find_states(state, inputs, memory);
    put(memory, inputs);
}

void memory_show(const State *state, double memory[N_MEMORY]) { find_states(state, state->contact.inputs, memory); }

void memory_begin(State *state) { settle(state, state->contact.inputs, state->continuous.memory); }

/* ---------------------------------------------------------------- steps */

/* A state along the path of its lag, or of both, from their values at the start to those at the end. */
static double follow_path(size_t i, const double start[], const double end[], double width)
{
    const int a = TABLE[i].lags[0], b = TABLE[i].lags[1], plays = TABLE[i].law == PLAY;

    if (b < 0)
        return (plays ? state_play : state_dahl)(start[i], start[a], end[a], width);
    return (plays ? state_play_size : state_dahl_size)(start[i], start[a], start[b], end[a], end[b], width);
}

/* The states that forces do not drive, h seconds after a change of the inputs. */
static void follow_inputs(const double lines[], const double start[N_MEMORY], double h, double memory[N_MEMORY])
{
    size_t i;

    for (i = 0; i < N_MEMORY; i++) {
        const double u = target(lines, i);
        if (TABLE[i].law == POSITION) {
            const double x = start[i], v = start[i + 1], way = rate(lines, i) * h, loss = rate(lines, i + 1) * h;
            memory[i] = state_oscillator(x, v, u, u, u, way, loss, h);
            memory[i + 1] = state_oscillator_speed(x, v, u, u, u, way, loss, h);
        } else if (TABLE[i].direct && TABLE[i].law != VELOCITY)
            memory[i] = TABLE[i].law == SUM ? state_sum_linear(start[i], u, u, h)
                                            : state_lag_held(start[i], u, h > 0.0 ? rate(lines, i) * h : 0.0);
    }
    for (i = 0; i < N_MEMORY; i++)
        if (memory_is_path(i))
            memory[i] = follow_path(i, start, memory, 1.0 / rate(lines, i));
}

/* A driven state at the middle and at the end of a step, from the lines at start, middle and end. */
static void integrate_state(size_t i, const double lines[3][N_STATE_LINES], double h, double start, double *half,
                            double *end)
{
    const double u[] = {target(lines[0], i), target(lines[1], i), target(lines[2], i)};
    const double r[] = {rate(lines[0], i), rate(lines[1], i), rate(lines[2], i)};
    const double quarter = (3.0 * u[0] + 6.0 * u[1] - u[2]) / 8.0;

    if (TABLE[i].law == SUM) {
        *half = state_sum_curved(start, u[0], quarter, u[1], 0.5 * h);
        *end = state_sum_curved(start, u[0], u[1], u[2], h);
    } else {
        *half = state_lag_curved(start, u[0], quarter, u[1], h * (5.0 * r[0] + 8.0 * r[1] - r[2]) / 24.0);
        *end = state_lag_curved(start, u[0], u[1], u[2], h * (r[0] + 4.0 * r[1] + r[2]) / 6.0);
    }
}

/* One step of the driven states; `memory` has the other states at start, middle and end, and the driven ones at start.
   Returns whether their values were found. */
static int step_driven(State *state, double inputs[3][N_INPUTS], double memory[3][N_MEMORY], double h)
{
    double lines[3][N_STATE_LINES], half, end, change = 0.0, size;
    size_t i, k;
    int moving = 1, found = 1;

    for (i = 0; i < N_MEMORY; i++)
        if (!memory_is_direct(i)) /* temperatures have their values at the start of the whole step */
            memory[1][i] = memory[2][i] = memory[0][i];
    put(memory[0], inputs[0]);
    find_lines(state, inputs[0], lines[0]);
    for (k = 0; moving && k < MAX_ITERATIONS; k++) {
        moving = 0;
        found = 1;
        put(memory[1], inputs[1]);
        put(memory[2], inputs[2]);
        find_lines(state, inputs[1], lines[1]);
        find_lines(state, inputs[2], lines[2]);
        for (i = 0; i < N_MEMORY; i++) {
            if (!is_driven(i))
                continue;
            integrate_state(i, (const double(*)[N_STATE_LINES]) lines, h, memory[0][i], &half, &end);
            change = fmax(fabs(end - memory[2][i]), fabs(half - memory[1][i]));
            size = fmax(fabs(memory[0][i]), fmax(fabs(half), fabs(end)));
            moving |= !(change <= CONVERGED * size);
            found &= isfinite(half) && isfinite(end) && change <= ACCEPTED * size;
            memory[1][i] = half;
            memory[2][i] = end;
        }
    }
    return found;
}

static int is_finite(const double memory[N_MEMORY])
{
    size_t i;

    for (i = 0; i < N_MEMORY; i++)
        if (!isfinite(memory[i]))
            return 0;
    return 1;
}

/* All states and lagged slips from `begin` to `end`, seconds after a change of the inputs.  `lines` and `first` are the
   lines and the states at that change; `memory` has the states at `begin`, then those at `end`: NaN if not found. */
static void advance_states(State *state, const double lines[], const double first[N_MEMORY], double begin, double end,
                           int halvings, double memory[N_MEMORY])
{
    const double middle = 0.5 * (begin + end);
    double inputs[3][N_INPUTS], values[3][N_MEMORY], lagging[N_LAGGING];
    size_t i;

    memcpy(lagging, state->continuous.lagging, sizeof lagging);
    memcpy(values[0], memory, sizeof values[0]);
    follow_inputs(lines, first, middle, values[1]);
    follow_inputs(lines, first, end, values[2]);
    slips_acting(state, inputs[0]);
    slips_advance(state, 0.5 * (end - begin));
    slips_acting(state, inputs[1]);
    slips_advance(state, 0.5 * (end - begin));
    slips_acting(state, inputs[2]);
    if (step_driven(state, inputs, values, end - begin)) {
        memcpy(memory, values[2], sizeof values[2]);
    } else if (halvings < MAX_HALVINGS && is_finite(memory)) {
        memcpy(state->continuous.lagging, lagging, sizeof lagging);
        advance_states(state, lines, first, begin, middle, halvings + 1, memory);
        advance_states(state, lines, first, middle, end, halvings + 1, memory);
    } else
        for (i = 0; i < N_MEMORY; i++)
            memory[i] = NAN;
}

/* The shortest time constant of all that moves, as a rate. */
static double fastest(const State *state, const double lines[])
{
    double found = 0.0;
    LengthOrigin origin;
    size_t i;

    for (i = 0; i < N_SLIPS; i++)
        if (slips_lag(state, i))
            found = fmax(found, state->contact.rolling / slips_length(state, i, &origin));
    for (i = 0; i < N_MEMORY; i++)
        if (settles(i) && isfinite(rate(lines, i)))
            found = fmax(found, rate(lines, i));
    return found;
}

/* The states that are no temperatures, and the lagged slips; `given` has the inputs, `lines` the lines there. */
static void advance_others(State *state, const double lines[N_STATE_LINES], double h)
{
    double first[N_MEMORY], begin = 0.0, end = 0.0, size = FIRST_STEP / fastest(state, lines);

    memcpy(first, state->continuous.memory, sizeof first);
    for (; end < h; size *= GROWTH, begin = end) {
        end = size < h - begin ? begin + size : h; /* also for an infinite size */
        advance_states(state, lines, first, begin, end, 0, state->continuous.memory);
    }
}

#if N_TEMPERATURES > 0
#define N_NODES N_TEMPERATURES
/* More heat than this is not exchanged in a step, as a multiple of the stored heat: the temperatures are NaN. */
#define MAX_EXCHANGE 1e6
#define REMAINDER 1e-17

static const int NODES[N_NODES] = TEMPERATURES, LINES[N_NODES][N_NODES] = EXCHANGE;

/* result = x + share matrix y */
static void apply(double matrix[N_NODES][N_NODES], const double y[N_NODES], double share, const double x[N_NODES],
                  double result[N_NODES])
{
    size_t i, j;

    for (i = 0; i < N_NODES; i++) {
        double sum = 0.0;
        for (j = 0; j < N_NODES; j++)
            sum += matrix[i][j] * y[j];
        result[i] = x[i] + share * sum;
    }
}

/* The temperatures after h seconds of x' = A x + b, where `lines` give A and b: x grows by (exp(A h) - 1)/(A h) x' h, a
   series in parts of the step in which the norm of A h is at most 1/2. */
static void exchange_heat(const double lines[N_STATE_LINES], double h, double memory[N_MEMORY])
{
    double matrix[N_NODES][N_NODES], flow[N_NODES], sum[N_NODES], next[N_NODES], size = 0.0, parts, bound;
    size_t i, j;
    int k, terms = 1;

    for (i = 0; i < N_NODES; i++) {
        const size_t node = (size_t) NODES[i];
        double row = 0.0;
        for (j = 0; j < N_NODES; j++) {
            matrix[i][j] = h * (i == j ? -rate(lines, node) : LINES[i][j] < 0 ? 0.0 : lines[LINES[i][j]]);
            row += fabs(matrix[i][j]);
        }
        flow[i] = h * rate(lines, node) * (target(lines, node) - memory[node]);
        size = row > size ? row : size;
    }
    if (!(size < MAX_EXCHANGE)) {
        for (i = 0; i < N_NODES; i++)
            memory[NODES[i]] = NAN;
        return;
    }
    parts = fmax(1.0, ceil(2.0 * size));
    for (i = 0; i < N_NODES; i++) {
        flow[i] /= parts;
        for (j = 0; j < N_NODES; j++)
            matrix[i][j] /= parts;
    }
    for (bound = size / parts; bound > REMAINDER; bound *= size / parts / terms)
        terms++;
    for (; parts > 0.0; parts--) {
        memcpy(sum, flow, sizeof sum);
        for (k = terms; k > 1; k--) {
            apply(matrix, sum, 1.0 / k, flow, next);
            memcpy(sum, next, sizeof sum);
        }
        for (i = 0; i < N_NODES; i++)
            memory[NODES[i]] += sum[i];
        apply(matrix, sum, 1.0, flow, next);
        memcpy(flow, next, sizeof flow);
    }
}
#endif

/* Temperatures from the forces at the middle of the step, then the other states and the slips from its start. */
void memory_advance(State *state, double h)
{
    double lines[N_STATE_LINES];
    const int others = N_MEMORY > N_TEMPERATURES;
#if N_TEMPERATURES > 0
    double middle[N_INPUTS], values[N_MEMORY], warmed[N_MEMORY];
    const Continuous start = state->continuous;
    size_t i;

    memcpy(values, start.memory, sizeof values);
    memcpy(warmed, start.memory, sizeof warmed);
    slips_advance(state, 0.5 * h);
    slips_acting(state, middle);
    slips_advance(state, 0.5 * h);
    if (others) {
        find_lines(state, state->contact.inputs, lines);
        follow_inputs(lines, start.memory, 0.5 * h, values);
        state->continuous = start;
    }
    put(values, middle);
    find_lines(state, middle, lines);
    exchange_heat(lines, h, warmed);
#endif
    if (others) {
        find_lines(state, state->contact.inputs, lines);
        advance_others(state, lines, h);
    }
#if N_TEMPERATURES > 0
    for (i = 0; i < N_NODES; i++)
        state->continuous.memory[NODES[i]] = warmed[NODES[i]];
#endif
}

/* ---------------------------------------------------------------- derivatives */

void memory_rates(const State *state, double rates[N_MEMORY], double events[N_MEMORY])
{
    double given[N_INPUTS], acting[N_INPUTS], at_given[N_STATE_LINES], at_acting[N_STATE_LINES];
    size_t i;

    memcpy(given, state->contact.inputs, sizeof given);
    memory_fill(state, given);
    slips_acting(state, acting);
    memory_fill(state, acting);
    find_lines(state, given, at_given);
    find_lines(state, acting, at_acting);
    for (i = 0; i < N_MEMORY; i++) {
        const double *lines = memory_is_direct(i) ? at_given : at_acting;
        const double u = target(lines, i), r = rate(lines, i), x = given[TABLE[i].input];

        events[i] = TABLE[i].law == PATH ? u : 0.0;
        rates[i] = r * (u - x);
        if (TABLE[i].law == SUM) {
            rates[i] = u;
        } else if (TABLE[i].law == PATH) {
            rates[i] = ((u > 0.0) - (u < 0.0) - x) * fabs(u) * r;
        } else if (TABLE[i].law == PLAY) {
            const double margin = 1.0 - x * ((u > 0.0) - (u < 0.0));
            events[i] = margin > 0.0 ? margin : -1.0;
            rates[i] = margin > 0.0 ? u * r : 0.0;
        } else if (TABLE[i].law == POSITION) {
            rates[i] = given[TABLE[i + 1].input];
        } else if (TABLE[i].law == VELOCITY) {
            const double frequency = rate(lines, i - 1);
            rates[i] = frequency * frequency * (target(lines, i - 1) - given[TABLE[i - 1].input]) - r * x;
        }
        if (!state_has_begun(state))
            rates[i] = events[i] = 0.0;
    }
}

void memory_differentiate(const State *state, const double seeds[N_VALUES], Tangent *tangent)
{
    size_t i;

    for (i = 0; state_has_begun(state) && i < N_MEMORY; i++)
        tangent->acting[TABLE[i].input] = tangent->direct[TABLE[i].input] = seeds[FIRST_MEMORY + i];
}
