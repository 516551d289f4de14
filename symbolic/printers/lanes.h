/* LANES rows at a time: the elementary functions on vectors. Where a reduction does not cover the argument (angles beyond
   1e7, exp beyond 700, log of 0 and subnormals, infinities) they give NaN: the caller of the kernel computes that row
   again separately. */

typedef pair lanes;

typedef int64_t lane_bits __attribute__((vector_size(8*LANES)));

/* The same anywhere in an array of double. */
typedef double lanes_in_array __attribute__((vector_size(8*LANES), aligned(8), may_alias));

static inline lanes each(double x)
{
    return x - (lanes){0.0};
}

static inline lanes choose(lane_bits condition, lanes then, lanes otherwise)
{
    return (lanes)(((lane_bits)then & condition) | ((lane_bits)otherwise & ~condition));
}

static inline lanes lanes_absolute(lanes x)
{
    return (lanes)((lane_bits)x & INT64_MAX);
}

static inline lanes lanes_sqrt(lanes x)
{
    lanes root;
    for (int i = 0; i < LANES; i++)
        root[i] = sqrt(x[i]);
    return root;
}

static inline lanes lanes_square(lanes x) { return x*x; }

static inline lanes lanes_cube(lanes x) { return x*x*x; }

static inline lanes lanes_fourth(lanes x) { return (x*x)*(x*x); }

static inline lanes lanes_cubed_sqrt(lanes x) { return x*lanes_sqrt(x); }

static inline lanes lanes_sgn(lanes x) { return number_sgn(x); }

static inline lanes lanes_sgn1(lanes x) { return number_sgn1(x); }

/* NaN beyond 1e7, see LARGEST_ANGLE. */
static inline lanes lanes_checked_angle(lanes angle)
{
    return angle + 0.0*(angle*1.8e301);
}

static inline lanes lanes_sin(lanes x) { return number_sin(lanes_checked_angle(x)); }

static inline lanes lanes_cos(lanes x) { return number_cos(lanes_checked_angle(x)); }

static inline lanes lanes_tan(lanes x) { return number_tan(lanes_checked_angle(x)); }

static inline lanes lanes_atan(lanes x) { return number_atan(x); }

static inline lanes lanes_exp(lanes x)
{
    return choose(lanes_absolute(x) <= LARGEST_EXPONENT, number_exp(x), each(NAN));
}

static inline lanes lanes_log(lanes x)
{
    return choose((x >= DBL_MIN) & (x <= DBL_MAX), number_log(x), each(NAN));
}

static inline lanes lanes_pow(lanes x, lanes y)
{
    return lanes_exp(y*lanes_log(x));
}
