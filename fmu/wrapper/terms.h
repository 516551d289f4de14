/* The derivative of an output or a state derivative as a sum of terms: by slots of the model, and by the motion. */
#ifndef TERMS_H
#define TERMS_H

#include "state.h"

/* The kind of a term: a slot of chain_rule.h with the given slips, with the acting slips and states, or with the given
   slips and the states, or an entry of a tangent's `motion`, see contact.h. */
typedef enum { GIVEN, ACTING, DIRECT, MOTION } Point;

typedef struct {
    Point point;
    unsigned slot;
    double factor;
} Term;

/* The most terms of an unknown other than a force at a hub or the rate of the spin, which have one for each output of
   the model and two more. */
enum { FEW_TERMS = 5, MAX_TERMS = FEW_TERMS > N_OUTPUTS + 2 ? FEW_TERMS : N_OUTPUTS + 2 };

/* Find the terms of an unknown, in the host's signs.  Returns their number.  Call state_compute_outputs before. */
size_t terms_find(State *state, unsigned unknown, Term terms[MAX_TERMS]);

#endif
