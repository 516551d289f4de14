/* Slips from the velocities of the contact point and the angular speed of the wheel.  See contact.h.
 *
 * Slip is the sliding velocity divided by the speed, which is 0/0 at standstill.  Below the parameter LOW_SPEED:
 * - A lagged slip is a deflection per length, d x/dt = (sliding - |V| x) / sigma, which needs no quotient: the tire at
 *   standstill is a spring.  The slip is limited to three times the slip of peak friction.
 * - A slip without lag uses a reference speed of at least half of LOW_SPEED.  There the force damps the sliding.
 * - Turn slip, yaw rate by reference speed, fades out: the twist of the contact patch replaces it.
 * A model that does not reverse with the speed is evaluated as a wheel that rolls forward, and its forces are mirrored.
 * standstill.c computes the forces.
 * After Pacejka, Tire and Vehicle Dynamics (2012), section 8.6; the limits and the reference speed are tirefmu's own.
 */
#include "contact.h"

#include "chain_rule.h"
#include "rolling_radius.h"
#include "standstill.h"

#include <math.h>
#include <string.h>

#define PI 3.14159265358979323846
#define STANDSTILL_SPEED 1e-12

static const int HOST_INDEX[] = HOST_INPUT_INDICES;
static const double UNCONNECTED[] = UNCONNECTED_INPUTS;

double standstill_speed(const State *state) { return state->values[FIRST_PARAMETER + LOW_SPEED]; }

double standstill_share(const State *state)
{
    const double share = state->contact.speed / standstill_speed(state);
    return share < 1.0 ? 0.5 * (1.0 + cos(PI * share)) : 0.0;
}

/* Near standstill: friction, slip stiffness, and the bounds of the lagged slips. */
static void find_bounds(State *state, double reference)
{
    static const int stiffness[] = {STIFFNESS_X, STIFFNESS_Y};
    static const int friction[] = {FRICTION_X, FRICTION_Y};
    Contact *contact = &state->contact;
    const double load = contact->inputs[LOAD] > 0.0 ? contact->inputs[LOAD] : 0.0;
    const double near = 1.0 - contact->speed / standstill_speed(state);
    double found[N_QUANTITIES];
    size_t i;

    for (i = 0; i < N_SLIPS; i++)
        contact->bounds[i] = HUGE_VAL;
    if (near <= 0.0)
        return;
    model_quantities(contact->inputs, model_parameters(state), found);
    for (i = 0; i < N_SLIPS; i++) {
        const double given = fabs(contact->sliding[i] / reference);
        double slope, bound;

        contact->friction[i] = fabs(found[friction[i]]) * load;
        contact->stiffness[i] = fabs(found[stiffness[i]]);
        slope = contact->stiffness[i] > 0.0 ? contact->stiffness[i] : HUGE_VAL; /* no load: 0, not 0/0 */
        bound = 3.0 * contact->friction[i] / (slope * near);
        contact->bounds[i] = bound > given ? bound : given;
    }
}

/* |V|, but with the derivative 0 at V = 0. */
static double rolling_speed(double speed)
{
    const double share = speed / LOWEST_SPEED;
    return share < 1.0 ? speed * share * (2.0 - share) : speed;
}

/* The host's values of the model's inputs; those of the motion follow. */
static void find_inputs(State *state)
{
    double *inputs = state->contact.inputs;
    size_t i;

    for (i = 0; i < N_INPUTS; i++)
        inputs[i] = HOST_INDEX[i] < 0 ? UNCONNECTED[i] : host_value(state, FIRST_INPUT + (size_t) HOST_INDEX[i]);
#ifdef DISTANCE
    inputs[DISTANCE] = state->continuous.distance;
#endif
}

/* Speed and direction of travel. */
static void find_travel(Contact *contact, double forward)
{
    contact->speed = fabs(forward);
    contact->rolling = rolling_speed(contact->speed);
    contact->sense = forward < 0.0 ? -1.0 : 1.0;
    contact->frame = REVERSES ? 1.0 : contact->sense;
#ifdef SPEED
    contact->inputs[SPEED] =
        contact->frame * contact->sense * (contact->speed < LOWEST_SPEED ? LOWEST_SPEED : contact->speed);
#endif
}

