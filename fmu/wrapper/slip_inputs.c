/* Slips as inputs.  See contact.h. */
#include "contact.h"

#include <math.h>
#include <string.h>

static const int HOST_INDEX[] = HOST_INPUT_INDICES;
static const double UNCONNECTED[] = UNCONNECTED_INPUTS;

#if LAGS
#define PI 3.14159265358979323846

/* The slip angle, beyond 90 deg its supplement: the tire formula reads it, too.  The lateral slip is V_y/|V_x|. */
static double folded(const double alpha)
{
    return fabs(alpha) > 0.5 * PI ? (alpha < 0.0 ? -PI : PI) - alpha : alpha;
}
#endif

void contact_find(State *state)
{
    Contact *contact = &state->contact;
    size_t i;

    for (i = 0; i < N_INPUTS; i++)
        contact->inputs[i] =
            HOST_INDEX[i] < 0 ? UNCONNECTED[i] : host_value(state, FIRST_INPUT + (size_t) HOST_INDEX[i]);
#ifdef DISTANCE
    contact->inputs[DISTANCE] = state->continuous.distance;
#endif
#if N_STATES > 0
    contact->speed = contact->rolling = fabs(host_value(state, FIRST_INPUT + HOST_SPEED));
#endif
#if LAGS
    contact->inputs[ALPHA] = folded(contact->inputs[ALPHA]);
    contact->target[LONGITUDINAL] = contact->inputs[KAPPA];
    contact->target[LATERAL] = tan(contact->inputs[ALPHA]);
    for (i = 0; i < N_SLIPS; i++) {
        contact->sliding[i] = contact->target[i] * contact->speed;
        contact->bounds[i] = HUGE_VAL;
    }
#endif
    contact->sense = 1.0;
}

int contact_is_smooth(const State *state)
{
    (void) state;
    return 1;
}

void contact_differentiate(const State *state, const double seeds[N_VALUES], Tangent *tangent)
{
    size_t i;

    (void) state;
    memset(tangent->motion, 0, sizeof tangent->motion);
    for (i = 0; i < N_INPUTS; i++)
        tangent->given[i] = HOST_INDEX[i] < 0 ? 0.0 : seeds[FIRST_INPUT + (size_t) HOST_INDEX[i]];
#ifdef DISTANCE
    tangent->given[DISTANCE] = seeds[FIRST_DERIVATIVE - 1];
#endif
#if N_STATES > 0
    tangent->motion[ROLLING] = seeds[FIRST_INPUT + HOST_SPEED];
    if (host_value(state, FIRST_INPUT + HOST_SPEED) < 0.0)
        tangent->motion[ROLLING] *= -1.0;
#endif
#if LAGS
    if (fabs(host_value(state, FIRST_INPUT + (size_t) HOST_INDEX[ALPHA])) > 0.5 * PI)
        tangent->given[ALPHA] *= -1.0;
    for (i = 0; i < N_SLIPS; i++) {
        const double t = state->contact.target[i];
        const double by_slip = i == LATERAL ? tangent->given[ALPHA] * (1.0 + t * t) : tangent->given[KAPPA];

        tangent->motion[SLIDING + i] = by_slip * state->contact.speed + t * tangent->motion[ROLLING];
    }
#endif
}

void contact_forces(const State *state, const double inputs[N_INPUTS], double forces[N_OUTPUTS])
{
    model_forces(inputs, model_parameters(state), forces);
}
