/* A road of resources/road.bin: a grid of heights along a reference line, as tirefmu.tires.roads.
 *
 * Heights are bilinear.  The grid is read when the FMU is instantiated, and is constant after that.
 */
#ifndef ROAD_H
#define ROAD_H

typedef struct RoadGrid RoadGrid;

/* Read the grid.  Returns NULL, or why it is not available. */
const char *road_open(const char *resources, RoadGrid **grid);
void road_close(RoadGrid *grid);
/* The height at x, y, and the normal of the plane by the slopes over the length of the contact patch, m. */
void road_plane(const RoadGrid *grid, double x, double y, double plane[4]);

#endif
