/* The acting slips, which the force formulas use: the given slips, or slips with a first-order lag over distance.
 *
 * An FMU contains one of two files: direct_slips.c for a tire without relaxation, lagging_slips.c for a tire with
 * relaxation, where kappa and tan(alpha) lag.
 */
#ifndef SLIPS_H
#define SLIPS_H

#include "contact.h"

/* Compute the model's inputs with the acting slips; call contact_find before. */
void slips_acting(State *state, double inputs[N_INPUTS]);

/* Whether this slip has a lag in the present state. */
int slips_lag(State *state, size_t slip);

/* End of initialization: the lagged slips start in steady state. */
void slips_begin(State *state);

/* At an event: set the states to the acting slips.  Returns whether a state changed. */
int slips_settle(State *state);

/* Integrate over h > 0 seconds with constant inputs. */
void slips_advance(State *state, double h);

/* The relaxation length of a slip; `of_model` is 1 if the model computes it, 0 if it is a constant. */
double slips_length(State *state, size_t slip, int *of_model);

/* Compute the rest of a tangent; call contact_differentiate before. */
void slips_differentiate(State *state, const double seeds[N_VALUES], Tangent *tangent);

/* Compute the slips and their rates as the host reads them. */
void slips_show(State *state, double slips[], double rates[]);

#endif
