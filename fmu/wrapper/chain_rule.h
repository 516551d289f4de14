/* Derivatives of the model along its lines, one operation after the other.
 *
 * A slot is a place for a number: the leaves (inputs, parameters, the speed at which a wheel turns), constants, and the
 * result of every operation, as the model's operations.h lists them.
 */
#ifndef CHAIN_RULE_H
#define CHAIN_RULE_H

#include "instance.h"

/* Where parameters begin among the leaves, and the last leaf. */
enum { FIRST_PARAMETER_LEAF = N_INPUTS, TURNING_LEAF = N_LEAVES - 1 };

/* The slots of a force and of a named quantity. */
unsigned chain_force(unsigned i);
unsigned chain_quantity(unsigned i);

/* What stands in every slot. */
void chain_values(const double inputs[N_INPUTS], const double parameters[N_PARAMETERS], double turning,
                  double values[N_SLOTS]);
/* From the tangents of the leaves to those of every slot. */
void chain_forward(const double values[N_SLOTS], double tangents[N_SLOTS]);
/* From the weights of some slots to the derivatives of the weighted sum by the leaves. */
void chain_backward(const double values[N_SLOTS], double adjoints[N_SLOTS]);

#endif
