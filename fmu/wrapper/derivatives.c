/* Directional and adjoint derivatives.  See instance.h.
 *
 * A column has the derivatives of all unknowns by one value: exact ones (changes.h), or central differences near
 * standstill of a wheel, where limits and dampers act.
 */
#include "instance.h"

#include "changes.h"
#include "contact.h"
#include "outputs.h"

/* Step of a difference, relative to the size of the value: it balances truncation and rounding errors. */
#define STEP 1e-6

static Status expect_differentiable(const Instance *self, const unsigned unknowns[], size_t n_unknowns,
                                    const unsigned knowns[], size_t n_knowns)
{
    size_t i;

    if (instance_expect_known(self, unknowns, n_unknowns) != STATUS_OK ||
        instance_expect_known(self, knowns, n_knowns) != STATUS_OK)
        return STATUS_ERROR;
    for (i = 0; i < n_unknowns; i++) {
        const unsigned r = unknowns[i];
        const int kind = value_kind(r);

        if (kind != OUTPUT && !(r >= FIRST_DERIVATIVE && kind == LOCAL) && !(r < FIRST_OUTPUT && kind == STORED))
            return instance_refuse(self, STATUS_ERROR, "%s is neither an output nor a derivative", value_name(r));
    }
    for (i = 0; i < n_knowns; i++) {
        const unsigned r = knowns[i];

        if (value_kind(r) != INPUT && value_kind(r) != PARAMETER && !value_is_state(r))
            return instance_refuse(self, STATUS_ERROR, "%s is not an input, a parameter or a state", value_name(r));
    }
    if (n_unknowns > N_VALUES)
        return instance_refuse(self, STATUS_ERROR, "the FMU has fewer than %lu unknowns", (unsigned long) n_unknowns);
    return STATUS_OK;
}

static void move(State *state, unsigned known, double value)
{
    if (value_is_state(known))
        state_set(state, known, value);
    else
        state->values[known] = value;
    state_changed(state);
}

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

/* The derivatives of the unknowns by one known. */
static void find_column(State *state, unsigned known, const unsigned unknowns[], size_t n, double column[])
{
    double seeds[N_VALUES] = {0.0};
    Changes changes;
    size_t i;

    if (!contact_is_smooth(state)) {
        find_differences(state, known, unknowns, n, column);
        return;
    }
    seeds[known] = value_direction(known);
    changes_begin(&changes, state, seeds);
    for (i = 0; i < n; i++)
        column[i] = change_of_value(&changes, unknowns[i]);
}

/* Add products of seeds and derivatives to the sensitivities: of unknowns, or adjoint, of knowns. */
static Status add_products(Instance *self, const unsigned unknowns[], size_t n_unknowns, const unsigned knowns[],
                           size_t n_knowns, const double seed[], double sensitivity[], int adjoint)
{
    const size_t n_seed = adjoint ? n_unknowns : n_knowns, n_sensitivity = adjoint ? n_knowns : n_unknowns;
    double column[N_VALUES];
    size_t i, j;

    if (expect_differentiable(self, unknowns, n_unknowns, knowns, n_knowns) != STATUS_OK ||
        instance_expect_pointer(self, seed, n_seed, "the seed") != STATUS_OK ||
        instance_expect_pointer(self, sensitivity, n_sensitivity, "the sensitivity") != STATUS_OK)
        return STATUS_ERROR;
    state_compute_rates(&self->state);
    for (i = 0; i < n_sensitivity; i++)
        sensitivity[i] = 0.0;
    for (j = 0; j < n_knowns; j++) {
        find_column(&self->state, knowns[j], unknowns, n_unknowns, column);
        for (i = 0; i < n_unknowns; i++)
            sensitivity[adjoint ? j : i] += seed[adjoint ? i : j] * column[i];
    }
    return instance_expect_finite(self, sensitivity, n_sensitivity, "a derivative");
}

Status instance_derivative(Instance *self, const unsigned unknowns[], size_t n_unknowns, const unsigned knowns[],
                           size_t n_knowns, const double seed[], double sensitivity[])
{
    return add_products(self, unknowns, n_unknowns, knowns, n_knowns, seed, sensitivity, 0);
}

Status instance_adjoint(Instance *self, const unsigned unknowns[], size_t n_unknowns, const unsigned knowns[],
                        size_t n_knowns, const double seed[], double sensitivity[])
{
    return add_products(self, unknowns, n_unknowns, knowns, n_knowns, seed, sensitivity, 1);
}