/* Sliding velocities, and the slips for a reference speed. */
static void find_slips(State *state, double forward, double reference)
{
    Contact *contact = &state->contact;
    const double turning = host_value(state, FIRST_INPUT + HOST_TURNING);
    size_t i;

    contact->sliding[LONGITUDINAL] = turning * rolling_radius(contact->inputs, turning, model_parameters(state)) - forward;
    contact->sliding[LATERAL] = host_value(state, FIRST_INPUT + HOST_SIDEWAYS);
    for (i = 0; i < N_SLIPS; i++)
        contact->target[i] =
            contact->sliding[i] / (contact->rolling > STANDSTILL_SPEED ? contact->rolling : STANDSTILL_SPEED);
    contact->inputs[KAPPA] = contact->sense * contact->sliding[LONGITUDINAL] / reference;
    contact->inputs[ALPHA] = atan(contact->sliding[LATERAL] / reference);
#if TWISTS
    contact->yawing = host_value(state, FIRST_INPUT + HOST_YAWING);
#endif
#ifdef TURN
    contact->inputs[TURN] = contact->frame * contact->yawing / reference * (1.0 - standstill_share(state));
#endif
}

void contact_find(State *state)
{
    const double forward = host_value(state, FIRST_INPUT + HOST_SPEED), low = standstill_speed(state);
    double reference = fabs(forward);

    if (reference < low)
        reference = 0.5 * (reference * reference / low + low);
    find_inputs(state);
    find_travel(&state->contact, forward);
    find_slips(state, forward, reference);
    find_bounds(state, reference);
}

int contact_is_smooth(const State *state)
{
    return !(state->values[FIRST_PARAMETER + FRICTION_LIMIT] > 0.0) &&
           state->contact.speed >= LIMIT_END * standstill_speed(state) && state->contact.speed >= LOWEST_SPEED;
}

/* The rolling radius at the given angular speed of the wheel, m, and its change for changes of the model's inputs. */
static double rolling_radius_change(const State *state, const double seeds[N_VALUES], const double given[N_INPUTS],
                                    double *radius)
{
    double values[N_SLOTS], tangents[N_SLOTS];

    chain_values(state->contact.inputs, model_parameters(state), host_value(state, FIRST_INPUT + HOST_TURNING), values);
    memcpy(tangents, given, N_INPUTS * sizeof *given);
    memcpy(tangents + FIRST_PARAMETER_LEAF, seeds + FIRST_PARAMETER, N_PARAMETERS * sizeof *seeds);
    tangents[TURNING_LEAF] = seeds[FIRST_INPUT + HOST_TURNING];
    chain_forward(values, tangents);
    *radius = values[ROLLING_RADIUS];
    return tangents[ROLLING_RADIUS];
}

void contact_differentiate(const State *state, const double seeds[N_VALUES], Tangent *tangent)
{
    const Contact *contact = &state->contact;
    const double *moved = seeds + FIRST_INPUT;
    const double speed = contact->speed, turning = host_value(state, FIRST_INPUT + HOST_TURNING);
    const double by_speed = host_value(state, FIRST_INPUT + HOST_SPEED) < 0.0 ? -1.0 : 1.0;
    double *given = tangent->given, *sliding = tangent->motion + SLIDING, slip[N_SLIPS];
    double radius, radius_moved;
    size_t i;

    for (i = 0; i < N_INPUTS; i++)
        given[i] = HOST_INDEX[i] < 0 ? 0.0 : moved[HOST_INDEX[i]];
#ifdef DISTANCE
    given[DISTANCE] = seeds[FIRST_DERIVATIVE - 1];
#endif
#ifdef SPEED
    given[SPEED] = contact->frame * moved[HOST_SPEED];
#endif
    radius_moved = rolling_radius_change(state, seeds, given, &radius);
    tangent->motion[ROLLING] = by_speed * moved[HOST_SPEED];
    sliding[LONGITUDINAL] = turning * radius_moved + radius * moved[HOST_TURNING] - moved[HOST_SPEED];
    sliding[LATERAL] = moved[HOST_SIDEWAYS];
    tangent->motion[YAWING] = 0.0;
    for (i = 0; i < N_SLIPS; i++)
        slip[i] = (sliding[i] - contact->target[i] * tangent->motion[ROLLING]) / speed;
    given[KAPPA] = contact->sense * slip[LONGITUDINAL];
    given[ALPHA] = slip[LATERAL] / (1.0 + contact->target[LATERAL] * contact->target[LATERAL]);
#if TWISTS
    tangent->motion[YAWING] = moved[HOST_YAWING];
#endif
#ifdef TURN
    given[TURN] = (contact->frame * moved[HOST_YAWING] - contact->inputs[TURN] * tangent->motion[ROLLING]) / speed;
#endif
}
