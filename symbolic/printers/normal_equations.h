/* Weighted least squares: of each force J^T W J, J^T W r and r^T W r, accumulated while the derivatives of PANEL rows are
   in the processor's cache. A panel has the weighted derivatives of one force, coefficient by coefficient, STEP numbers
   apart, and the weighted residuals last. */

#define PANEL (4*BLOCK)

/* Not a multiple of the size of a page, which would put all coefficients into a few lines of the cache. */
#define STEP (PANEL + 8)

/* Rows and columns of a tile of the matrix, whose sums are in registers. */
#define TILE_ROWS 4

#define TILE_COLUMNS 3

/* Rows of a panel and of a matrix for n derivatives and the residuals: whole tiles. */
static size_t whole_tiles(size_t n)
{
    const size_t both = TILE_ROWS*TILE_COLUMNS;
    return (n + 1 + both - 1)/both*both;
}

static inline lanes lanes_at(const double array[])
{
    return *(const lanes_in_array *)array;
}

static inline double sum_of_lanes(lanes x)
{
    double sum = 0.0;
    for (int i = 0; i < LANES; i++)
        sum += x[i];
    return sum;
}

/* Add the products of TILE_ROWS rows a and TILE_COLUMNS rows b of a panel to a tile of its matrix. */
static void add_tile(const double a[], const double b[], size_t size, double matrix[])
{
    lanes s00 = {0.0}, s01 = {0.0}, s02 = {0.0}, s10 = {0.0}, s11 = {0.0}, s12 = {0.0};
    lanes s20 = {0.0}, s21 = {0.0}, s22 = {0.0}, s30 = {0.0}, s31 = {0.0}, s32 = {0.0};
    for (size_t i = 0; i < PANEL; i += LANES) {
        const lanes b0 = lanes_at(b + i), b1 = lanes_at(b + STEP + i), b2 = lanes_at(b + 2*STEP + i);
        const lanes a0 = lanes_at(a + i), a1 = lanes_at(a + STEP + i);
        const lanes a2 = lanes_at(a + 2*STEP + i), a3 = lanes_at(a + 3*STEP + i);
        s00 += a0*b0, s01 += a0*b1, s02 += a0*b2;
        s10 += a1*b0, s11 += a1*b1, s12 += a1*b2;
        s20 += a2*b0, s21 += a2*b1, s22 += a2*b2;
        s30 += a3*b0, s31 += a3*b1, s32 += a3*b2;
    }
    const lanes sums[TILE_ROWS*TILE_COLUMNS] = {s00, s01, s02, s10, s11, s12, s20, s21, s22, s30, s31, s32};
    for (size_t k = 0; k < TILE_ROWS*TILE_COLUMNS; k++)
        matrix[k/TILE_COLUMNS*size + k%TILE_COLUMNS] += sum_of_lanes(sums[k]);
}

/* Fill BLOCK rows of a panel, n of them with the weighted derivatives that `entries` chooses. A row without a weight is
   0, whatever its derivatives are; `sum` becomes NaN in a row of which a weighted derivative is not finite. */
static void fill_panel(size_t n, const double derivatives[], size_t count, const size_t entries[],
    const double roots[], const double residuals[], double panel[], double sum[])
{
    double weights[BLOCK] = {0.0};
    memcpy(weights, roots, n*sizeof(double));
    for (size_t k = 0; k < count; k++)
        for (size_t i = 0; i < BLOCK; i += LANES) {
            const lanes weight = lanes_at(weights + i), weighted = lanes_at(derivatives + entries[k]*STRIDE + i)*weight;
            const lanes used = (lanes)((lane_bits)weighted & (weight != 0.0));
            *(lanes_in_array *)(panel + k*STEP + i) = used;
            *(lanes_in_array *)(sum + i) = lanes_at(sum + i) + 0.0*used;
        }
    for (size_t i = 0; i < BLOCK; i++)
        panel[count*STEP + i] = i < n && weights[i] != 0.0 ? residuals[i] : 0.0;
}

/* Return whether any of n weights is not 0. */
static int any_weight(size_t n, const double roots[])
{
    for (size_t i = 0; i < n; i++)
        if (roots[i] != 0.0)
            return 1;
    return 0;
}

/* Fill BLOCK rows of the panels of all forces that have a weight among m rows; a row with derivatives that are not
   finite is marked as undone, and 0. */
static void fill_panels(size_t n, size_t stride, const double derivatives[], const int weighted[],
    const size_t first[], const size_t entries[], const double roots[], const double residuals[], double panels[],
    unsigned char undone[])
{
    double sum[BLOCK] = {0.0}, *panel = panels;
    for (size_t force = 0; force < N_FORCES; force++) {
        const size_t count = first[force + 1] - first[force];
        if (weighted[force])
            fill_panel(n, derivatives, count, entries + first[force], roots + force*stride, residuals + force*stride,
                panel, sum);
        panel += whole_tiles(count)*STEP;
    }
    for (size_t i = 0; i < n; i++) {
        undone[i] = sum[i] != 0.0; /* NaN differs from everything */
        if (undone[i])
            for (double *row = panels; row < panel; row += STEP)
                row[i] = 0.0;
    }
}

/* Add the lower triangles of the matrices of all forces that have a weight: the last row of each is J^T W r, r^T W r. */
static void add_panels(const int weighted[], const size_t first[], const double panels[], double matrices[])
{
    for (size_t force = 0; force < N_FORCES; force++) {
        const size_t count = first[force + 1] - first[force], size = whole_tiles(count);
        for (size_t j = 0; j <= count && weighted[force]; j += TILE_ROWS)
            for (size_t k = 0; k <= count && k < j + TILE_ROWS; k += TILE_COLUMNS)
                add_tile(panels + j*STEP, panels + k*STEP, size, matrices + j*size + k);
        panels += size*STEP;
        matrices += size*size;
    }
}

/* Add the normal equations of n rows. `first` and `entries` choose the derivatives of each force; `roots` are the roots
   of the weights, `residuals` are weighted, both force by force. `panels` is memory of 0 for the panels of all forces. */
static void add_normal_equations(void (*kernel)(const double[], const double[], double[]), size_t n, size_t stride,
    const double inputs[], const double parameters[], const size_t first[], const size_t entries[],
    const double roots[], const double residuals[], double panels[], double matrices[], unsigned char undone[])
{
    double columns[N_INPUTS*BLOCK + 8], derivatives[N_RESULTS*STRIDE + 8];
    for (size_t start = 0; start < n; start += PANEL) {
        int weighted[N_FORCES];
        for (size_t force = 0; force < N_FORCES; force++)
            weighted[force] = any_weight(n - start < PANEL ? n - start : PANEL, roots + force*stride + start);
        for (size_t block = 0; block < PANEL; block += BLOCK) {
            const size_t at = start + block < n ? start + block : n, m = n - at < BLOCK ? n - at : BLOCK;
            if (m > 0) {
                take_block(m, stride, inputs + at, aligned(columns));
                kernel(aligned(columns), parameters, aligned(derivatives));
            }
            fill_panels(m, stride, aligned(derivatives), weighted, first, entries, roots + at, residuals + at,
                panels + block, undone + at);
        }
        add_panels(weighted, first, panels, matrices);
    }
}
