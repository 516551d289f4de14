/* A road of resources/road.bin, which is untrusted.  See road.h.
 *
 * The file has the structure `Header`, then as doubles: the points of the reference line (n, 2), the directions of its
 * parts (n - 1, 2), its directions at the points (n, 2), the distances v of the grid (m), and the heights (n, m).
 */
#include "road.h"

#include "resource_file.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#define FILE_NAME "road.bin"
#define MAX_NUMBERS 100000000ull
/* Points of the reference line for which one circle is compared first. */
#define GROUP 64

static const char FORMAT[8] = "TIREROAD";

typedef struct {
    char format[8];
    uint64_t n, m;
    double increment, length;
} Header;

/* A circle around the points of a group. */
typedef struct {
    double x, y, radius;
} Circle;

struct RoadGrid {
    size_t n, m, n_groups;
    double increment, length; /* of the parts of the reference line; over which the slopes are taken */
    const double *points, *ahead, *across, *v, *heights;
    Circle *groups;
    double numbers[];
};

/* ---------------------------------------------------------------- file */

static size_t count_numbers(const Header *header)
{
    return (size_t) (2 * header->n + 2 * (header->n - 1) + 2 * header->n + header->m + header->n * header->m);
}

static int is_possible(const Header *header)
{
    return memcmp(header->format, FORMAT, sizeof FORMAT) == 0 && header->n >= 2 && header->m >= 2 &&
           header->n <= MAX_NUMBERS / 8 && header->m <= MAX_NUMBERS / 8 && header->n <= MAX_NUMBERS / header->m &&
           isfinite(header->increment) && header->increment > 0.0 && isfinite(header->length) && header->length > 0.0;
}

static void find_groups(RoadGrid *grid)
{
    size_t g, i;

    for (g = 0; g < grid->n_groups; g++) {
        const size_t first = g * GROUP, last = first + GROUP < grid->n ? first + GROUP : grid->n;
        Circle *circle = &grid->groups[g];

        circle->x = grid->points[2 * ((first + last) / 2)];
        circle->y = grid->points[2 * ((first + last) / 2) + 1];
        circle->radius = 0.0;
        for (i = first; i < last; i++) {
            const double distance = hypot(grid->points[2 * i] - circle->x, grid->points[2 * i + 1] - circle->y);
            circle->radius = distance > circle->radius ? distance : circle->radius;
        }
    }
}

static const char *fill(RoadGrid *grid, const Header *header, size_t count)
{
    size_t i;

    grid->n = (size_t) header->n;
    grid->m = (size_t) header->m;
    grid->increment = header->increment;
    grid->length = header->length;
    grid->points = grid->numbers;
    grid->ahead = grid->points + 2 * grid->n;
    grid->across = grid->ahead + 2 * (grid->n - 1);
    grid->v = grid->across + 2 * grid->n;
    grid->heights = grid->v + grid->m;
    for (i = 0; i < count; i++)
        if (!isfinite(grid->numbers[i]))
            return FILE_NAME " is damaged: a number is not finite";
    for (i = 1; i < grid->m; i++)
        if (!(grid->v[i] > grid->v[i - 1]))
            return FILE_NAME " is damaged: the grid is not in order";
    grid->n_groups = (grid->n + GROUP - 1) / GROUP;
    grid->groups = malloc(grid->n_groups * sizeof *grid->groups);
    if (!grid->groups)
        return "no memory for the road";
    find_groups(grid);
    return NULL;
}

static const char *read_grid(FILE *file, RoadGrid **grid)
{
    Header header;
    size_t count;

    if (fread(&header, sizeof header, 1, file) != 1 || !is_possible(&header))
        return FILE_NAME " is damaged, or is not a road";
    count = count_numbers(&header);
    *grid = calloc(1, sizeof **grid + count * sizeof(double));
    if (!*grid)
        return "no memory for the road";
    if (fread((*grid)->numbers, sizeof(double), count, file) != count || fgetc(file) != EOF)
        return FILE_NAME " is damaged: its size is wrong";
    return fill(*grid, &header, count);
}

