#define PI 3.14159265358979323846

static inline double square(double x) { return x*x; }

static inline double cube(double x) { return x*x*x; }

static inline double fourth(double x) { return (x*x)*(x*x); }

static inline double cubed_sqrt(double x) { return x*sqrt(x); }

static EXPANDED number number_sgn(number x)
{
    return NUMBER_VALUE((NUMBER_BITS(NUMBER_EACH(1.0)) & NUMBER_WHERE(x != 0.0))
        | (NUMBER_BITS(x) & NUMBER_BITS(NUMBER_EACH(-0.0))) | NUMBER_WHERE(x != x));
}

static EXPANDED number number_sgn1(number x)
{
    return NUMBER_VALUE(NUMBER_BITS(NUMBER_EACH(1.0)) | (NUMBER_WHERE(x < 0.0) & NUMBER_BITS(NUMBER_EACH(-0.0)))
        | NUMBER_WHERE(x != x));
}

/* No branches, which are unpredictable here and which compilers make of comparisons; NaN stays NaN. */
static inline double sgn(double x) { return NUMBER_ALONE(number_sgn, x); }

static inline double sgn1(double x) { return NUMBER_ALONE(number_sgn1, x); }
