/* Where the forces of a wheel near standstill are corrected: the functions are in wheel_inputs.c, the forces in
   standstill.c. */
#ifndef STANDSTILL_H
#define STANDSTILL_H

#include "state.h"

/* Lowest speed that the model receives: at 0 the direction is undefined, m/s. */
#define LOWEST_SPEED 0.01
/* The friction limit acts up to the first multiple of LOW_SPEED and fades out up to the second one. */
#define LIMIT_BEGIN 2.0
#define LIMIT_END 3.0

/* The parameter LOW_SPEED, m/s. */
double standstill_speed(const State *state);
/* 1 at rest, 0 from LOW_SPEED on, smooth. */
double standstill_share(const State *state);

#endif
