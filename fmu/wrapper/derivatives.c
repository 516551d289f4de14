/* Directional and adjoint derivatives.  See instance.h.
 *
 * How unknowns move with the model's lines is told by terms.h, how the lines' inputs move with the host's values by
 * contact.h and slips.h; what is between goes along the lines, forward for the sum of the seeds or backward from the
 * sum of the unknowns.  Near the standstill of a wheel, where limits and dampers act, all is differenced.
 */
#include "instance.h"

#include "chain_rule.h"
#include "contact.h"
#include "slips.h"
#include "terms.h"

#include <string.h>

/* Of a difference, as a share of the value's size: it balances the error of the formula and that of rounding. */
#define STEP 1e-6

/* False of every reference where there are no states. */
static int is_state(unsigned reference)
{
    unsigned state;

    for (state = FIRST_STATE; state < FIRST_DERIVATIVE; state++)
        if (reference == state)
            return 1;
    return 0;
}

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
        if (kind != OUTPUT && !(unknowns[i] >= FIRST_DERIVATIVE && kind == LOCAL))
            return instance_refuse(self, STATUS_ERROR, "%s is no output and no derivative", value_name(unknowns[i]));
    }
    for (i = 0; i < n_knowns; i++) {
        kind = value_kind(knowns[i]);
        if (kind != INPUT && kind != PARAMETER && !is_state(knowns[i]))
            return instance_refuse(self, STATUS_ERROR, "%s is no input, parameter or state", value_name(knowns[i]));
    }
    if (n_unknowns > N_VALUES)
        return instance_refuse(self, STATUS_ERROR, "there are not %lu unknowns", (unsigned long) n_unknowns);
    return STATUS_OK;
}

/* What stands in the slots of the model's lines where slips are as given, or act. */
static void find_values(State *state, Point point, double values[N_SLOTS])
{
    double inputs[N_INPUTS];

    slips_acting(state, inputs);
    chain_values(point == GIVEN ? state->contact.inputs : inputs, state->values + FIRST_PARAMETER, 0.0, values);
}

static void find_radius(const State *state, Radius *radius)
{
#if WHEEL
    double values[N_SLOTS], adjoints[N_SLOTS] = {0.0};

    chain_values(state->contact.inputs, state->values + FIRST_PARAMETER,
                 host_value(state, FIRST_INPUT + HOST_TURNING), values);
    adjoints[ROLLING_RADIUS] = 1.0;
    chain_backward(values, adjoints);
    radius->length = values[ROLLING_RADIUS];
    memcpy(radius->by, adjoints, sizeof radius->by);
#else
    (void) state;
    memset(radius, 0, sizeof *radius);
#endif
}

static void find_tangent(State *state, const double seeds[N_VALUES], const Radius *radius, Tangent *tangent)
{
    contact_differentiate(state, seeds, radius, tangent);
    slips_differentiate(state, seeds, tangent);
}

