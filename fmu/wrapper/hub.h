/* The wheel at its hub, for hub inputs: its motion at the contact point, its load, and the forces at its centre.
 *
 * The equations of motion and forces are the generated functions of wheel_kinematics.h.  The load is the sum of
 * - the spring: the load at which the model's loaded radius is the distance of the wheel centre from the contact point,
 *   for the acting slips.  A model without a loaded radius has the linear spring VERTICAL_STIFFNESS;
 * - the damper: VERTICAL_DAMPING times the rate of the loaded radius, while the spring is in contact;
 * - the rim, once the loaded radius is less than BOTTOM_RADIUS: BOTTOM_STIFF.
 * A load below 0 is 0.
 */
#ifndef HUB_H
#define HUB_H

#include "state.h"

#if HUB
/* By output of the model: its place among the contact forces of hub_wrench. */
static const unsigned HUB_FORCE[] = CONTACT_FORCES;

static inline double hub_parameter(const State *state, size_t i) { return state->values[FIRST_PARAMETER + i]; }

/* Compute the motion of the wheel and its load, which are values, and the model's parameters.  The contact is then to be
   computed for this load. */
void hub_find(State *state);
/* Compute the load of the spring at the wheel's loaded radius, part of the above. */
void hub_find_spring(State *state);
/* Compute the forces at the wheel centre from those at the contact point. */
void hub_add_forces(State *state);
/* The arguments of hub_wrench. */
void hub_arguments(const State *state, double arguments[]);

/* Replace the seeds of the model's parameters and of what hub_find computes by those that follow from the seeds of the
   host's values, and compute the changes of the hub's results at constant contact forces except for the load. */
void hub_differentiate(const State *state, double seeds[N_VALUES], double changes[N_HUB_RESULTS]);
/* The derivatives of a result by the model's forces at the contact point. */
void hub_by_forces(const State *state, unsigned result, double by[N_OUTPUTS]);
#endif

#endif