const char *road_open(const char *resources, RoadGrid **grid)
{
    FILE *file = resource_open(resources, FILE_NAME);
    const char *problem;

    *grid = NULL;
    if (!file)
        return FILE_NAME " in the resources cannot be opened, or the host does not pass their path";
    problem = read_grid(file, grid);
    fclose(file);
    if (problem) {
        road_close(*grid);
        *grid = NULL;
    }
    return problem;
}

void road_close(RoadGrid *grid)
{
    if (grid)
        free(grid->groups);
    free(grid);
}

/* ---------------------------------------------------------------- geometry */

static double squared(const RoadGrid *grid, size_t i, double x, double y)
{
    const double dx = x - grid->points[2 * i], dy = y - grid->points[2 * i + 1];
    return dx * dx + dy * dy;
}

/* The nearest point of the reference line; the first one of several. */
static size_t find_nearest(const RoadGrid *grid, double x, double y)
{
    double least = HUGE_VAL, reach = HUGE_VAL;
    size_t nearest = 0, g, i;

    for (g = 0; g < grid->n_groups; g++) {
        const Circle *circle = &grid->groups[g];

        if (hypot(x - circle->x, y - circle->y) - circle->radius > reach)
            continue;
        for (i = g * GROUP; i < (g + 1) * GROUP && i < grid->n; i++)
            if (squared(grid, i, x, y) < least) {
                least = squared(grid, i, x, y);
                reach = sqrt(least) * (1.0 + 1e-9);
                nearest = i;
            }
    }
    return nearest;
}

/* How far a point is behind the grid line of point i of the reference line. */
static double behind_line(const RoadGrid *grid, size_t i, double x, double y)
{
    return (x - grid->points[2 * i]) * grid->across[2 * i] + (y - grid->points[2 * i + 1]) * grid->across[2 * i + 1];
}

/* u in increments, and v. */
static void find_place(const RoadGrid *grid, double x, double y, double *u, double *v)
{
    const size_t nearest = find_nearest(grid, x, y), last = grid->n - 2;
    size_t i = behind_line(grid, nearest, x, y) < 0.0 ? (nearest > 0 ? nearest - 1 : 0) : nearest;
    double before, after;

    i = i < last ? i : last;
    before = behind_line(grid, i, x, y);
    after = -behind_line(grid, i + 1, x, y);
    if (before < 0.0)
        *u = (double) i + before / grid->increment;
    else if (after < 0.0)
        *u = (double) i + (grid->increment - after) / grid->increment;
    else
        *u = (double) i + (before + after > 0.0 ? before / (before + after) : 0.0);
    *v = grid->ahead[2 * i] * (y - grid->points[2 * i + 1]) - grid->ahead[2 * i + 1] * (x - grid->points[2 * i]);
}

static double limited(double x, double low, double high) { return x < low ? low : x > high ? high : x; }

static double find_height(const RoadGrid *grid, double x, double y)
{
    double u, v, a, b, low, high;
    size_t i, j, least = 0, most = grid->m - 1;
    const double *row;

    find_place(grid, x, y, &u, &v);
    if (!isfinite(u) || !isfinite(v))
        return u + v; /* not finite: the host's position is refused */
    u = limited(u, 0.0, (double) grid->n - 1.0);
    v = limited(v, grid->v[0], grid->v[grid->m - 1]);
    i = (size_t) u < grid->n - 2 ? (size_t) u : grid->n - 2;
    while (most - least > 1) {
        j = (least + most) / 2;
        if (grid->v[j] <= v)
            least = j;
        else
            most = j;
    }
    j = least;
    a = u - (double) i;
    b = (v - grid->v[j]) / (grid->v[j + 1] - grid->v[j]);
    row = grid->heights + i * grid->m + j;
    low = (1.0 - b) * row[0] + b * row[1];
    high = (1.0 - b) * row[grid->m] + b * row[grid->m + 1];
    return (1.0 - a) * low + a * high;
}

void road_plane(const RoadGrid *grid, double x, double y, double plane[4])
{
    const double h = 0.5 * grid->length;

    plane[0] = find_height(grid, x, y);
    plane[1] = (find_height(grid, x - h, y) - find_height(grid, x + h, y)) / grid->length;
    plane[2] = (find_height(grid, x, y - h) - find_height(grid, x, y + h)) / grid->length;
    plane[3] = 1.0;
}