/* Add the terms at a point for all seeds. */
static void add_forward(State *state, Point point, const Tangent *tangent, const double seeds[N_VALUES],
                        const unsigned unknowns[], size_t n, double sensitivity[])
{
    const double *inputs = point == GIVEN ? tangent->given : tangent->acting;
    double values[N_SLOTS], tangents[N_SLOTS];
    Term terms[MOST_TERMS];
    size_t i, k, count;
    int carried = 0;

    for (i = 0; i < n; i++) {
        count = terms_find(state, unknowns[i], terms);
        for (k = 0; k < count; k++) {
            if (terms[k].point != point)
                continue;
            if (!carried) {
                find_values(state, point, values);
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

static void add_beside(State *state, const Tangent *tangent, const unsigned unknowns[], size_t n, double sensitivity[])
{
    Term terms[MOST_TERMS];
    size_t i, k, count;

    for (i = 0; i < n; i++) {
        count = terms_find(state, unknowns[i], terms);
        for (k = 0; k < count; k++)
            if (terms[k].point == BESIDE)
                sensitivity[i] += terms[k].factor * tangent->moved[terms[k].slot];
    }
}

/* The derivatives of the weighted sum of the unknowns' terms at a point: by the leaves, or BESIDE by what moved. */
static void find_gradient(State *state, Point point, const unsigned unknowns[], size_t n, const double weights[],
                          double gradient[])
{
    double values[N_SLOTS], adjoints[N_SLOTS] = {0.0};
    Term terms[MOST_TERMS];
    size_t i, k, count;

    for (i = 0; i < n; i++) {
        count = terms_find(state, unknowns[i], terms);
        for (k = 0; k < count; k++)
            if (terms[k].point == point)
                adjoints[terms[k].slot] += terms[k].factor * weights[i];
    }
    if (point != BESIDE) {
        find_values(state, point, values);
        chain_backward(values, adjoints);
    }
    memcpy(gradient, adjoints, (point == BESIDE ? N_MOVED : N_LEAVES) * sizeof *gradient);
}

static double product(const double a[], const double b[], size_t n)
{
    double sum = 0.0;
    size_t i;

    for (i = 0; i < n; i++)
        sum += a[i] * b[i];
    return sum;
}

/* What a known adds to a weighted sum of unknowns, by their gradients at both points and beside. */
static double weighed(State *state, unsigned known, const Radius *radius, const double given[], const double acting[],
                      const double beside[])
{
    double seeds[N_VALUES] = {0.0};
    const double *parameters = seeds + FIRST_PARAMETER;
    Tangent tangent;

    seeds[known] = value_direction(known);
    find_tangent(state, seeds, radius, &tangent);
    return product(given, tangent.given, N_INPUTS) + product(given + FIRST_PARAMETER_LEAF, parameters, N_PARAMETERS) +
           product(acting, tangent.acting, N_INPUTS) + product(acting + FIRST_PARAMETER_LEAF, parameters, N_PARAMETERS) +
           product(beside, tangent.moved, N_MOVED);
}

static void move(State *state, unsigned known, double value)
{
    state->values[known] = value;
#if N_STATES > 0
    if (known >= FIRST_STATE && known < FIRST_DERIVATIVE) {
#ifdef DISTANCE
        if (known == FIRST_DERIVATIVE - 1)
            state->distance = value;
        else
#endif
            state->lagging[known - FIRST_STATE] = host_value(state, known);
    }
#endif
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
    state_compute_outputs(state);
    for (i = 0; i < n_unknowns; i++)
        sensitivity[i] = 0.0;
    for (j = 0; j < n_knowns && !contact_is_smooth(state); j++) {
        find_differences(state, knowns[j], unknowns, n_unknowns, column);
        for (i = 0; i < n_unknowns; i++)
            sensitivity[i] += seed[j] * column[i];
    }
    if (!contact_is_smooth(state))
        return STATUS_OK;
    for (j = 0; j < n_knowns; j++)
        seeds[knowns[j]] += seed[j] * value_direction(knowns[j]);
    find_radius(state, &radius);
    find_tangent(state, seeds, &radius, &tangent);
    add_forward(state, GIVEN, &tangent, seeds, unknowns, n_unknowns, sensitivity);
    add_forward(state, ACTING, &tangent, seeds, unknowns, n_unknowns, sensitivity);
    add_beside(state, &tangent, unknowns, n_unknowns, sensitivity);
    return STATUS_OK;
}

Status instance_adjoint(Instance *self, const unsigned unknowns[], size_t n_unknowns, const unsigned knowns[],
                        size_t n_knowns, const double seed[], double sensitivity[])
{
    State *state = &self->state;
    double given[N_LEAVES], acting[N_LEAVES], beside[N_MOVED], column[N_VALUES];
    Radius radius;
    size_t j;

    if (expect_differentiable(self, unknowns, n_unknowns, knowns, n_knowns) != STATUS_OK)
        return STATUS_ERROR;
    state_compute_outputs(state);
    for (j = 0; j < n_knowns && !contact_is_smooth(state); j++) {
        find_differences(state, knowns[j], unknowns, n_unknowns, column);
        sensitivity[j] = product(seed, column, n_unknowns);
    }
    if (!contact_is_smooth(state))
        return STATUS_OK;
    find_radius(state, &radius);
    find_gradient(state, GIVEN, unknowns, n_unknowns, seed, given);
    find_gradient(state, ACTING, unknowns, n_unknowns, seed, acting);
    find_gradient(state, BESIDE, unknowns, n_unknowns, seed, beside);
    for (j = 0; j < n_knowns; j++)
        sensitivity[j] = weighed(state, knowns[j], &radius, given, acting, beside);
    return STATUS_OK;
}
