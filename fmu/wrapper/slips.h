/* The slips that act: as they are given, or lagging behind by a rolled distance.
 *
 * An FMU is built with one of two files: direct_slips.c for a tire whose slips act at once, lagging_slips.c for
 * one with relaxation, where kappa and tan(alpha) lag.
 */
#ifndef SLIPS_H
#define SLIPS_H

#include "instance.h"

/* Fill in the inputs that the model sees, and the local variables, which say the same to the host. */
void slips_acting(State *state, double inputs[N_INPUTS]);

/* Does this input act as it is given?  After slips_acting for the same inputs and parameters. */
int slips_follow(const State *state, size_t input);

/* The end of initialization: slips lag from here on, and begin in steady state. */
void slips_begin(State *state);

/* Roll on for h > 0 seconds with the inputs held. */
void slips_advance(State *state, double h);

#endif
