#define PI 3.14159265358979323846

static inline double square(double x) { return x*x; }

static inline double cube(double x) { return x*x*x; }

static inline double fourth(double x) { return (x*x)*(x*x); }

static inline double cubed_sqrt(double x) { return x*sqrt(x); }

#if HAS_WIDE
static EXPANDED wide wide_sgn(wide x)
{
    return WIDE_VALUE((WIDE_BITS(WIDE_EACH(1.0)) & WIDE_WHERE(x != 0.0)) | (WIDE_BITS(x) & WIDE_BITS(WIDE_EACH(-0.0)))
        | WIDE_WHERE(x != x));
}
#endif

#if HAS_WIDE
static EXPANDED wide wide_sgn1(wide x)
{
    return WIDE_VALUE(WIDE_BITS(WIDE_EACH(1.0)) | (WIDE_WHERE(x < 0.0) & WIDE_BITS(WIDE_EACH(-0.0))) | WIDE_WHERE(x != x));
}
#endif

/* A function of one number: with vectors, the first one of two. */
#if VECTORS
#define ALONE(function_of_one, function_of_two, x) (function_of_two((two){x})[0])
#else
#define ALONE(function_of_one, function_of_two, x) (function_of_one(x))
#endif

/* No branches, which are unpredictable here and which compilers make of comparisons; NaN stays NaN. */
static inline double sgn(double x) { return ALONE(one_sgn, two_sgn, x); }

static inline double sgn1(double x) { return ALONE(one_sgn1, two_sgn1, x); }
