/* Derivatives of the model by the chain rule, one operation after the other.
 *
 * A slot is an index into an array of values: the leaves (inputs, parameters, the angular speed of the wheel), the
 * constants, and the result of every operation, in the order of the model's operations.h.
 */
#ifndef CHAIN_RULE_H
#define CHAIN_RULE_H

#include "state.h"

/* The first parameter among the leaves, and the last leaf. */
enum { FIRST_PARAMETER_LEAF = N_INPUTS, TURNING_LEAF = N_LEAVES - 1 };

/* The slots of a force and of a named quantity. */
unsigned chain_force(unsigned i);
unsigned chain_quantity(unsigned i);

/* Compute the value of every slot. */
void chain_values(const double inputs[N_INPUTS], const double parameters[N_PARAMETERS], double turning,
                  double values[N_SLOTS]);
/* Forward mode: from the tangents of the leaves to the tangents of every slot. */
void chain_forward(const double values[N_SLOTS], double tangents[N_SLOTS]);
/* Reverse mode: from weights of slots to the derivatives of the weighted sum by the leaves. */
void chain_backward(const double values[N_SLOTS], double adjoints[N_SLOTS]);

#endif
