/* The forces of a wheel near standstill.  See standstill.h and contact.h.
 *
 * - Up to LOWEST_SPEED the forces of both directions of travel are interpolated.
 * - What the formula gives at zero slip (shifts, ply-steer, conicity, camber thrust) needs a rolling tire: it fades out
 *   towards rest.  The overturning moment of an inclined wheel remains.
 * - A twisted contact patch has a moment, up to the friction torque, in place of turn slip.  If the model has no such
 *   torque, it is that of a patch with parabolic pressure whose length follows from the trail.
 * - A damper acts in parallel with the spring of a standing tire.
 * - The vector of Fx and Fy is limited to the friction ellipse, the damper to what the spring leaves of it.  No force
 *   then does more work than the sliding and the spring deliver.  With FRICTION_LIMIT = 1 the limit acts at every speed.
 */
#include "standstill.h"

#include "contact.h"
#include "slips.h"

#include <math.h>
#include <string.h>

/* Converts load to mass, for damping relative to critical damping, m/s^2. */
#define GRAVITY 9.81
/* Critical damping of a turning wheel relative to that of its load: the wheel has about 1 % of the mass. */
#define WHEEL_DAMPING 0.1

static const unsigned PLANAR_FORCE[] = {LONGITUDINAL_FORCE, SIDE_FORCE};

static double load(const State *state)
{
    return state->contact.inputs[LOAD] > 0.0 ? state->contact.inputs[LOAD] : 0.0;
}

/* The forces in a direction of travel. */
static void find_one_way(const State *state, double sense, const double inputs[N_INPUTS], double forces[N_OUTPUTS])
{
    size_t i;

    model_forces(inputs, model_parameters(state), forces);
    for (i = 0; i < N_OUTPUTS; i++)
        forces[i] *= output_sign(sense, i);
}

/* The forces; those of both directions at very low speed, because some terms change sign with the direction. */
static void find_forces(const State *state, const double inputs[N_INPUTS], double forces[N_OUTPUTS])
{
    const double sense = state->contact.sense;
    const double step = state->contact.speed < LOWEST_SPEED ? state->contact.speed / LOWEST_SPEED : 1.0;
    const double share = 0.5 * (1.0 + step * (1.5 - 0.5 * step * step));
    double turned[N_INPUTS], other[N_OUTPUTS];
    size_t i;

    find_one_way(state, sense, inputs, forces);
    if (share >= 1.0)
        return;
    memcpy(turned, inputs, sizeof turned);
    turned[KAPPA] = -inputs[KAPPA];
#ifdef SPEED
    turned[SPEED] = REVERSES ? -inputs[SPEED] : inputs[SPEED];
#endif
    find_one_way(state, -sense, turned, other);
    for (i = 0; i < N_OUTPUTS; i++)
        forces[i] = share * forces[i] + (1.0 - share) * other[i];
}

static void find_without_slip(const State *state, const double inputs[N_INPUTS], double forces[N_OUTPUTS])
{
    double straight[N_INPUTS];

    memcpy(straight, inputs, sizeof straight);
    straight[KAPPA] = straight[ALPHA] = 0.0;
    find_forces(state, straight, forces);
}

static void fade_shifts(const State *state, const double inputs[N_INPUTS], double forces[N_OUTPUTS])
{
    const double share = standstill_share(state);
    double without[N_OUTPUTS];

    find_without_slip(state, inputs, without);
    forces[LONGITUDINAL_FORCE] -= share * without[LONGITUDINAL_FORCE];
    forces[SIDE_FORCE] -= share * without[SIDE_FORCE];
#ifdef ALIGNING_MOMENT
    forces[ALIGNING_MOMENT] -= share * without[ALIGNING_MOMENT];
#endif
#if defined OVERTURNING_MOMENT && defined INCLINATION
    {
        double upright[N_INPUTS];

        memcpy(upright, inputs, sizeof upright);
        upright[INCLINATION] = 0.0;
        find_without_slip(state, upright, without);
        forces[OVERTURNING_MOMENT] -= share * without[OVERTURNING_MOMENT];
    }
#endif
}

/* The part of the load's critical damping that a slip has.  A wheel that does not turn moves the load; a turning wheel
   moves itself only, and the damping of the load would make the equation of its rotation stiff. */
