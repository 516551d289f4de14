/* Sine, cosine, tangent and arcus tangent without branches and calls, so that a processor overlaps what does not depend
   on each other. Reduction of the argument is the classical one (Cody and Waite, Software Manual for the Elementary
   Functions, 1980); the polynomials are tirefmu's own: that of the sine interpolates in 60 digits at the Chebyshev nodes
   of the reduced range, as with it the sine of pi/2 is exactly 1, and factors of low speed are exactly 0 at standstill;
   those of the tangent have the least maximum of the relative error (Remez's exchange in 50 digits); rounded to double.
   The error, measured against 36 digits, is below 3 units in the last place.
   Arguments that the reduction does not cover (huge angles, infinities, NaN) go to math.h. */

/* Extended precision or liberties with rounding would spoil the reduction. */
#if (defined(FLT_EVAL_METHOD) && FLT_EVAL_METHOD != 0) || defined(__FAST_MATH__)
#define REDUCTION_IS_EXACT 0
#else
#define REDUCTION_IS_EXACT 1
#endif

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

/* Added and subtracted again, it rounds to a whole number, which is in the lowest bits in between. */
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
    return REDUCTION_IS_EXACT && fabs(x) <= LARGEST_ANGLE ? shifted_sin(x, 0.0) : sin(x);
}

static inline double fast_cos(double x)
{
    return REDUCTION_IS_EXACT && fabs(x) <= LARGEST_ANGLE ? shifted_sin(x, 0.5) : cos(x);
}

/* Sine over cosine of what remains next to 0 of multiples of pi/2, or the reciprocal with the other sign. */
static inline double fast_tan(double x)
{
    if (!REDUCTION_IS_EXACT || !(fabs(x) <= LARGEST_ANGLE))
        return tan(x);
    const double rounded = x*0.6366197723675814 + ROUNDING, n = 0.5*(rounded - ROUNDING);
    const double r = ((x - n*3.141592651605606) - n*1.9841871583270443e-09) - n*1.034036596358821e-18;
    const double z = r*r;
    const double sine = r + r*z*(-0.1666666666666663 + z*(0.008333333333322118 + z*(-0.0001984126982958893
        + z*(2.755731362117812e-06 + z*(-2.5050747731531878e-08 + z*1.5896228416925448e-10)))));
    const double cosine = 1.0 + z*(-0.5 + z*(0.04166666666659654 + z*(-0.0013888888877611868
        + z*(2.480158070734838e-05 + z*(-2.7555523114049664e-07 + z*2.0645119096199667e-09)))));
    const uint64_t odd = 0 - (bits_of(rounded) & 1), a = bits_of(sine), b = bits_of(cosine), c = bits_of(-cosine);
    return double_of((c & odd) | (a & ~odd))/double_of((a & odd) | (b & ~odd));
}

/* One row for |x| below 1/32, eight for each doubling up to 32, one beyond: factors n and s and arcus tangent b, in two
   parts, in atan(x) = b + atan((x n - s)/(n + x s)), whose argument is below 1/32. */
