/* Array variables of FMI 3: each has a value reference of its own, and stands for scalars with successive ones. */
#ifndef ARRAYS_H
#define ARRAYS_H

#include "instance.h"

/* The value reference of the first array, beyond those of all scalars. */
#define FIRST_ARRAY 0x10000u

/* The value references of scalars; `own` holds them if there are arrays among those of the host. */
typedef struct {
    const unsigned *references;
    size_t n;
    unsigned own[N_VALUES];
} Scalars;

/* Find the scalars of variables, whose values are `n_values` numbers. */
Status arrays_expand(const Instance *self, const unsigned references[], size_t n, size_t n_values, Scalars *found);

#endif
