/* By what an output or a rate moves: its derivatives by slots of the model's lines, and by what stands beside them. */
#ifndef TERMS_H
#define TERMS_H

#include "instance.h"

/* Where a slot of chain_rule.h is taken: with slips as they are given, or as they act.  BESIDE is a place in a tangent's
   `moved`, see contact.h. */
typedef enum { GIVEN, ACTING, BESIDE } Point;

typedef struct {
    Point point;
    unsigned slot;
    double factor;
} Term;

enum { MOST_TERMS = 5 };

/* The terms of an unknown, in the host's signs.  Returns how many they are.  After state_compute_outputs. */
size_t terms_find(State *state, unsigned unknown, Term terms[MOST_TERMS]);

#endif