static double damped_part(const State *state, size_t slip)
{
    const double forward = host_value(state, FIRST_INPUT + HOST_SPEED);
    const double turning = fabs(state->contact.sliding[LONGITUDINAL] + forward);
    const double sum = state->contact.speed + turning, locked = state->contact.speed - turning;

    if (slip == LATERAL)
        return 1.0;
    return locked > 0.0 ? WHEEL_DAMPING + (1.0 - WHEEL_DAMPING) * locked / sum : WHEEL_DAMPING;
}

/* The force of a damper relative to the critical damping of the load on the tire's spring. */
static double damper(const State *state, size_t slip)
{
    const Contact *contact = &state->contact;
    const double ratio = state->values[FIRST_PARAMETER + LOW_SPEED_DAMPING] * standstill_share(state);
    const double sense = slip == LATERAL ? SIDE_FORCE_SENSE : 1.0;

    if (!slips_lag(state, slip))
        return 0.0;
    return sense * ratio * damped_part(state, slip) * 2.0 *
           sqrt(contact->stiffness[slip] / state->lengths[slip] * load(state) / GRAVITY) * contact->sliding[slip];
}

/* The largest share, 0 to 1, of b for which the size of a + share b is 1 at most; the size of a is. */
static double largest_share(const double a[N_SLIPS], const double b[N_SLIPS])
{
    const double ab = a[0] * b[0] + a[1] * b[1], bb = b[0] * b[0] + b[1] * b[1];
    const double slack = 1.0 - a[0] * a[0] - a[1] * a[1], rest = slack > 0.0 ? slack : 0.0;
    const double root = sqrt(ab * ab + bb * rest);

    if (bb + 2.0 * ab <= rest)
        return 1.0;
    return ab > 0.0 ? rest / (ab + root) : (root - ab) / bb;
}

static void limit_to_friction(const State *state, const double quantities[N_QUANTITIES], double forces[N_OUTPUTS])
{
    static const unsigned friction[] = {FRICTION_X, FRICTION_Y};
    const double free = 1.0 - state->values[FIRST_PARAMETER + FRICTION_LIMIT];
    const double beyond = (state->contact.speed / standstill_speed(state) - LIMIT_BEGIN) / (LIMIT_END - LIMIT_BEGIN);
    double limits[N_SLIPS], used[N_SLIPS], damped[N_SLIPS], use, share;
    size_t i;

    for (i = 0; i < N_SLIPS; i++) {
        limits[i] = fabs(quantities[friction[i]]) * load(state);
        used[i] = limits[i] > 0.0 ? forces[PLANAR_FORCE[i]] / limits[i] : 0.0;
        damped[i] = limits[i] > 0.0 ? damper(state, i) / limits[i] : 0.0;
    }
    use = sqrt(used[0] * used[0] + used[1] * used[1]);
    if (use > 1.0) {
        share = free * (beyond > 1.0 ? 1.0 : beyond > 0.0 ? beyond : 0.0);
        use = use / (1.0 + (use - 1.0) * share);
        for (i = 0; i < N_SLIPS; i++)
            used[i] /= use;
    }
    share = largest_share(used, damped);
    for (i = 0; i < N_SLIPS; i++)
        if (limits[i] > 0.0)
            forces[PLANAR_FORCE[i]] = limits[i] * (used[i] + share * damped[i]);
}

#if TWISTS
/* By the integrals over a patch of length 2 a: the torque is 3/8 mu Fz a, and the trail of bristles on it is a/3. */
static double turning_torque(const State *state, const double quantities[N_QUANTITIES])
{
#ifdef TURN
    (void) state;
    return quantities[TURNING_TORQUE];
#else
    return 9.0 / 8.0 * fabs(quantities[FRICTION_Y] * quantities[TRAIL]) * load(state);
#endif
}
#endif

void contact_forces(const State *state, const double inputs[N_INPUTS], double forces[N_OUTPUTS])
{
    double quantities[N_QUANTITIES];

    find_forces(state, inputs, forces);
    if (contact_is_smooth(state))
        return;
    if (state->contact.speed < standstill_speed(state))
        fade_shifts(state, inputs, forces);
    model_quantities(inputs, model_parameters(state), quantities);
    limit_to_friction(state, quantities, forces);
#if TWISTS
    forces[ALIGNING_MOMENT] +=
        SIDE_FORCE_SENSE * standstill_share(state) * turning_torque(state, quantities) * slips_twist(state);
#endif
}
