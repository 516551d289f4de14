/* Tangents of the model's inputs for seeds by value reference, and the values of the model's operations. */
#ifndef TANGENTS_H
#define TANGENTS_H

#include "contact.h"
#include "terms.h"

/* Compute the values of all slots with the given or the acting slips, with or without the states of effects. */
void tangent_find_values(State *state, Point point, double values[N_SLOTS]);
void tangent_find_radius(const State *state, Radius *radius);
void tangent_find(State *state, const double seeds[N_VALUES], const Radius *radius, Tangent *tangent);

#endif
