/* Directional and adjoint derivatives.  See instance.h.
 *
 * terms.h has the derivatives of the unknowns by the model's operations, contact.h and slips.h those of the model's
 * inputs by the host's values.  chain_rule.h connects them: in forward mode for the directional derivative, in reverse
 * mode for the adjoint derivative.  Near standstill of a wheel, where limits and dampers act, and with a road inside the
 * FMU, the derivatives are central differences.
 */
#include "instance.h"

#include "chain_rule.h"
#include "contact.h"
#include "hub.h"
#include "outputs.h"
#include "spin.h"
#include "tangents.h"

#include <string.h>

/* Step of a difference, relative to the size of the value: it balances truncation and rounding errors. */
#define STEP 1e-6

/* False for every reference if there are no states. */
static int is_state(unsigned reference)
{
    unsigned state;

    if (SPIN && reference == SPIN_VALUE)
        return 1;
    for (state = FIRST_STATE; state < FIRST_DERIVATIVE; state++)
        if (reference == state)
            return 1;
    return 0;
}

static int is_smooth(const State *state) { return !ROAD && contact_is_smooth(state); }

static Status expect_differentiable(const Instance *self, const unsigned unknowns[], size_t n_unknowns,
                                    const unsigned knowns[], size_t n_knowns)
{
    size_t i;
    int kind;

    if (instance_expect_known(self, unknowns, n_unknowns) != STATUS_OK ||
        instance_expect_known(self, knowns, n_knowns) != STATUS_OK)
        return STATUS_ERROR;
    for (i = 0; i < n_unknowns; i++) {
        kind = value_kind(unknowns[i]);
        if (kind != OUTPUT && !(unknowns[i] >= FIRST_DERIVATIVE && kind == LOCAL) &&
            !(unknowns[i] < FIRST_OUTPUT && kind == STORED))
            return instance_refuse(self, STATUS_ERROR, "%s is neither an output nor a derivative",
                                   value_name(unknowns[i]));
    }
    for (i = 0; i < n_knowns; i++) {
        kind = value_kind(knowns[i]);
        if (kind != INPUT && kind != PARAMETER && !is_state(knowns[i]))
            return instance_refuse(self, STATUS_ERROR, "%s is not an input, a parameter or a state",
                                   value_name(knowns[i]));
    }
    if (n_unknowns > N_VALUES)
        return instance_refuse(self, STATUS_ERROR, "the FMU has fewer than %lu unknowns", (unsigned long) n_unknowns);
    return STATUS_OK;
}

static Status expect_arrays(const Instance *self, const double seed[], size_t n_seed, const double sensitivity[],
                            size_t n_sensitivity)
{
    if (instance_expect_pointer(self, seed, n_seed, "the seed") != STATUS_OK)
        return STATUS_ERROR;
    return instance_expect_pointer(self, sensitivity, n_sensitivity, "the sensitivity");
}

/* The tangents for seeds; with hub inputs, complete the seeds by those of the motion and of the model's parameters. */
static void prepare(State *state, double seeds[N_VALUES], const Radius *radius, Tangent *tangent)
{
#if HUB
    hub_differentiate(state, seeds, &tangent->motion[HUB_CHANGE]);
#endif
    tangent_find(state, seeds, radius, tangent);
#if SPIN
    spin_differentiate(state, seeds, tangent->motion);
#endif
}

/* Add the terms with one kind of slips for all seeds. */
static void add_forward(State *state, Point point, const Tangent *tangent, const double seeds[N_VALUES],
                        const unsigned unknowns[], size_t n, double sensitivity[])
{
    const double *inputs = point == GIVEN ? tangent->given : point == DIRECT ? tangent->direct : tangent->acting;
    double values[N_SLOTS], tangents[N_SLOTS];
    Term terms[MAX_TERMS];
    size_t i, k;
    int carried = 0;

    for (i = 0; i < n; i++) {
        const size_t count = terms_find(state, unknowns[i], terms);

        for (k = 0; k < count; k++) {
            if (terms[k].point != point)
                continue;
            if (!carried) {
                tangent_find_values(state, point, values);
                memcpy(tangents, inputs, N_INPUTS * sizeof *inputs);
                memcpy(tangents + FIRST_PARAMETER_LEAF, seeds + FIRST_PARAMETER, N_PARAMETERS * sizeof *seeds);
                tangents[TURNING_LEAF] = 0.0;
                chain_forward(values, tangents);
                carried = 1;
            }
            sensitivity[i] += terms[k].factor * tangents[terms[k].slot];
        }
    }
}

static void add_motion(State *state, const Tangent *tangent, const unsigned unknowns[], size_t n, double sensitivity[])
{
    Term terms[MAX_TERMS];
    size_t i, k;

    for (i = 0; i < n; i++) {
        const size_t count = terms_find(state, unknowns[i], terms);

        for (k = 0; k < count; k++)
            if (terms[k].point == MOTION)
                sensitivity[i] += terms[k].factor * tangent->motion[terms[k].slot];
    }
}

/* The derivatives of a weighted sum of the unknowns' terms of one kind: by the leaves, or for MOTION by the motion. */
static void find_gradient(State *state, Point point, const unsigned unknowns[], size_t n, const double weights[],
                          double gradient[])
{
    double adjoints[N_SLOTS] = {0.0};
    Term terms[MAX_TERMS];
    size_t i, k;

    for (i = 0; i < n; i++) {
        const size_t count = terms_find(state, unknowns[i], terms);

        for (k = 0; k < count; k++)
            if (terms[k].point == point)
                adjoints[terms[k].slot] += terms[k].factor * weights[i];
    }
    if (point != MOTION) {
        double values[N_SLOTS];

        tangent_find_values(state, point, values);
        chain_backward(values, adjoints);
    }
    memcpy(gradient, adjoints, (point == MOTION ? N_MOTION : N_LEAVES) * sizeof *gradient);
}

