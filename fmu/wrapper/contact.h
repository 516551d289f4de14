/* The kinematics at the contact point, from the host's inputs.
 *
 * An FMU contains one of two files: slip_inputs.c, where the inputs are slips, or wheel_inputs.c, which computes slips
 * from velocities.
 */
#ifndef CONTACT_H
#define CONTACT_H

#include "state.h"

/* Compute `state->contact`; with hub inputs, at the load among the values:
 *   inputs   the model's inputs, with the given slips (without lag)
 *   target   steady-state value of the lagged slips; their rate is rolling / length (target - slip)
 *   sliding  target times rolling, m/s, finite at standstill
 *   bounds   largest magnitude of the lagged slips
 *   friction, stiffness   near standstill: mu Fz, N, and slip stiffness
 *   sense    the direction of travel: -1 backward.  The model's kappa is positive if it drives the wheel in this direction
 *   frame    sign of speed and turn slip in the model's equations, relative to those of the wheel
 *   speed    |V|, m/s
 *   rolling  the speed at which deflections decay: |V|, smooth at 0, m/s
 *   yawing   yaw rate of the wheel, rad/s */
void contact_find(State *state);

/* Compute the forces; `inputs` are the model's inputs with the acting slips.  For wheel inputs it is in standstill.c. */
void contact_forces(const State *state, const double inputs[N_INPUTS], double forces[N_OUTPUTS]);

/* Tangents of the model's inputs for a change of the host's values. */
typedef struct {
    double given[N_INPUTS];  /* of contact.inputs, with the given slips */
    double acting[N_INPUTS]; /* of the inputs with the acting slips and states, see slips.h */
    double direct[N_INPUTS]; /* of the inputs with the given slips and states, see effect_states.h */
    double motion[N_MOTION];
} Tangent;

/* Whether contact_differentiate is valid here: no correction of standstill is active. */
int contact_is_smooth(const State *state);
/* Compute `given`, and the speed and sliding of `motion`, for seeds in the model's signs by value reference. */
void contact_differentiate(const State *state, const double seeds[N_VALUES], Tangent *tangent);

#endif
