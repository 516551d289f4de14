/* The change of an output or a state derivative for changes of the host's values: a sum of changes of the model's slots
   and of the motion. */
#ifndef CHANGES_H
#define CHANGES_H

#include "tangents.h"

/* Begin with the seeds of the host's values, in the model's signs; with hub inputs, those of the motion and of the
   model's parameters are computed.  Call state_compute_outputs before; the seeds must live as long as the changes. */
void changes_begin(Changes *changes, State *state, double seeds[N_VALUES]);
/* The change of an output or a state derivative, in the host's signs. */
double change_of_value(Changes *changes, unsigned unknown);

#endif