static double product(const double a[], const double b[], size_t n)
{
    double sum = 0.0;
    size_t i;

    for (i = 0; i < n; i++)
        sum += a[i] * b[i];
    return sum;
}

/* The derivative of a weighted sum of unknowns by one known, from the gradients of the kinds of terms. */
static double weighted_derivative(State *state, unsigned known, const Radius *radius, const double given[],
                                  const double acting[], const double direct[], const double motion[])
{
    double seeds[N_VALUES] = {0.0};
    const double *parameters = seeds + FIRST_PARAMETER;
    Tangent tangent;

    seeds[known] = value_direction(known);
    prepare(state, seeds, radius, &tangent);
    return product(given, tangent.given, N_INPUTS) + product(given + FIRST_PARAMETER_LEAF, parameters, N_PARAMETERS) +
           product(acting, tangent.acting, N_INPUTS) + product(acting + FIRST_PARAMETER_LEAF, parameters, N_PARAMETERS) +
           product(direct, tangent.direct, N_INPUTS) + product(direct + FIRST_PARAMETER_LEAF, parameters, N_PARAMETERS) +
           product(motion, tangent.motion, N_MOTION);
}

static void move(State *state, unsigned known, double value)
{
    if (is_state(known))
        state_set(state, known, value);
    else
        state->values[known] = value;
    state_changed(state);
}

/* The derivatives of the unknowns by one known. */
static void find_differences(const State *before, unsigned known, const unsigned unknowns[], size_t n, double column[])
{
    const double middle = before->values[known], step = STEP * value_scale(before, known);
    const double above = middle + step, below = middle - step;
    State state = *before;
    size_t i;

    move(&state, known, above);
    state_compute_extras(&state);
    for (i = 0; i < n; i++)
        column[i] = state.values[unknowns[i]];
    move(&state, known, below);
    state_compute_extras(&state);
    for (i = 0; i < n; i++)
        column[i] = (column[i] - state.values[unknowns[i]]) / (above - below);
}

Status instance_derivative(Instance *self, const unsigned unknowns[], size_t n_unknowns, const unsigned knowns[],
                           size_t n_knowns, const double seed[], double sensitivity[])
{
    State *state = &self->state;
    double seeds[N_VALUES] = {0.0}, column[N_VALUES];
    Tangent tangent;
    Radius radius;
    size_t i, j;

    if (expect_differentiable(self, unknowns, n_unknowns, knowns, n_knowns) != STATUS_OK)
        return STATUS_ERROR;
    if (expect_arrays(self, seed, n_knowns, sensitivity, n_unknowns) != STATUS_OK)
        return STATUS_ERROR;
    state_compute_outputs(state);
    for (i = 0; i < n_unknowns; i++)
        sensitivity[i] = 0.0;
    for (j = 0; j < n_knowns && !is_smooth(state); j++) {
        find_differences(state, knowns[j], unknowns, n_unknowns, column);
        for (i = 0; i < n_unknowns; i++)
            sensitivity[i] += seed[j] * column[i];
    }
    if (!is_smooth(state))
        return instance_expect_finite(self, sensitivity, n_unknowns, "a derivative");
    for (j = 0; j < n_knowns; j++)
        seeds[knowns[j]] += seed[j] * value_direction(knowns[j]);
    tangent_find_radius(state, &radius);
    prepare(state, seeds, &radius, &tangent);
    add_forward(state, GIVEN, &tangent, seeds, unknowns, n_unknowns, sensitivity);
    add_forward(state, ACTING, &tangent, seeds, unknowns, n_unknowns, sensitivity);
    add_forward(state, DIRECT, &tangent, seeds, unknowns, n_unknowns, sensitivity);
    add_motion(state, &tangent, unknowns, n_unknowns, sensitivity);
    return instance_expect_finite(self, sensitivity, n_unknowns, "a derivative");
}

Status instance_adjoint(Instance *self, const unsigned unknowns[], size_t n_unknowns, const unsigned knowns[],
                        size_t n_knowns, const double seed[], double sensitivity[])
{
    State *state = &self->state;
    double given[N_LEAVES], acting[N_LEAVES], direct[N_LEAVES], motion[N_MOTION], column[N_VALUES];
    Radius radius;
    size_t j;

    if (expect_differentiable(self, unknowns, n_unknowns, knowns, n_knowns) != STATUS_OK)
        return STATUS_ERROR;
    if (expect_arrays(self, seed, n_unknowns, sensitivity, n_knowns) != STATUS_OK)
        return STATUS_ERROR;
    state_compute_outputs(state);
    for (j = 0; j < n_knowns && !is_smooth(state); j++) {
        find_differences(state, knowns[j], unknowns, n_unknowns, column);
        sensitivity[j] = product(seed, column, n_unknowns);
    }
    if (!is_smooth(state))
        return instance_expect_finite(self, sensitivity, n_knowns, "a derivative");
    tangent_find_radius(state, &radius);
    find_gradient(state, GIVEN, unknowns, n_unknowns, seed, given);
    find_gradient(state, ACTING, unknowns, n_unknowns, seed, acting);
    find_gradient(state, DIRECT, unknowns, n_unknowns, seed, direct);
    find_gradient(state, MOTION, unknowns, n_unknowns, seed, motion);
    for (j = 0; j < n_knowns; j++)
        sensitivity[j] = weighted_derivative(state, knowns[j], &radius, given, acting, direct, motion);
    return instance_expect_finite(self, sensitivity, n_knowns, "a derivative");
}
