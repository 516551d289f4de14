/* What follows from inputs, parameters and states: each is computed when it is needed, once after each change. */
#ifndef OUTPUTS_H
#define OUTPUTS_H

#include "state.h"

/* Compute the load, the contact and the relaxation lengths. */
void state_find_contact(State *state);
/* Direct feedthrough: the forces, the states as the host reads them, and their derivatives. */
void state_compute_outputs(State *state);
/* The extra outputs need the model's named quantities, which are computed only if the host reads one of them. */
void state_compute_extras(State *state);
/* Integrate the states of slips and effects over h seconds with constant inputs. */
void state_integrate(State *state, double h);

#endif
