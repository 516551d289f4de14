/* The root of a function of one number: inverse quadratic interpolation where three points allow it, bisection otherwise
   (Chandrupatla, Advances in Engineering Software 28 (1997) 145).  See root.h. */
#include "root.h"

#include <math.h>

#define MAX_STEPS 200
/* Points whose distance is a few units in the last place are neighbours. */
#define NEIGHBOURS 4e-16

/* Where the root is between a (0) and b (1); c is the point before. */
static double share_of_way(Sample a, Sample b, Sample c)
{
    const double xi = (a.x - b.x) / (c.x - b.x), phi = (a.value - b.value) / (c.value - b.value);

    if (!(phi * phi < xi && (1.0 - phi) * (1.0 - phi) < 1.0 - xi))
        return 0.5;
    return a.value / (b.value - a.value) * (c.value / (b.value - c.value)) +
           (c.x - a.x) / (b.x - a.x) * (a.value / (c.value - a.value)) * (b.value / (c.value - b.value));
}

double root_between(Function *function, void *context, Sample a, Sample b, double accuracy)
{
    double share = a.value / (a.value - b.value);
    Sample c;
    int i;

    for (i = 0; i < MAX_STEPS; i++) {
        const double x = a.x + share * (b.x - a.x);
        Sample middle = {x, 0.0};

        if (!((x > a.x) ^ (x > b.x)) || x == a.x || x == b.x)
            middle.x = 0.5 * (a.x + b.x);
        middle.value = function(context, middle.x);
        if (fabs(middle.value) <= accuracy || fabs(b.x - a.x) <= NEIGHBOURS * fabs(middle.x))
            return middle.x;
        if ((middle.value > 0.0) == (a.value > 0.0)) {
            c = a;
        } else {
            c = b;
            b = a;
        }
        a = middle;
        share = share_of_way(a, b, c);
    }
    return a.x;
}
