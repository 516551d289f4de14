/* The values of the tire of a library with the Standard Tyre Interface.
 *
 * A library contains one of two files: sti_built_in.c, for the tire for which it was compiled, or sti_file.c, which reads
 * the file that the host names.  Then the values are stored in the host's TYPARR from initialization on.
 */
#ifndef STI_VALUES_H
#define STI_VALUES_H

#include "sti.h"

/* A title and the name of a file. */
enum { STI_TITLE = 2 * STI_TEXT };

/* At initialization: replace the values in `tire` by those of the host's file, and store them.  Returns IERR. */
int sti_take_values(Call *call, Tire *tire);
/* In all other calls: replace the values in `tire` by those that are stored.  Returns IERR. */
int sti_stored_values(Call *call, Tire *tire);
/* The width of the tire, m, and its title; after initialization. */
double sti_width(const Call *call);
const char *sti_title(const Call *call, char title[STI_TITLE]);

#endif
