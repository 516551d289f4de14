/* Array variables of FMI 3.  See arrays.h. */
#include "arrays.h"

static const unsigned ARRAY[][2] = ARRAYS; /* first scalar and size */

static int is_array(unsigned reference) { return reference >= FIRST_ARRAY && reference < FIRST_ARRAY + N_ARRAYS; }

static Status expect_count(const Instance *self, size_t n, size_t n_values)
{
    if (n == n_values)
        return STATUS_OK;
    return instance_refuse(self, STATUS_ERROR, "the variables have %lu values, not %lu", (unsigned long) n,
                           (unsigned long) n_values);
}

Status arrays_expand(const Instance *self, const unsigned references[], size_t n, size_t n_values, Scalars *found)
{
    size_t i, k, total = 0;

    found->references = references;
    found->n = n;
    for (i = 0; references && i < n && !is_array(references[i]); i++)
        ;
    if (!references || i == n)
        return expect_count(self, n, n_values);
    for (i = 0; i < n; i++) {
        const unsigned first = is_array(references[i]) ? ARRAY[references[i] - FIRST_ARRAY][0] : references[i];
        const size_t size = is_array(references[i]) ? ARRAY[references[i] - FIRST_ARRAY][1] : 1;

        if (size > N_VALUES - total)
            return instance_refuse(self, STATUS_ERROR, "a call is for %d values at most", (int) N_VALUES);
        for (k = 0; k < size; k++)
            found->own[total++] = first + (unsigned) k;
    }
    found->references = found->own;
    found->n = total;
    return expect_count(self, total, n_values);
}
