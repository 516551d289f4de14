/* Expanded wherever it is called, and nowhere: small code for a routine with many calls. */
#ifdef __GNUC__
#define EXPANDED inline __attribute__((always_inline))
#define CALLED __attribute__((noinline))
#else
#define EXPANDED inline
#define CALLED
#endif

/* One, two and four numbers: the vector types of GCC and Clang; with other compilers, or with ONE_AT_A_TIME, arrays whose
   numbers are computed one after the other. The operations are the same, and so are all results to the last bit, unless
   the compiler is allowed to fuse multiplications. */
#if defined(__GNUC__) && !defined(ONE_AT_A_TIME)
#define VECTORS 1
typedef double two __attribute__((vector_size(16)));
typedef uint64_t two_bits __attribute__((vector_size(16)));
#define TWO(a, b) ((two){a, b})
#define TWO_AT(x, i) ((x)[i])
#ifdef __AVX__
typedef double four __attribute__((vector_size(32)));
typedef uint64_t four_bits __attribute__((vector_size(32)));
#define FOUR(a, b, c, d) ((four){a, b, c, d})
#define FOUR_AT(x, i) ((x)[i])
#else
typedef struct { two half[2]; } four;
#define FOUR(a, b, c, d) ((four){{{a, b}, {c, d}}})
#define FOUR_AT(x, i) ((x).half[(i)/2][(i)%2])
#define FOUR_BY(function_of_two, x) ((four){{function_of_two((x).half[0]), function_of_two((x).half[1])}})
#define FOUR_BY_PAIRS(function_of_two, x, y) \
    ((four){{function_of_two((x).half[0], (y).half[0]), function_of_two((x).half[1], (y).half[1])}})
#endif
#else
#define VECTORS 0
typedef double one;
typedef uint64_t one_bits;
typedef struct { double at[2]; } two;
typedef struct { double at[4]; } four;
#define TWO(a, b) ((two){{a, b}})
#define TWO_AT(x, i) ((x).at[i])
#define FOUR(a, b, c, d) ((four){{a, b, c, d}})
#define FOUR_AT(x, i) ((x).at[i])
#endif
#define TWO_COUNT 2
#define FOUR_COUNT 4
#define TWO_ALL(x, condition) (TWO_AT(x, 0) condition && TWO_AT(x, 1) condition)
#define FOUR_ALL(x, condition) \
    (FOUR_AT(x, 0) condition && FOUR_AT(x, 1) condition && FOUR_AT(x, 2) condition && FOUR_AT(x, 3) condition)
/* No less than the size of any of the numbers, or NaN. */
#define TWO_SIZE(x) (fabs(TWO_AT(x, 0)) + fabs(TWO_AT(x, 1)))
#define FOUR_SIZE(x) ((fabs(FOUR_AT(x, 0)) + fabs(FOUR_AT(x, 1))) + (fabs(FOUR_AT(x, 2)) + fabs(FOUR_AT(x, 3))))

/* What computes: vectors, in which all bits are set where a comparison holds and none elsewhere, or a number. */
#if VECTORS
#define HAS_ONE 0
#define HAS_TWO 1
#define TWO_EACH(x) ((x) - (two){0.0})
#define TWO_BITS(x) ((two_bits)(x))
#define TWO_VALUE(bits) ((two)(bits))
#define TWO_WHERE(condition) ((two_bits)(condition))
#else
#define HAS_ONE 1
#define HAS_TWO 0
#define ONE_EACH(x) (x)
#define ONE_BITS(x) bits_of(x)
#define ONE_VALUE(bits) double_of(bits)
#define ONE_WHERE(condition) (0 - (uint64_t)(condition))
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
#endif
#if VECTORS && defined(__AVX__)
#define HAS_FOUR 1
#define FOUR_EACH(x) ((x) - (four){0.0})
#define FOUR_BITS(x) ((four_bits)(x))
#define FOUR_VALUE(bits) ((four)(bits))
#define FOUR_WHERE(condition) ((four_bits)(condition))
#else
#define HAS_FOUR 0
#endif
