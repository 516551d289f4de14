/* The values of the tire: part of the binary, or read from a file of the FMU.
 *
 * A binary contains one of two files: built_in_tire.c, compiled for one tire, or tire_file.c, which serves every tire
 * of a model with the same variables.
 */
#ifndef TIRE_H
#define TIRE_H

#include <stdint.h>

enum { TOKEN_SIZE = 48, NOTE_SIZE = 256 };

/* Fields have sizes that are multiples of 8 bytes: in the file they follow each other in the same way. */
typedef struct {
    char token[TOKEN_SIZE];  /* of the model description */
    char note[NOTE_SIZE];    /* what the FMU assumes, or empty */
    uint64_t count;          /* of values in the model description: the first ones */
    double starts[N_VALUES]; /* by value reference */
    double ranges[N_INPUTS][2]; /* the valid range of each input of the model */
} Tire;

/* Compute `tire`; `resources` is the path of the FMU's resources as the host gives it, or NULL.  Returns NULL, or why
   the tire is not available. */
const char *tire_find(const char *resources, Tire *tire);

#endif
