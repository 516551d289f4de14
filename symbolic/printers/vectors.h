/* Expanded wherever it is called, and nowhere: small code for a routine with many calls. */
#ifdef __GNUC__
#define EXPANDED inline __attribute__((always_inline))
#define CALLED __attribute__((noinline))
#else
#define EXPANDED inline
#define CALLED
#endif

/* Two numbers: a vector of GCC and Clang; with other compilers, or with ONE_AT_A_TIME, an array whose numbers are
   computed one after the other. The operations are the same, and so are all results to the last bit, unless the
   compiler is allowed to fuse multiplications. */
#if defined(__GNUC__) && !defined(ONE_AT_A_TIME)
#define VECTORS 1
typedef double pair __attribute__((vector_size(16)));
typedef uint64_t pair_bits __attribute__((vector_size(16)));
#define PAIR(a, b) ((pair){a, b})
#define PAIR_AT(x, i) ((x)[i])
#else
#define VECTORS 0
typedef struct { double at[2]; } pair;
#define PAIR(a, b) ((pair){{a, b}})
#define PAIR_AT(x, i) ((x).at[i])
#endif

/* No less than the size of both numbers, or NaN. */
#define PAIR_SIZE(x) (fabs(PAIR_AT(x, 0)) + fabs(PAIR_AT(x, 1)))

/* What computes: a pair, in which all bits are set where a comparison holds and none elsewhere, or a number. A function
   of one number takes the first one of a pair. */
#if VECTORS
typedef pair number;
typedef pair_bits number_bits;
#define NUMBER_EACH(x) ((x) - (number){0.0})
#define NUMBER_BITS(x) ((number_bits)(x))
#define NUMBER_VALUE(bits) ((number)(bits))
#define NUMBER_WHERE(condition) ((number_bits)(condition))
#define NUMBER_ALONE(function, x) (function((number){x})[0])
#else
typedef double number;
typedef uint64_t number_bits;
#define NUMBER_EACH(x) (x)
#define NUMBER_BITS(x) bits_of(x)
#define NUMBER_VALUE(bits) double_of(bits)
#define NUMBER_WHERE(condition) (0 - (uint64_t)(condition))
#define NUMBER_ALONE(function, x) (function(x))
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
