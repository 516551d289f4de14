/* Elementary functions without branches and calls, so that a processor overlaps what does not depend on each other, in
   all lanes of a vector register. Reduction of the argument is the classical one (Cody and Waite, Software Manual for
   the Elementary Functions, 1980); the polynomials are tirefmu's own: that of the sine interpolates in 60 digits at the
   Chebyshev nodes of the reduced range, as with it the sine of pi/2 is exactly 1, and factors of low speed are exactly 0
   at standstill; so do those of exp and log; those of tangent and arcus tangent have the least maximum of the relative
   error (Remez's exchange in 50 digits); rounded to double. The error, measured against 36 digits, is below 3 units in
   the last place; that of a power about |y log x| more.
   Arguments that the reduction does not cover (huge angles, infinities, NaN) go to math.h. */

/* Extended precision or liberties with rounding would spoil the reduction. */
#if (defined(FLT_EVAL_METHOD) && FLT_EVAL_METHOD != 0) || defined(__FAST_MATH__)
#define REDUCTION_IS_EXACT 0
#else
#define REDUCTION_IS_EXACT 1
#endif

/* Added and subtracted again, it rounds to a whole number, which is in the lowest bits in between. */
#define ROUNDING 6755399441055744.0

/* Up to here a multiple of pi/2 is taken off exactly. */
#define LARGEST_ANGLE 1e7

/* Up to here exp is neither 0 nor infinite nor subnormal. */
#define LARGEST_EXPONENT 700.0

#if HAS_WIDE
static EXPANDED wide wide_choose(wide_bits where, wide then, wide otherwise)
{
    return WIDE_VALUE((WIDE_BITS(then) & where) | (WIDE_BITS(otherwise) & ~where));
}
#endif

/* (-1)^n sin(angle - (n - shift) pi), n being the whole number that brings it next to 0: the sine of the angle where
   shift is 0, the cosine where it is 1/2. */
#if HAS_WIDE
static EXPANDED wide wide_shifted_sin(wide angle, wide shift)
{
    const wide rounded = (angle*0.3183098861837907 + shift) + ROUNDING;
    const wide n = (rounded - ROUNDING) - shift;
    const wide r = ((angle - n*3.141592651605606) - n*1.9841871583270443e-09) - n*1.034036596358821e-18;
    const wide z = r*r, z2 = z*z, z4 = z2*z2;
    const wide series = ((-0.16666666666666666 + z*0.008333333333333316)
        + z2*(-0.00019841269841254955 + z*2.755731921915843e-06))
        + z4*((-2.5052107616384595e-08 + z*1.6058977272815506e-10)
        + z2*(-7.643969031052769e-13 + z*2.731428986122616e-15));
    return WIDE_VALUE(WIDE_BITS(r + r*z*series) ^ (WIDE_BITS(rounded) << 63));
}
#endif

#if HAS_WIDE
static EXPANDED wide wide_sin(wide x) { return wide_shifted_sin(x, WIDE_EACH(0.0)); }
#endif

#if HAS_WIDE
static EXPANDED wide wide_cos(wide x) { return wide_shifted_sin(x, WIDE_EACH(0.5)); }
#endif

/* Sine over cosine of what remains next to 0 of multiples of pi/2, or the reciprocal with the other sign. */
#if HAS_WIDE
static EXPANDED wide wide_tan(wide x)
{
    const wide rounded = x*0.6366197723675814 + ROUNDING, n = 0.5*(rounded - ROUNDING);
    const wide r = ((x - n*3.141592651605606) - n*1.9841871583270443e-09) - n*1.034036596358821e-18;
    const wide z = r*r;
    const wide sine = r + r*z*(-0.1666666666666663 + z*(0.008333333333322118 + z*(-0.0001984126982958893
        + z*(2.755731362117812e-06 + z*(-2.5050747731531878e-08 + z*1.5896228416925448e-10)))));
    const wide cosine = 1.0 + z*(-0.5 + z*(0.04166666666659654 + z*(-0.0013888888877611868
        + z*(2.480158070734838e-05 + z*(-2.7555523114049664e-07 + z*2.0645119096199667e-09)))));
    const wide_bits odd = 0 - (WIDE_BITS(rounded) & 1);
    return wide_choose(odd, -cosine, sine)/wide_choose(odd, sine, cosine);
}
#endif

