/* Tables through a kernel that computes BLOCK rows at a time. Inputs and results lie quantity by quantity, row after
   row, which is how several rows get into one vector register. */

#define BLOCK 64

/* Distance of two results of a block. With BLOCK, hundreds of results would share a few lines of the cache. */
#define STRIDE (BLOCK + 8)

/* The first place in an array that begins a cache line; the array has 8 numbers to spare. */
static double *aligned(double *array)
{
    const uintptr_t beyond = (uintptr_t)array % 64;
    return array + (beyond != 0 ? (64 - beyond)/8 : 0);
}

/* Take a block of inputs out of a table, its first row in the place of those that are missing. Of the next block,
   which arrives while this one is computed, one address of each cache line is named; beyond the table, that has no
   effect. */
static void take_block(size_t n, size_t stride, const double inputs[], double columns[])
{
    for (size_t k = 0; k < N_INPUTS; k++) {
        for (size_t i = 0; i < BLOCK; i += 8)
            __builtin_prefetch(inputs + k*stride + BLOCK + i);
        for (size_t i = 0; i < BLOCK; i++)
            columns[k*BLOCK + i] = inputs[k*stride + (i < n ? i : 0)];
    }
}

/* Put n rows of results into a table; a row in which one is not finite is marked as undone. */
static void put_block(size_t n, size_t stride, const double block[], double results[], unsigned char undone[])
{
    double sum[BLOCK] = {0.0};
    for (size_t k = 0; k < N_RESULTS; k++) {
        for (size_t i = 0; i < BLOCK; i++)
            sum[i] += 0.0*block[k*STRIDE + i];
        memcpy(results + k*stride, block + k*STRIDE, n*sizeof(double));
    }
    for (size_t i = 0; i < n; i++)
        undone[i] = sum[i] != 0.0; /* NaN differs from everything */
}

/* Put n rows of `count` chosen results into a table; a row in which one is not finite is marked as undone. */
static void put_chosen(size_t n, size_t stride, const double block[], size_t count, const size_t chosen[],
    double results[], unsigned char undone[])
{
    double sum[BLOCK] = {0.0};
    for (size_t k = 0; k < count; k++) {
        const double *result = block + chosen[k]*STRIDE;
        for (size_t i = 0; i < BLOCK; i++)
            sum[i] += 0.0*result[i];
        memcpy(results + k*stride, result, n*sizeof(double));
    }
    for (size_t i = 0; i < n; i++)
        undone[i] = sum[i] != 0.0;
}
