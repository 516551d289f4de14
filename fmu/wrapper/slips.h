/* The acting slips, which the force formulas use: the given slips, or slips with a first-order lag over distance.
 *
 * lagging_slips.c is part of an FMU whose tire has relaxation, where kappa and tan(alpha) lag.
 */
#ifndef SLIPS_H
#define SLIPS_H

#include "contact.h"

#include <string.h>

/* The origin of a relaxation length: a constant, the parameter DEFAULT_SIGMA, or the model. */
typedef enum { CONSTANT_LENGTH, DEFAULTED_LENGTH, MODEL_LENGTH } LengthOrigin;

#if LAGS
/* Compute the relaxation lengths for the contact, which all other functions need. */
void slips_find_lengths(State *state);

/* Compute the model's inputs with the acting slips, without the states of effects. */
void slips_acting(const State *state, double inputs[N_INPUTS]);

/* Whether this slip has a lag in the present state. */
int slips_lag(const State *state, size_t slip);

/* End of initialization: the lagged slips start in steady state. */
void slips_begin(State *state);

/* At an event: set the states to the acting slips.  Returns whether a state changed. */
int slips_settle(State *state);

/* Integrate over h > 0 seconds with constant inputs. */
void slips_advance(State *state, double h);

double slips_length(const State *state, size_t slip, LengthOrigin *origin);

#if TWISTS
/* The twist of the contact patch as a share of the twist at which the friction torque is reached, -1 to 1. */
double slips_twist(const State *state);
/* The twist follows the yaw rate and decays: d twist/dt = yawing - decay twist.  Returns the decay and its derivatives
   by |yaw rate| and by |V|. */
double slips_twist_decay(const State *state, double *by_yawing, double *by_speed);
#endif

/* Compute the rest of a tangent; call contact_differentiate before. */
void slips_differentiate(const State *state, const double seeds[N_VALUES], Tangent *tangent);

/* Compute the slips, or their rates, as the host reads them. */
void slips_show(const State *state, double slips[]);
void slips_show_rates(const State *state, double rates[]);
#else
static inline void slips_find_lengths(State *state) { (void) state; }
static inline void slips_acting(const State *state, double inputs[N_INPUTS])
{
    memcpy(inputs, state->contact.inputs, N_INPUTS * sizeof *inputs);
}
static inline int slips_lag(const State *state, size_t slip) { return (void) state, (void) slip, 0; }
static inline void slips_begin(State *state) { (void) state; }
static inline int slips_settle(State *state) { return (void) state, 0; }
static inline void slips_advance(State *state, double h) { (void) state, (void) h; }
static inline double slips_length(const State *state, size_t slip, LengthOrigin *origin)
{
    (void) state, (void) slip;
    *origin = CONSTANT_LENGTH;
    return 1.0;
}
static inline void slips_differentiate(const State *state, const double seeds[N_VALUES], Tangent *tangent)
{
    (void) state, (void) seeds;
    memcpy(tangent->acting, tangent->given, sizeof tangent->acting);
    memset(tangent->motion + LAGGING, 0, N_LAGGING * sizeof *tangent->motion);
}
static inline void slips_show(const State *state, double slips[]) { (void) state, (void) slips; }
static inline void slips_show_rates(const State *state, double rates[]) { (void) state, (void) rates; }
#endif

#endif
