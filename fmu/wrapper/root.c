/* The root of a function of one number.  See root.h. */
#include "root.h"

#include <math.h>

#define MAX_STEPS 200
/* Points whose distance is a few units in the last place are neighbours. */
#define NEIGHBOURS 4e-16

double root_between(Function *function, void *context, Sample a, Sample b, double accuracy)
{
    const int rising = a.value < 0.0;
    Sample middle = b;
    int i, side = 0;

    for (i = 0; i < MAX_STEPS; i++) {
        middle.x = a.x + (b.x - a.x) * (a.value / (a.value - b.value));
        if (!((middle.x > a.x) ^ (middle.x > b.x)) || middle.x == a.x || middle.x == b.x)
            middle.x = 0.5 * (a.x + b.x);
        middle.value = function(context, middle.x);
        if (fabs(middle.value) <= accuracy || fabs(b.x - a.x) <= NEIGHBOURS * fabs(middle.x))
            return middle.x;
        if (rising ? middle.value < 0.0 : middle.value > 0.0) {
            a = middle;
            b.value *= side > 0 ? 0.5 : 1.0;
            side = 1;
        } else {
            b = middle;
            a.value *= side < 0 ? 0.5 : 1.0;
            side = -1;
        }
    }
    return middle.x;
}
