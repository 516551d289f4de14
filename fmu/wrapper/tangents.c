/* Tangents of the model's inputs, and the values of its operations.  See tangents.h. */
#include "tangents.h"

#include "chain_rule.h"
#include "memory.h"
#include "slips.h"

#include <string.h>

void tangent_find_values(State *state, Point point, double values[N_SLOTS])
{
    double inputs[N_INPUTS];

    if (point == ACTING)
        slips_acting(state, inputs);
    else
        memcpy(inputs, state->contact.inputs, sizeof inputs);
    if (point != GIVEN)
        memory_fill(state, inputs);
    chain_values(inputs, model_parameters(state), 0.0, values);
}

void tangent_find_radius(const State *state, Radius *radius)
{
#if WHEEL
    double values[N_SLOTS], adjoints[N_SLOTS] = {0.0};

    chain_values(state->contact.inputs, model_parameters(state),
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

void tangent_find(State *state, const double seeds[N_VALUES], const Radius *radius, Tangent *tangent)
{
    contact_differentiate(state, seeds, radius, tangent);
    slips_differentiate(state, seeds, tangent);
    memcpy(tangent->direct, tangent->given, sizeof tangent->direct);
#if N_MEMORY > 0
    memory_differentiate(state, seeds, tangent);
#endif
}
