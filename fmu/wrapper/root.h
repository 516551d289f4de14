/* The root of a function of one number. */
#ifndef ROOT_H
#define ROOT_H

/* A point of a function. */
typedef struct {
    double x, value;
} Sample;

typedef double Function(void *context, double x);

/* The root between two points, at which the function has opposite signs or is not finite: the method of Illinois.
   Ends at a value of `accuracy` or less, or where the points are neighbours.  The last call of the function is at the
   root. */
double root_between(Function *function, void *context, Sample a, Sample b, double accuracy);

#endif
