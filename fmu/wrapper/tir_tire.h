/* A tire of the model of this library from a property file (.tir).
 *
 * The rules are those of tirefmu.tires.property_file: units, spellings of keys, values that the field assumes for missing
 * keys.  tir_keys.h has them as tables.  A file of another model, or of a tire that needs other equations, is refused.
 */
#ifndef TIR_TIRE_H
#define TIR_TIRE_H

#include "instance.h"

typedef struct {
    double parameters[N_HOST_PARAMETERS];
    double ranges[N_INPUTS][2]; /* valid range of each input of the model */
    double width;               /* 0 if unknown, m */
} TirTire;

/* Read a file.  The parameters have the values that no file states.  Returns 0 and writes one line to `problem` if the file
   cannot be used. */
int tir_read(const char path[], TirTire *tire, char problem[], size_t size);

#endif
