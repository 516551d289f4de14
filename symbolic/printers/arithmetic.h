#define PI 3.14159265358979323846

static inline double square(double x) { return x*x; }

static inline double cube(double x) { return x*x*x; }

static inline double fourth(double x) { return (x*x)*(x*x); }

static inline double cubed_sqrt(double x) { return x*sqrt(x); }

/* No branches, which are unpredictable here; NaN stays NaN (the second operand of a comparison that fails). */
static inline double sgn(double x)
{
    const double y = x*1e300*1e300, above = -1.0 > y ? -1.0 : y;
    return 1.0 < above ? 1.0 : above;
}

static inline double sgn1(double x)
{
    const double sign = sgn(x);
    return sign + (double)(sign == 0.0);
}
