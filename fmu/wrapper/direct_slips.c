/* Slips without lag.  See slips.h. */
#include "slips.h"

#include <string.h>

void slips_find_lengths(State *state) { (void) state; }

void slips_acting(const State *state, double inputs[N_INPUTS])
{
    memcpy(inputs, state->contact.inputs, N_INPUTS * sizeof *inputs);
}

int slips_lag(const State *state, size_t slip)
{
    (void) state;
    (void) slip;
    return 0;
}

void slips_begin(State *state) { (void) state; }

int slips_settle(State *state)
{
    (void) state;
    return 0;
}

void slips_advance(State *state, double h)
{
    (void) state;
    (void) h;
}

double slips_length(const State *state, size_t slip, LengthOrigin *origin)
{
    (void) state;
    (void) slip;
    *origin = CONSTANT_LENGTH;
    return 1.0;
}

void slips_differentiate(const State *state, const double seeds[N_VALUES], Tangent *tangent)
{
    (void) state;
    (void) seeds;
    memcpy(tangent->acting, tangent->given, sizeof tangent->acting);
    memset(tangent->motion + LAGGING, 0, N_LAGGING * sizeof *tangent->motion);
}

void slips_show(const State *state, double slips[], double rates[])
{
    (void) state;
    (void) slips;
    (void) rates;
}
