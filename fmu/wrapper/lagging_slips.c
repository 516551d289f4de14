/* Slips that lag: dx/dt = |V| / sigma (u - x) on kappa and tan(alpha).  See slips.h.
 *
 * With inputs held over a step V, sigma and u are constant and the exponential is the solution itself: the result
 * does not depend on how a stretch of time is cut into steps.
 */
#include "slips.h"

#include <math.h>
#include <string.h>

/* Below this relaxation length a slip acts at once, m. */
#define AT_ONCE 1e-6

static void given(const State *state, double slips[N_SLIPS])
{
    slips[LONGITUDINAL] = state->values[FIRST_INPUT + KAPPA];
    slips[LATERAL] = tan(state->values[FIRST_INPUT + ALPHA]);
}

static void find_lengths(State *state)
{
    if (!state->lengths_known)
        model_relaxation(state->values + FIRST_INPUT, state->values + FIRST_PARAMETER, state->lengths);
    state->lengths_known = 1;
}

/* So written that a length of NaN does not lag. */
static int lags(const State *state, size_t slip) { return state->lengths[slip] > AT_ONCE; }

void slips_acting(State *state, double inputs[N_INPUTS])
{
    double slips[N_SLIPS];
    size_t i;

    find_lengths(state);
    given(state, slips);
    for (i = 0; i < N_SLIPS; i++)
        if (state->mode >= STEPPING && lags(state, i))
            slips[i] = state->lagging[i];
    memcpy(inputs, state->values + FIRST_INPUT, N_INPUTS * sizeof *inputs);
    inputs[KAPPA] = state->values[FIRST_LOCAL + LONGITUDINAL] = slips[LONGITUDINAL];
    inputs[ALPHA] = state->values[FIRST_LOCAL + LATERAL] = atan(slips[LATERAL]);
}

int slips_follow(const State *state, size_t input)
{
    if (state->mode < STEPPING || (input != KAPPA && input != ALPHA))
        return 1;
    return !lags(state, input == KAPPA ? LONGITUDINAL : LATERAL);
}

void slips_begin(State *state) { given(state, state->lagging); }

void slips_advance(State *state, double h)
{
    double slips[N_SLIPS], rolled;
    size_t i;

    find_lengths(state);
    given(state, slips);
    for (i = 0; i < N_SLIPS; i++) {
        rolled = lags(state, i) ? h * (fabs(state->values[FIRST_INPUT + SPEED]) / state->lengths[i]) : HUGE_VAL;
        state->lagging[i] = exp(-rolled) * state->lagging[i] - expm1(-rolled) * slips[i];
    }
    state->outputs_known = 0;
}
