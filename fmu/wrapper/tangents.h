/* Changes of the model's slots (chain_rule.h) and of the motion (contact.h) for changes of the host's values. */
#ifndef TANGENTS_H
#define TANGENTS_H

#include "contact.h"

/* Where the model is evaluated: with the given slips, with the acting slips and states, or with the given slips and the
   states. */
typedef enum { GIVEN, ACTING, DIRECT, N_POINTS } Point;

typedef struct {
    State *state;
    const double *seeds;
    Tangent tangent;
    int known[N_POINTS];
    double slots[N_POINTS][N_SLOTS]; /* the changes of the model's slots, where they are known */
} Changes;

/* Begin with the seeds of the host's values, in the model's signs, and with hub inputs those of the motion and of the
   model's parameters.  They must live as long as the changes. */
void changes_at_contact(Changes *changes, State *state, const double seeds[N_VALUES]);
/* The change of a slot of the model. */
double change_of_slot(Changes *changes, Point point, unsigned slot);

#endif
