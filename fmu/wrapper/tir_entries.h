/* The entries of a property file that concern a tire, with their units converted.
 *
 * tir_keys.h has the keys, the spellings of units, and the names of models and effects as tables.
 */
#ifndef TIR_ENTRIES_H
#define TIR_ENTRIES_H

#include "instance.h"
#include "tir_keys.h"
#include "tir_text.h"

/* More effects are not declared by any model; units that [UNITS] declares. */
enum { MOST_EFFECTS = 64, N_UNITS = 6 };

/* What a file states.  Values are by target: the coefficients of the model, then others such as TIR_WIDTH. */
typedef struct {
    double found[TIR_TARGETS];
    char known[TIR_TARGETS];
    int has_effects; /* whether the file names its effects */
    char has[MOST_EFFECTS];
    char assumed[N_COEFFICIENTS]; /* the file lists the coefficient as not given */
    /* While reading. */
    double values[TIR_N_KEYS];
    char given[TIR_N_KEYS], own_section[TIR_N_KEYS];
    double factors[N_UNITS];
    char unit_given[N_UNITS];
    char model[TIR_WORD], format[TIR_WORD];
    double fittyp;
    int fittyp_given, format_given; /* 2: in [MODEL] */
    char *problem;
    size_t size;
} Reading;

/* Read a file; the problem and its size are set.  Returns 0 with one line in `problem` if the file cannot be used. */
int tir_read_entries(Reading *reading, const char path[]);
/* Write one printable line to `problem`.  Returns 0. */
int tir_refuse(Reading *reading, const char *format, ...);

#endif
