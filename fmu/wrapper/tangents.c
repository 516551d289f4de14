/* The changes of the model's slots.  See tangents.h. */
#include "tangents.h"

#include "chain_rule.h"
#include "effect_states.h"
#include "slips.h"

#include <string.h>

void changes_at_contact(Changes *changes, State *state, const double seeds[N_VALUES])
{
    Tangent *tangent = &changes->tangent;

    changes->state = state;
    changes->seeds = seeds;
    memset(changes->known, 0, sizeof changes->known);
    contact_differentiate(state, seeds, tangent);
    slips_differentiate(state, seeds, tangent);
    memcpy(tangent->direct, tangent->given, sizeof tangent->direct);
#if N_MEMORY > 0
    memory_differentiate(state, seeds, tangent);
#endif
}

static void find_slots(Changes *changes, Point point)
{
    const Tangent *tangent = &changes->tangent;
    const double *moved = point == GIVEN ? tangent->given : point == DIRECT ? tangent->direct : tangent->acting;
    double inputs[N_INPUTS], values[N_SLOTS], *slots = changes->slots[point];

    if (point == ACTING)
        slips_acting(changes->state, inputs);
    else
        memcpy(inputs, changes->state->contact.inputs, sizeof inputs);
    if (point != GIVEN)
        memory_fill(changes->state, inputs);
    chain_values(inputs, model_parameters(changes->state), 0.0, values);
    memcpy(slots, moved, N_INPUTS * sizeof *moved);
    memcpy(slots + FIRST_PARAMETER_LEAF, changes->seeds + FIRST_PARAMETER, N_PARAMETERS * sizeof *slots);
    slots[TURNING_LEAF] = 0.0;
    chain_forward(values, slots);
    changes->known[point] = 1;
}

double change_of_slot(Changes *changes, Point point, unsigned slot)
{
    if (!changes->known[point])
        find_slots(changes, point);
    return changes->slots[point][slot];
}
