/* Files in the resources of the FMU. */
#ifndef RESOURCE_FILE_H
#define RESOURCE_FILE_H

#include <stdio.h>

/* Open a file by its name; `resources` is the path of the FMU's resources as the host gives it, or NULL.  Returns NULL
   if it cannot be opened. */
FILE *resource_open(const char *resources, const char *name);

#endif
