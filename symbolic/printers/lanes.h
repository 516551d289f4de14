/* LANES rows at a time: the vector types of GCC and Clang, and elementary functions on them.

   Reduction of the argument is the classical one (Cody and Waite, Software Manual for the Elementary Functions, 1980);
   the polynomials are tirefmu's own: those of tangent and arcus tangent have the least maximum of the relative error
   over the reduced range, by Remez's exchange in 50 digits; those of sine (exactly 1 at pi/2), exp and log interpolate in
   60 digits at the Chebyshev nodes; rounded to double. The error, measured against 36 digits, is below 3 units in the last
   place; that of lanes_atan below 12, as its polynomial is shorter than rounding requires; that of lanes_pow about
   |y log x| more. Outside the range of a reduction (angles beyond 1.8e7, exp beyond 700, log of 0 and subnormals,
   infinities) they give NaN: the caller of the kernel computes that row again separately. */

#if defined(LANES)
#elif defined(__AVX512F__)
#define LANES 8
#elif defined(__AVX__)
#define LANES 4
#else
#define LANES 2
#endif

typedef double lanes __attribute__((vector_size(8*LANES)));

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

static inline lanes one_where(lane_bits condition)
{
    return (lanes)((lane_bits)each(1.0) & condition);
}

static inline lanes lanes_absolute(lanes x)
{
    return (lanes)((lane_bits)x & INT64_MAX);
}

/* The size, which is not negative, with the sign of x. */
static inline lanes with_sign_of(lanes size, lanes x)
{
    return (lanes)((lane_bits)size | ((lane_bits)x & INT64_MIN));
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

/* x - x makes NaN of NaN. */
static inline lanes lanes_sgn(lanes x)
{
    return (lanes)((lane_bits)with_sign_of(each(1.0), x) & (x != 0.0)) + (x - x);
}

static inline lanes lanes_sgn1(lanes x)
{
    return with_sign_of(each(1.0), x + 0.0) + (x - x);
}

/* Added and subtracted again, it rounds to a whole number, which is in the lowest bits in between. */
#define LANES_ROUNDING 6755399441055744.0

/* x - n q pi for a whole number n of up to 8 digits; pi in two parts where products are not rounded before they are
   subtracted, in three parts otherwise, of which the first product with n is exact. */
#ifdef __FP_FAST_FMA
#define LANES_WITHOUT(x, n, q) (((x) - (n)*((q)*3.141592653589793)) - (n)*((q)*1.2246467991473532e-16))
#else
#define LANES_WITHOUT(x, n, q) ((((x) - (n)*((q)*3.141592651605606)) - (n)*((q)*1.9841871583270443e-09)) \
    - (n)*((q)*1.034036596358821e-18))
#endif

/* NaN beyond 1.8e7, where the multiple of pi that is next to the angle is no longer exact. */
static inline lanes lanes_checked_angle(lanes angle)
{
    return angle + 0.0*(angle*1e301);
}

/* The fixed factor of an arcus tangent: of an angle of such a product the sine needs no check. */
static inline double limited(double factor)
{
    return factor + 0.0*(factor*1e301);
}

/* (-1)^n sin(angle - (n - shift) pi), n being the whole number that brings it next to 0: the sine of the angle where
   shift is 0, the cosine where it is 1/2. */
static inline lanes lanes_shifted_sin(lanes angle, double shift)
{
    const lanes rounded = (angle*0.3183098861837907 + shift) + LANES_ROUNDING;
    const lanes n = (rounded - LANES_ROUNDING) - shift;
    const lanes r = LANES_WITHOUT(angle, n, 1.0);
    const lanes z = r*r;
    const lanes series = -0.16666666666666666 + z*(0.008333333333333316 + z*(-0.00019841269841254955
        + z*(2.755731921915843e-06 + z*(-2.5052107616384595e-08 + z*(1.6058977272815506e-10
        + z*(-7.643969031052769e-13 + z*2.731428986122616e-15))))));
    return (lanes)((lane_bits)(r + r*z*series) ^ ((lane_bits)rounded << 63));
}

static inline lanes lanes_sin(lanes x)
{
    return lanes_shifted_sin(lanes_checked_angle(x), 0.0);
}

static inline lanes lanes_cos(lanes x)
{
    return lanes_shifted_sin(lanes_checked_angle(x), 0.5);
}

static inline lanes lanes_limited_sin(lanes x)
{
    return lanes_shifted_sin(x, 0.0);
}

static inline lanes lanes_limited_cos(lanes x)
{
    return lanes_shifted_sin(x, 0.5);
}