/* atan(x), pi/4 + atan((x - 1)/(x + 1)) beyond tan(pi/8), pi/2 - atan(1/x) beyond tan(3 pi/8). */
#if HAS_WIDE
static EXPANDED wide wide_atan(wide x)
{
    const wide a = WIDE_VALUE(WIDE_BITS(x) & ~WIDE_BITS(WIDE_EACH(-0.0))), unit = WIDE_EACH(1.0);
    const wide_bits beyond = WIDE_WHERE(a > 0.41421356237309503), within = WIDE_WHERE(a <= 2.414213562373095);
    const wide shifted = WIDE_VALUE(WIDE_BITS(unit) & beyond), near = WIDE_VALUE(WIDE_BITS(unit) & within);
    const wide eighths = (shifted + 1.0) - near;
    const wide t = (WIDE_VALUE(WIDE_BITS(a) & within) - shifted)/(WIDE_VALUE(WIDE_BITS(a) & beyond) + near);
    const wide z = t*t, z2 = z*z, z4 = z2*z2;
    const wide series = ((-0.3333333333333015 + z*0.19999999999088983)
        + z2*(-0.14285714195263263 + z*0.11111106653657138))
        + z4*(((-0.09090782413881009 + z*0.07690068317754889)
        + z2*(-0.06641121318562959 + z*0.05692539545490282))
        + z4*(-0.04359096564275717 + z*0.02125985728632481));
    const wide size = eighths*0.7853981633974483 + (t + t*z*series);
    return WIDE_VALUE(WIDE_BITS(size) | (WIDE_BITS(x) & WIDE_BITS(WIDE_EACH(-0.0))));
}
#endif

#if HAS_WIDE
static EXPANDED wide wide_exp(wide x)
{
    const wide rounded = x*1.4426950408889634 + ROUNDING, n = rounded - ROUNDING;
    const wide r = (x - n*0.6931471803691238) - n*1.9082149292705877e-10;
    const wide r2 = r*r, r4 = r2*r2;
    const wide tail = ((0.5000000000000001 + r*0.16666666666666669)
        + r2*(0.041666666666623824 + r*0.008333333333330039))
        + r4*((0.0013888888917367081 + r*0.00019841269863171557)
        + r2*(2.4801521057868204e-05 + r*2.7557268276905696e-06)
        + r4*(2.7620201591031547e-07 + r*2.5100472505694996e-08));
    return WIDE_VALUE((WIDE_BITS(rounded) + 1023) << 52)*(1.0 + (r + r2*tail));
}
#endif

/* Of normal positive numbers. */
#if HAS_WIDE
static EXPANDED wide wide_log(wide x)
{
    const wide mantissa = WIDE_VALUE((WIDE_BITS(x) & 0x000fffffffffffff) | 0x3ff0000000000000);
    /* A whole number in the lowest bits of 2^52. */
    const wide exponent = WIDE_VALUE((WIDE_BITS(x) >> 52) | 0x4330000000000000) - 4503599627371519.0;
    const wide_bits upper = WIDE_WHERE(mantissa > 1.4142135623730951);
    const wide m = wide_choose(upper, 0.5*mantissa, mantissa);
    const wide n = wide_choose(upper, exponent + 1.0, exponent);
    const wide s = (m - 1.0)/(m + 1.0);
    const wide z = s*s, z2 = z*z, z4 = z2*z2;
    const wide series = z*((0.666666666666667 + z*0.3999999999989889)
        + z2*(0.28571428626253836 + z*0.22222211089379496)
        + z4*((0.1818289243253687 + z*0.15331611722055008) + z2*0.14617807153417325));
    return n*0.6931471803691238 + (2.0*s + (s*series + n*1.9082149292705877e-10));
}
#endif

#if HAS_WIDE
static EXPANDED wide wide_exponent(wide x, wide y) { return y*wide_log(x); }
#endif

#if VECTORS && !HAS_FOUR
static EXPANDED four four_shifted_sin(four x, four y) { return FOUR_BY_PAIRS(two_shifted_sin, x, y); }
#endif

#if VECTORS && !HAS_FOUR
static EXPANDED four four_tan(four x) { return FOUR_BY(two_tan, x); }
#endif

#if VECTORS && !HAS_FOUR
static EXPANDED four four_atan(four x) { return FOUR_BY(two_atan, x); }
#endif

#if VECTORS && !HAS_FOUR
static EXPANDED four four_exp(four x) { return FOUR_BY(two_exp, x); }
#endif

#if VECTORS && !HAS_FOUR
static EXPANDED four four_exponent(four x, four y) { return FOUR_BY_PAIRS(two_exponent, x, y); }
#endif