static const double arcs[82][4] = {
    {1.0, 0.0, 0.0, 0.0},
    {1.0, 0.033203125, 0.033190931497111595, -9.429391539055672e-19},
    {1.0, 0.037109375, 0.037092354550391816, -1.940506527205818e-18},
    {1.0, 0.041015625, 0.04099264824526378, 2.4768764111915086e-18},
    {1.0, 0.044921875, 0.0448916944623465, 2.3175181899658153e-19},
    {1.0, 0.048828125, 0.04878937530951562, 2.9134876745390293e-18},
    {1.0, 0.052734375, 0.05268557314313004, 2.868662329888331e-18},
    {1.0, 0.056640625, 0.05658017058914571, 3.2548950769825045e-18},
    {1.0, 0.060546875, 0.06047305056410732, -5.669898903339674e-19},
    {1.0, 0.06640625, 0.06630889491982349, -4.885923989304001e-19},
    {1.0, 0.07421875, 0.07408292254903373, 1.35448289530323e-19},
    {1.0, 0.08203125, 0.08184798980307655, 1.7384613138337837e-18},
    {1.0, 0.08984375, 0.08960317748487175, -1.080825883551364e-18},
    {1.0, 0.09765625, 0.09734757348722367, 2.515065895443577e-18},
    {1.0, 0.10546875, 0.10508027341632953, 3.0363193185774176e-18},
    {1.0, 0.11328125, 0.11280038120165939, 1.8672415475943625e-18},
    {1.0, 0.12109375, 0.12050700969122456, -5.3252909626225655e-19},
    {1.0, 0.1328125, 0.13203976161463876, -1.2769254007099595e-17},
    {1.0, 0.1484375, 0.14736148108865163, 5.409599147666298e-18},
    {1.0, 0.1640625, 0.16261382859794857, 7.784470643106252e-18},
    {1.0, 0.1796875, 0.17779022899267607, -4.029582100854422e-18},
    {1.0, 0.1953125, 0.19288431225797467, -7.414590176247246e-18},
    {1.0, 0.2109375, 0.207889927202263, 7.333160666520898e-18},
    {1.0, 0.2265625, 0.22280115375939452, -5.498822172446843e-18},
    {1.0, 0.2421875, 0.23761231386547124, 1.058231431371113e-17},
    {1.0, 0.265625, 0.2596296294082575, 1.9238754924615304e-17},
    {1.0, 0.296875, 0.2885873618940774, -1.428369957377257e-17},
    {1.0, 0.328125, 0.31705575320914703, -1.893928924292642e-17},
    {1.0, 0.359375, 0.34500217720710513, -2.2938804755578304e-17},
    {1.0, 0.390625, 0.3723984466767542, 1.9612311504845653e-17},
    {1.0, 0.421875, 0.39922076957525254, 2.246598105617042e-17},
    {1.0, 0.453125, 0.42544963737004227, 2.3315530741892885e-17},
    {1.0, 0.484375, 0.4510696559885235, -2.2703795229420475e-17},
    {1.0, 0.53125, 0.48833395105640554, -1.1373236189329585e-17},
    {1.0, 0.59375, 0.5358112379604637, -4.0637956834825575e-18},
    {1.0, 0.65625, 0.5807563535676704, -1.441464378193067e-17},
    {1.0, 0.71875, 0.6231993299340659, 2.672403885140095e-17},
    {1.0, 0.78125, 0.6632029927060933, -3.076054864429649e-17},
    {1.0, 0.84375, 0.7008544078844502, -1.987626234335816e-17},
    {1.0, 0.90625, 0.7362574289814281, 3.473937648299457e-17},
    {1.0, 0.96875, 0.7695264804056583, -3.704991905602721e-17},
    {1.0, 1.0625, 0.8156919233162234, -1.071456562778743e-17},
    {1.0, 1.1875, 0.870903457075653, -2.269823590747287e-17},
    {1.0, 1.3125, 0.9197196053504169, -4.057439412852768e-17},
    {1.0, 1.4375, 0.9629943306809362, -3.9866605952107524e-18},
    {1.0, 1.5625, 1.0014831356942346, 9.438308023545392e-17},
    {1.0, 1.6875, 1.0358412530088001, 3.194313981784504e-17},
    {1.0, 1.8125, 1.0666303653157436, -5.956589637160375e-17},
    {1.0, 1.9375, 1.09432890732119, -5.490676155022364e-18},
    {1.0, 2.125, 1.1309537439791604, 7.123833804538446e-17},
    {1.0, 2.375, 1.1722738811284763, 8.385188614028674e-17},
    {1.0, 2.625, 1.2068173702852525, 4.172467638861439e-17},
    {1.0, 2.875, 1.2360594894780819, 7.879752739459421e-17},
    {1.0, 3.125, 1.2610933822524404, 3.2421396215349605e-17},
    {1.0, 3.375, 1.2827408797442708, -9.28318875426613e-18},
    {1.0, 3.625, 1.3016288340091962, -1.2369184998246267e-17},
    {1.0, 3.875, 1.3182420510168371, -6.319394031144676e-17},
    {1.0, 4.25, 1.3397056595989996, -2.5990118603041344e-17},
    {1.0, 4.75, 1.3633001003596938, 1.0932461715269362e-16},
    {1.0, 5.25, 1.382574821490126, -3.56149043864823e-17},
    {1.0, 5.75, 1.3986055122719576, -2.324061182591628e-17},
    {1.0, 6.25, 1.4121410646084953, -9.573807110557223e-17},
    {1.0, 6.75, 1.423717971406494, 8.721870922223968e-17},
    {1.0, 7.25, 1.433730152484709, -4.396204466767636e-17},
    {1.0, 7.75, 1.442473099109102, -1.1051194354303157e-16},
    {1.0, 8.5, 1.4536875822280324, -6.818769250151347e-17},
    {1.0, 9.5, 1.4659193880646628, -9.711255554074832e-17},
    {1.0, 10.5, 1.4758446204521403, 3.387559672766315e-17},
    {1.0, 11.5, 1.4840579881189115, -3.445451067863594e-17},
    {1.0, 12.5, 1.4909663410826592, 6.221434760020122e-17},
    {1.0, 13.5, 1.4968572891369563, 1.696007621255117e-17},
    {1.0, 14.5, 1.501939837493852, 6.061899584075814e-17},
    {1.0, 15.5, 1.5063694873693432, -1.0553391013319709e-16},
    {1.0, 17.0, 1.512040504079174, -8.178272486963065e-17},
    {1.0, 19.0, 1.5182132651839548, 7.140532115600162e-17},
    {1.0, 21.0, 1.5232132235179132, 6.0651497755514614e-18},
    {1.0, 23.0, 1.5273454314033659, -9.470042107800935e-17},
    {1.0, 25.0, 1.5308176396716067, -8.913347633498722e-17},
    {1.0, 27.0, 1.5337762109209665, 9.377354806572844e-17},
    {1.0, 29.0, 1.5363272257953886, -1.733732170938949e-18},
    {1.0, 31.0, 1.5385494443596428, -1.0466306714301389e-16},
    {0.0, 1.0, 1.5707963267948966, 6.123233995736766e-17},
};

static inline double fast_atan(double x)
{
    if (!REDUCTION_IS_EXACT)
        return atan(x);
    const double size = fabs(x);
    const double a = 1e300 < size ? 1e300 : size; /* infinity times 0 would be NaN */
    const int64_t place = (int64_t)(bits_of(a) >> 49) - 8143; /* exponent and three bits, counted from 1/32 */
    const double *arc = arcs[place < 0 ? 0 : place > 81 ? 81 : place];
    const double t = (a*arc[0] - arc[1])/(arc[0] + a*arc[1]);
    const double z = t*t;
    const double series = -1.0/3.0 + z*(1.0/5.0 + z*(-1.0/7.0 + z*(1.0/9.0 + z*(-1.0/11.0))));
    return copysign(arc[2] + (t + (t*z*series + arc[3])), x);
}

/* Not expanded where they are called: small code for a routine with many calls. */
#ifdef __GNUC__
#define CALLED __attribute__((noinline))
#else
#define CALLED
#endif

static CALLED double called_sin(double x) { return fast_sin(x); }

static CALLED double called_cos(double x) { return fast_cos(x); }

static CALLED double called_tan(double x) { return fast_tan(x); }

static CALLED double called_atan(double x) { return fast_atan(x); }
