/* Slips as the host gives them.  See contact.h. */
#include "contact.h"

#include <math.h>

static const int PASSED[] = PASSED_ON;
static const double UNCONNECTED[] = UNCONNECTED_INPUTS;

void contact_find(State *state)
{
    Contact *contact = &state->contact;
    size_t i;

    if (state->contact_known)
        return;
    for (i = 0; i < N_INPUTS; i++)
        contact->inputs[i] = PASSED[i] < 0 ? UNCONNECTED[i] : host_value(state, FIRST_INPUT + (size_t) PASSED[i]);
#ifdef DISTANCE
    contact->inputs[DISTANCE] = state->distance;
#endif
#if N_STATES > 0
    contact->speed = fabs(host_value(state, FIRST_INPUT + HOST_SPEED));
#endif
#if LAGS
    contact->toward[LONGITUDINAL] = contact->inputs[KAPPA];
    contact->toward[LATERAL] = tan(contact->inputs[ALPHA]);
    for (i = 0; i < N_SLIPS; i++) {
        contact->sliding[i] = contact->toward[i] * contact->speed;
        contact->bounds[i] = HUGE_VAL;
    }
#endif
    contact->sense = 1.0;
    state->contact_known = 1;
}

void contact_settle(State *state, const double inputs[N_INPUTS], double forces[N_OUTPUTS])
{
    (void) state;
    (void) inputs;
    (void) forces;
}
