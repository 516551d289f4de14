/* The spin of the wheel as a state: J d omega/dt = drive torque + moment of the tire - torque of the brake.
 *
 * A step is divided into equal parts of at most LONGEST_PART; in each, the slips follow the spin at its end (the implicit
 * Euler method).  The brake is Coulomb friction: it holds the wheel in a part if a torque up to T_brake does, and opposes
 * the spin with T_brake otherwise.  The load and the motion of the carrier are constant over a step.
 */
#ifndef SPIN_H
#define SPIN_H

#include "instance.h"

/* Integrate spin and all other states over h seconds. */
void spin_advance(State *state, double h);

#endif
