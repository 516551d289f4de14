/* The spin of the wheel as a state: J d omega/dt = drive torque + moment of the tire + torque of the brake.
 *
 * Co-Simulation: a step is divided into equal parts of at most LONGEST_PART; in each, the slips follow the spin at its end
 * (the implicit Euler method).  The brake is Coulomb friction: it holds the wheel in a part if a torque up to T_brake
 * does, and opposes the spin with T_brake otherwise.  The load and the motion of the carrier are constant over a step.
 * `brake_sense` is that at the end of the last part.
 *
 * Model Exchange: `brake_sense` is the direction of the spin that the brake opposes, or 0 while it holds the wheel, whose
 * spin is then constant.  It changes at events only: where the spin changes its sign, and where the torque that holds the
 * wheel exceeds T_brake.
 */
#ifndef SPIN_H
#define SPIN_H

#include "state.h"

#if SPIN
/* The moment about the spin axis, the fifth result of hub_wrench. */
enum { SPIN_MOMENT = WRENCH_RESULT + 4 };

static inline double spin_of(const State *state) { return state->values[SPIN_VALUE]; }

/* The largest torque of the brake. */
static inline double spin_brake(const State *state) { return state->values[FIRST_INPUT + HOST_BRAKE]; }

/* The torque on the wheel without that of the brake. */
double spin_free_torque(const State *state);
/* The direction of the spin that the brake opposes, 0 while it holds the wheel; that of a wheel with the spin 0. */
int spin_sense(const State *state);
int spin_sense_at_rest(const State *state);

/* The end of initialization in Co-Simulation: spin_steps.c. */
void spin_begin(State *state);
/* Integrate spin and all other states over h seconds, or up to the end of the part in which the brake locks, releases or
   changes its direction.  Returns the integrated time. */
double spin_advance(State *state, double h, int stops_at_event);

/* An event: determine the sense of the brake.  Returns whether the spin has changed: a wheel that the brake stops has
   the spin 0. */
int spin_settle(State *state);
/* Compute the rate of the spin and, in Model Exchange, the torque of the brake.  Call it after the other outputs. */
void spin_show(State *state);
/* The spin, or the torque that the holding brake could still apply: an event is where it changes its sign. */
double spin_indicator(const State *state);
int spin_is_held(const State *state);

/* The derivatives of the rate and of the indicator by the moment of the tire, and the changes that seeds cause at a
   constant moment. */
double spin_gain(const State *state);
double spin_margin_by_moment(const State *state);
void spin_differentiate(const State *state, const double seeds[N_VALUES], double motion[N_MOTION]);
#endif

#endif
