/* Directional and adjoint derivatives.  See instance.h.
 *
 * Forces by inputs and coefficients come from the model's own Jacobians where slips are inputs.  What else there is
 * (rates of states, quantities, wheel inputs) is differenced centrally in a copy of the state.
 */
#include "instance.h"

#include "contact.h"
#include "slips.h"

#include <math.h>
#include <string.h>

/* Of a difference, as a share of the value's size: it balances the error of the formula and that of rounding. */
#define STEP 1e-6

/* What is computed once for all knowns. */
typedef struct {
    State state;
    double by_inputs[N_OUTPUTS * N_INPUTS], by_parameters[N_OUTPUTS * N_COEFFICIENTS];
    double tangent; /* of the side slip that acts */
    int has_inputs, has_parameters;
} Workspace;

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
        if (kind != INPUT && kind != PARAMETER && !(knowns[i] >= FIRST_STATE && knowns[i] < FIRST_DERIVATIVE))
            return instance_refuse(self, STATUS_ERROR, "%s is no input, parameter or state", value_name(knowns[i]));
    }
    return STATUS_OK;
}

static void prepare(Workspace *work, const Instance *self)
{
    memcpy(&work->state, &self->state, sizeof work->state);
    work->has_inputs = work->has_parameters = 0;
    state_compute_outputs(&work->state);
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

static void differenced(Workspace *work, unsigned known, const unsigned unknowns[], size_t n, double column[])
{
    State *state = &work->state;
    const double middle = state->values[known], step = STEP * value_scale(state, known);
    const double above = middle + step, below = middle - step;
    const State before = *state;
    size_t i;

    move(state, known, above);
    state_compute_extras(state);
    for (i = 0; i < n; i++)
        column[i] = state->values[unknowns[i]];
    move(state, known, below);
    state_compute_extras(state);
    for (i = 0; i < n; i++)
        column[i] = (column[i] - state->values[unknowns[i]]) / (above - below);
    *state = before;
}

#if !WHEEL
/* Forces by an input or a coefficient, from the Jacobians; by a state, through the slip that it is. */
static void exact(Workspace *work, unsigned known, const unsigned unknowns[], size_t n, double column[])
{
    static const int passed[] = PASSED_ON;
    State *state = &work->state;
    const double *matrix = work->by_inputs;
    double inputs[N_INPUTS], factor = 1.0;
    size_t i, width = N_INPUTS, place = N_INPUTS;
    const int by_parameter = value_kind(known) == PARAMETER;

    slips_acting(state, inputs);
    if (by_parameter && !work->has_parameters)
        model_jacobian_parameters(inputs, state->values + FIRST_PARAMETER, work->by_parameters);
    if (!by_parameter && !work->has_inputs)
        model_jacobian_inputs(inputs, state->values + FIRST_PARAMETER, work->by_inputs);
    work->has_parameters |= by_parameter;
    work->has_inputs |= !by_parameter;
    if (by_parameter) {
        matrix = work->by_parameters;
        width = place = N_COEFFICIENTS; /* behind them stand options, between whose values nothing changes */
        if (known - FIRST_PARAMETER < N_COEFFICIENTS)
            place = known - FIRST_PARAMETER;
    } else if (known < FIRST_OUTPUT) {
        for (i = 0; i < N_INPUTS; i++)
            if (passed[i] == (int) (known - FIRST_INPUT))
                place = i;
    }
#if LAGS
    if (known < FIRST_OUTPUT && state_has_begun(state) &&
        ((place == KAPPA && slips_lag(state, LONGITUDINAL)) || (place == ALPHA && slips_lag(state, LATERAL))))
        factor = 0.0;
    if (known == FIRST_STATE + LONGITUDINAL)
        place = KAPPA, factor = state_has_begun(state) && slips_lag(state, LONGITUDINAL);
    if (known == FIRST_STATE + LATERAL) {
        place = ALPHA;
        factor = tan(inputs[ALPHA]);
        factor = state_has_begun(state) && slips_lag(state, LATERAL) ? 1.0 / (1.0 + factor * factor) : 0.0;
    }
#endif
#ifdef DISTANCE
    if (known == FIRST_DERIVATIVE - 1)
        place = DISTANCE;
#endif
    for (i = 0; i < n; i++)
        if (unknowns[i] < FIRST_PARAMETER)
            column[i] = place < width ? factor * matrix[(unknowns[i] - FIRST_OUTPUT) * width + place] *
                                            value_direction(unknowns[i]) * value_direction(known)
                                      : 0.0;
}
#endif

/* The derivatives of the unknowns by one known. */
static void find_column(Workspace *work, unsigned known, const unsigned unknowns[], size_t n, double column[])
{
    int others = WHEEL;
    size_t i;

    for (i = 0; i < n; i++)
        others |= unknowns[i] >= FIRST_PARAMETER;
    if (others)
        differenced(work, known, unknowns, n, column);
#if !WHEEL
    exact(work, known, unknowns, n, column);
#endif
}

Status instance_derivative(Instance *self, const unsigned unknowns[], size_t n_unknowns,
                           const unsigned knowns[], size_t n_knowns, const double seed[],
                           double sensitivity[])
{
    double column[N_VALUES];
    Workspace work;
    size_t i, j;

    if (expect_differentiable(self, unknowns, n_unknowns, knowns, n_knowns) != STATUS_OK)
        return STATUS_ERROR;
    if (n_unknowns > N_VALUES)
        return instance_refuse(self, STATUS_ERROR, "there are not %lu unknowns", (unsigned long) n_unknowns);
    prepare(&work, self);
    for (i = 0; i < n_unknowns; i++)
        sensitivity[i] = 0.0;
    for (j = 0; j < n_knowns; j++) {
        find_column(&work, knowns[j], unknowns, n_unknowns, column);
        for (i = 0; i < n_unknowns; i++)
            sensitivity[i] += seed[j] * column[i];
    }
    return STATUS_OK;
}

Status instance_adjoint(Instance *self, const unsigned unknowns[], size_t n_unknowns, const unsigned knowns[],
                        size_t n_knowns, const double seed[], double sensitivity[])
{
    double column[N_VALUES];
    Workspace work;
    size_t i, j;

    if (expect_differentiable(self, unknowns, n_unknowns, knowns, n_knowns) != STATUS_OK)
        return STATUS_ERROR;
    if (n_unknowns > N_VALUES)
        return instance_refuse(self, STATUS_ERROR, "there are not %lu unknowns", (unsigned long) n_unknowns);
    prepare(&work, self);
    for (j = 0; j < n_knowns; j++) {
        find_column(&work, knowns[j], unknowns, n_unknowns, column);
        sensitivity[j] = 0.0;
        for (i = 0; i < n_unknowns; i++)
            sensitivity[j] += seed[i] * column[i];
    }
    return STATUS_OK;
}
