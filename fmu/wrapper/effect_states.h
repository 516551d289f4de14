/* The states of effects: lags, sums and hystereses that the force formulas read as inputs.
 *
 * effect_states.c is part of an FMU whose tire has such states.  The generated routine `state_lines` computes target, rate and
 * start of each state; state_laws.h has the laws.  A state is direct if it follows inputs alone.
 */
#ifndef EFFECT_STATES_H
#define EFFECT_STATES_H

#include "contact.h"

#if N_MEMORY == 0
static inline void memory_fill(const State *state, double inputs[N_INPUTS]) { (void) state, (void) inputs; }
static inline void memory_rates(const State *state, double rates[], double events[])
{
    (void) state, (void) rates, (void) events;
}
#else
/* Put the states into the model's inputs: their own values, or before the end of initialization their start values. */
void memory_fill(const State *state, double inputs[N_INPUTS]);

/* The states as the host reads them, with the given slips. */
void memory_show(const State *state, double memory[N_MEMORY]);

/* End of initialization: the states have their start values. */
void memory_begin(State *state);

/* Integrate the states, lagged slips included, over h > 0 seconds with constant inputs. */
void memory_advance(State *state, double h);

/* Compute the derivatives of the states, and what changes sign where the derivative of a state along a path jumps: the
   velocity of a hysteresis, the margin of a play (1 - x in its direction, -1 while it is at its limit); 0 for other
   states. */
void memory_rates(const State *state, double rates[N_MEMORY], double events[N_MEMORY]);

/* Put the seeds of the states into the tangents of the inputs; call slips_differentiate before. */
void memory_differentiate(const State *state, const double seeds[N_VALUES], Tangent *tangent);

/* Whether the derivative of a state depends on the given slips, not on the lagged ones. */
int memory_is_direct(size_t i);
/* Whether a state is a hysteresis or a play. */
int memory_is_path(size_t i);
/* Indices of named quantities: the derivative of a state, the event indicator of a state along a path. */
unsigned memory_derivative(size_t i);
unsigned memory_event(size_t i);
#endif

#endif