/* Sine over cosine of what remains next to 0 of multiples of pi/2, or the reciprocal with the other sign. */
static inline lanes lanes_tan(lanes x)
{
    const lanes rounded = x*0.6366197723675814 + LANES_ROUNDING;
    const lanes r = LANES_WITHOUT(lanes_checked_angle(x), rounded - LANES_ROUNDING, 0.5);
    const lanes z = r*r;
    const lanes sine = r + r*z*(-0.1666666666666663 + z*(0.008333333333322118 + z*(-0.0001984126982958893
        + z*(2.755731362117812e-06 + z*(-2.5050747731531878e-08 + z*1.5896228416925448e-10)))));
    const lanes cosine = 1.0 + z*(-0.5 + z*(0.04166666666659654 + z*(-0.0013888888877611868
        + z*(2.480158070734838e-05 + z*(-2.7555523114049664e-07 + z*2.0645119096199667e-09)))));
    const lane_bits odd = ((lane_bits)rounded << 63) >> 63;
    return choose(odd, -cosine, sine)/choose(odd, sine, cosine);
}

/* atan(x), pi/4 + atan((x - 1)/(x + 1)) beyond tan(pi/8), pi/2 - atan(1/x) beyond tan(3 pi/8): three forms of
   numerator and denominator that differ by factors of 0 and 1. NaN at infinity. */
static inline lanes lanes_atan(lanes x)
{
    const lanes a = lanes_absolute(x);
    const lane_bits beyond = a > 0.41421356237309503, within = a <= 2.414213562373095;
    const lanes shifted = one_where(beyond), near = one_where(within);
    const lanes base = choose(within, (lanes)((lane_bits)each(0.7853981633974483) & beyond), each(1.5707963267948966));
    const lanes t = (a*near - shifted)/(a*shifted + near);
    const lanes z = t*t;
    const lanes series = -0.3333333333326008 + z*(0.19999999982681935 + z*(-0.142857128727868
        + z*(0.11111054405890605 + z*(-0.09089615001205895 + z*(0.07674318103477003 + z*(-0.06510245162000299
        + z*(0.05037413797673779 + z*-0.025474199622274877)))))));
    return with_sign_of(base + (t + t*z*series), x);
}

static inline lanes lanes_exp(lanes x)
{
    const lanes rounded = x*1.4426950408889634 + LANES_ROUNDING;
    const lanes n = rounded - LANES_ROUNDING;
    const lanes r = (x - n*0.6931471803691238) - n*1.9082149292705877e-10;
    const lanes r2 = r*r, r4 = r2*r2;
    const lanes tail = ((0.5000000000000001 + r*0.16666666666666669)
        + r2*(0.041666666666623824 + r*0.008333333333330039))
        + r4*((0.0013888888917367081 + r*0.00019841269863171557)
        + r2*(2.4801521057868204e-05 + r*2.7557268276905696e-06)
        + r4*(2.7620201591031547e-07 + r*2.5100472505694996e-08));
    const lanes power = (lanes)(((lane_bits)rounded + 1023) << 52);
    return choose(lanes_absolute(x) <= 700.0, power*(1.0 + (r + r2*tail)), each(NAN));
}

static inline lanes lanes_log(lanes x)
{
    const lane_bits bits = (lane_bits)x;
    const lanes mantissa = (lanes)((bits & 0x000fffffffffffff) | 0x3ff0000000000000);
    /* A whole number in the lowest bits of 2^52; the sign bit is 0 wherever the result is used. */
    const lanes exponent = (lanes)((bits >> 52) | 0x4330000000000000) - 4503599627371519.0;
    const lane_bits upper = mantissa > 1.4142135623730951;
    const lanes m = choose(upper, 0.5*mantissa, mantissa);
    const lanes n = choose(upper, exponent + 1.0, exponent);
    const lanes s = (m - 1.0)/(m + 1.0);
    const lanes z = s*s, z2 = z*z, z4 = z2*z2;
    const lanes series = z*((0.666666666666667 + z*0.3999999999989889)
        + z2*(0.28571428626253836 + z*0.22222211089379496)
        + z4*((0.1818289243253687 + z*0.15331611722055008) + z2*0.14617807153417325));
    const lanes value = n*0.6931471803691238 + (2.0*s + (s*series + n*1.9082149292705877e-10));
    return choose((x >= 2.2250738585072014e-308) & (x <= 1.7976931348623157e308), value, each(NAN));
}

static inline lanes lanes_pow(lanes x, lanes y)
{
    return lanes_exp(y*lanes_log(x));
}