static inline double fast_sin(double x)
{
    return REDUCTION_IS_EXACT && fabs(x) <= LARGEST_ANGLE ? ALONE(one_sin, two_sin, x) : sin(x);
}

static inline double fast_cos(double x)
{
    return REDUCTION_IS_EXACT && fabs(x) <= LARGEST_ANGLE ? ALONE(one_cos, two_cos, x) : cos(x);
}

static inline double fast_tan(double x)
{
    return REDUCTION_IS_EXACT && fabs(x) <= LARGEST_ANGLE ? ALONE(one_tan, two_tan, x) : tan(x);
}

static inline double fast_atan(double x)
{
    return REDUCTION_IS_EXACT ? ALONE(one_atan, two_atan, x) : atan(x);
}

static inline double fast_exp(double x)
{
    return REDUCTION_IS_EXACT && fabs(x) <= LARGEST_EXPONENT ? ALONE(one_exp, two_exp, x) : exp(x);
}

static inline double fast_pow(double x, double y)
{
    if (REDUCTION_IS_EXACT && x >= DBL_MIN && x <= DBL_MAX) {
        const double exponent = y*ALONE(one_log, two_log, x);
        if (fabs(exponent) <= LARGEST_EXPONENT)
            return ALONE(one_exp, two_exp, exponent);
    }
    return pow(x, y);
}

static CALLED double called_sin(double x) { return fast_sin(x); }

static CALLED double called_cos(double x) { return fast_cos(x); }

static CALLED double called_tan(double x) { return fast_tan(x); }

static CALLED double called_atan(double x) { return fast_atan(x); }

static CALLED double called_exp(double x) { return fast_exp(x); }

static CALLED double called_pow(double x, double y) { return fast_pow(x, y); }

/* Two or four values of a function that do not depend on each other, the same as one after the other. */

static CALLED many many_shifted_sin_in_turn(many angle, many shift)
{
    for (int i = 0; i < MANY_COUNT; i++) {
        const double x = MANY_AT(angle, i);
        MANY_AT(angle, i) = MANY_AT(shift, i) == 0.0 ? called_sin(x) : called_cos(x);
    }
    return angle;
}

static EXPANDED many fast_many_shifted_sin(many angle, many shift)
{
#if VECTORS
    if (REDUCTION_IS_EXACT && MANY_SIZE(angle) <= LARGEST_ANGLE)
        return many_shifted_sin(angle, shift);
#endif
    return many_shifted_sin_in_turn(angle, shift);
}

static CALLED many many_tan_in_turn(many x)
{
    for (int i = 0; i < MANY_COUNT; i++)
        MANY_AT(x, i) = called_tan(MANY_AT(x, i));
    return x;
}

static EXPANDED many fast_many_tan(many x)
{
#if VECTORS
    if (REDUCTION_IS_EXACT && MANY_SIZE(x) <= LARGEST_ANGLE)
        return many_tan(x);
#endif
    return many_tan_in_turn(x);
}

static CALLED many many_atan_in_turn(many x)
{
    for (int i = 0; i < MANY_COUNT; i++)
        MANY_AT(x, i) = called_atan(MANY_AT(x, i));
    return x;
}

static EXPANDED many fast_many_atan(many x)
{
#if VECTORS
    if (REDUCTION_IS_EXACT)
        return many_atan(x);
#endif
    return many_atan_in_turn(x);
}

static CALLED many many_exp_in_turn(many x)
{
    for (int i = 0; i < MANY_COUNT; i++)
        MANY_AT(x, i) = called_exp(MANY_AT(x, i));
    return x;
}

static EXPANDED many fast_many_exp(many x)
{
#if VECTORS
    if (REDUCTION_IS_EXACT && MANY_SIZE(x) <= LARGEST_EXPONENT)
        return many_exp(x);
#endif
    return many_exp_in_turn(x);
}

static CALLED many many_pow_in_turn(many x, many y)
{
    for (int i = 0; i < MANY_COUNT; i++)
        MANY_AT(x, i) = called_pow(MANY_AT(x, i), MANY_AT(y, i));
    return x;
}

static EXPANDED many fast_many_pow(many x, many y)
{
#if VECTORS
    if (REDUCTION_IS_EXACT && MANY_ALL(x, >= DBL_MIN) && MANY_ALL(x, <= DBL_MAX)) {
        const many exponent = many_exponent(x, y);
        if (MANY_SIZE(exponent) <= LARGEST_EXPONENT)
            return many_exp(exponent);
    }
#endif
    return many_pow_in_turn(x, y);
}
