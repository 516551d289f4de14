/* What the host's inputs mean at the contact point.
 *
 * An FMU is built with one of two files: slip_inputs.c takes slips as they are given, wheel_inputs.c finds them from
 * velocities.
 */
#ifndef CONTACT_H
#define CONTACT_H

#include "instance.h"

/* Fill in `state->contact`:
 *   inputs   what the model sees, slips as given
 *   toward   what lagging slips move to; their rate is speed / length (toward - slip)
 *   sliding  toward times speed, m/s, which stays finite at standstill
 *   bounds   what lagging slips do not go beyond
 *   friction, stiffness   near standstill: mu Fz, N, and slip stiffness
 *   sense    by which the model counts kappa: -1 for some models in reverse
 *   speed    |V|, m/s */
void contact_find(State *state);

/* What standstill does to the forces, `inputs` being those that act. */
void contact_settle(State *state, const double inputs[N_INPUTS], double forces[N_OUTPUTS]);

/* How what the model sees moves with what the host sets. */
typedef struct {
    double given[N_INPUTS];  /* of contact.inputs */
    double acting[N_INPUTS]; /* the same with the slips that act */
    double moved[N_MOVED];
} Tangent;

/* The rolling radius of a wheel whose speed of turning is given, m, and its derivatives by the leaves of chain_rule.h. */
typedef struct {
    double length, by[N_LEAVES];
} Radius;

/* Do small changes of the host's values act through the formulas as contact_differentiate has them? */
int contact_is_smooth(const State *state);
/* Fill in `given`, and of `moved` speed and sliding, for seeds in the model's signs by value reference.  Where slips are
   inputs, no radius is needed. */
void contact_differentiate(const State *state, const double seeds[N_VALUES], const Radius *radius, Tangent *tangent);

/* An input or a wheel parameter in the model's signs. */
double host_value(const State *state, size_t reference);
double value_direction(unsigned reference);

#endif
