/* The slips that act: as they are given, or lagging behind by a rolled distance.
 *
 * An FMU is built with one of two files: direct_slips.c for a tire whose slips act at once, lagging_slips.c for
 * one with relaxation, where kappa and tan(alpha) lag.
 */
#ifndef SLIPS_H
#define SLIPS_H

#include "contact.h"

/* Fill in the inputs that the model sees; after contact_find. */
void slips_acting(State *state, double inputs[N_INPUTS]);

/* Does this slip lag behind here and now? */
int slips_lag(State *state, size_t slip);

/* The end of initialization: slips lag from here on, and begin in steady state. */
void slips_begin(State *state);

/* At an event: slips that act at once are where they act.  Returns whether one has moved. */
int slips_settle(State *state);

/* Roll on for h > 0 seconds with the inputs held. */
void slips_advance(State *state, double h);

/* Over which length a slip follows where it is no longer what is given; of the model's, or a constant. */
double slips_length(State *state, size_t slip, int *of_model);

/* Fill in the rest of a tangent, after contact_differentiate. */
void slips_differentiate(State *state, const double seeds[N_VALUES], Tangent *tangent);

/* Fill in slips and their rates as the host sees them. */
void slips_show(State *state, double slips[], double rates[]);

#endif
