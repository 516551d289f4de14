/* Sine, cosine, tangent and arcus tangent without branches and calls, so that a processor overlaps what does not depend
   on each other. Reduction of the argument is the classical one (Cody and Waite, Software Manual for the Elementary
   Functions, 1980); the polynomials are tirefmu's own: interpolation in 60 digits at the Chebyshev nodes of the
   reduced range, rounded to double. The error, measured against 36 digits, is below 3 units in the last place.
   Arguments that the reduction does not cover (huge angles, infinities, NaN) go to math.h. */
#if (defined(FLT_EVAL_METHOD) && FLT_EVAL_METHOD != 0) || defined(__FAST_MATH__)
/* Extended precision or liberties with rounding would spoil the reduction. */
#define fast_sin sin
#define fast_cos cos
#define fast_tan tan
#define fast_atan atan
#else

static inline uint64_t bits_of(double x)
{
    uint64_t bits;
    memcpy(&bits, &x, sizeof bits);
    return bits;
}

static inline double double_of(uint64_t bits)
{
    double x;
    memcpy(&x, &bits, sizeof x);
    return x;
}

/* Added and subtracted again, it rounds to a whole number, which stands in the lowest bits in between. */
#define ROUNDING 6755399441055744.0
/* Up to here a multiple of pi/2 is taken off exactly. */
#define LARGEST_ANGLE 1e7

/* (-1)^n sin(angle - (n - shift) pi), n being the whole number that brings it next to 0: the sine of the angle where
   shift is 0, the cosine where it is 1/2. */
static inline double shifted_sin(double angle, double shift)
{
    const double rounded = (angle*0.3183098861837907 + shift) + ROUNDING;
    const double n = (rounded - ROUNDING) - shift;
    const double r = ((angle - n*3.141592651605606) - n*1.9841871583270443e-09) - n*1.034036596358821e-18;
    const double z = r*r, z2 = z*z, z4 = z2*z2;
    const double series = ((-0.16666666666666666 + z*0.008333333333333316)
        + z2*(-0.00019841269841254955 + z*2.755731921915843e-06))
        + z4*((-2.5052107616384595e-08 + z*1.6058977272815506e-10)
        + z2*(-7.643969031052769e-13 + z*2.731428986122616e-15));
    return double_of(bits_of(r + r*z*series) ^ (bits_of(rounded) << 63));
}

static inline double fast_sin(double x)
{
    return fabs(x) <= LARGEST_ANGLE ? shifted_sin(x, 0.0) : sin(x);
}

static inline double fast_cos(double x)
{
    return fabs(x) <= LARGEST_ANGLE ? shifted_sin(x, 0.5) : cos(x);
}

static inline double fast_tan(double x)
{
    return fabs(x) <= LARGEST_ANGLE ? shifted_sin(x, 0.0)/shifted_sin(x, 0.5) : tan(x);
}

/* All of the real line: atan(x), pi/4 + atan((x - 1)/(x + 1)) beyond tan(pi/8), pi/2 - atan(1/x) beyond
   tan(3 pi/8). The three forms of numerator and denominator differ by factors of 0 and 1: a branch that nobody can
   predict costs more than all the rest. */
static inline double fast_atan(double x)
{
    const double size = fabs(x);
    const double a = 1e300 < size ? 1e300 : size; /* infinity times 0 would be NaN */
    const double shifted = (double)(a > 0.41421356237309503), near = (double)!(a > 2.414213562373095);
    const double eighths = shifted + (1.0 - near);
    const double t = (a*near - shifted)/(near + a*shifted);
    const double z = t*t, z2 = z*z, z4 = z2*z2, z8 = z4*z4;
    const double series = ((-0.3333333333333333 + z*0.19999999999995516)
        + z2*(-0.14285714284665682 + z*0.11111111015187018))
        + z4*((-0.0909090457530649 + z*0.07692183125376892) + z2*(-0.06664510525508936 + z*0.05858140904866328))
        + z8*((-0.050854078345894844 + z*0.03923044778479309) + z2*-0.019175404711104935);
    return copysign(eighths*0.7853981633974483 + (t + (t*z*series + eighths*3.061616997868383e-17)), x);
}

#endif
