/* The parts of a step of Co-Simulation: equal, and of at most LONGEST_PART, in which inputs that change have their mean, and
 * a spin follows its torques.
 */
#ifndef STEPS_H
#define STEPS_H

#include <float.h>
#include <math.h>

/* The oscillation of a wheel on its tire's spring takes some 30 ms, s. */
#define LONGEST_PART 1e-3
/* A longer step has longer parts, so that it ends. */
#define MAX_PARTS 10000

/* The size of the step that a host means.  The size that it passes is often the difference of two times, whose rounding
   grows with the time: a size within this rounding of a multiple or of a fraction of LONGEST_PART is that one.  The
   results of equal steps then do not depend on the time of the simulation. */
static inline double step_intended(double point, double size)
{
    double rounding, ratio, meant;

    if (size == LONGEST_PART)
        return size;
    rounding = 2.0 * DBL_EPSILON * (fabs(point) + size);
    ratio = size / LONGEST_PART;
    meant = ratio > 1.0 ? LONGEST_PART * floor(ratio + 0.5) : LONGEST_PART / floor(1.0 / ratio + 0.5);

    return meant > 0.0 && fabs(size - meant) <= rounding ? meant : size;
}

static inline int step_parts(double size)
{
    const double wanted = ceil(size / LONGEST_PART * (1.0 - 1e-9));
    return wanted < MAX_PARTS ? (int) wanted : MAX_PARTS;
}

#endif
