/* The lines of a property file (.tir), which is untrusted.
 *
 * A line is a section in brackets, `KEY = value`, or a row of a table.  Comments begin with $ or !, outside quotes.
 * Nothing here knows what a key means.  Memory is bounded by the arrays below, time by MOST_BYTES.
 */
#ifndef TIR_TEXT_H
#define TIR_TEXT_H

#include <stddef.h>
#include <stdio.h>

enum { TIR_WORD = 64, TIR_LINE = 2048 };

typedef enum { TIR_END, TIR_ENTRY, TIR_ROW, TIR_BROKEN } TirKind;

typedef struct {
    FILE *file;
    unsigned long bytes, line;
    int in_table;
    int cut; /* the line is longer than TIR_LINE: its value is incomplete */
    char section[TIR_WORD], key[TIR_WORD]; /* in upper case; longer ones are cut */
    char value[TIR_LINE];                  /* without comment; of a row, the line */
    const char *problem;                   /* of a broken file */
} TirText;

/* Read the next entry or row; rows before the first section are skipped. */
TirKind tir_next(TirText *text);

/* The number of a value, in quotes or not, also in Fortran's notation.  Returns 0 if it is none or has text behind it;
   `*number` may be infinite. */
int tir_number(const char value[], double *number);
/* Copy the text of a value without the quotes around it; cut to `size`. */
void tir_unquote(const char value[], char text[], size_t size);
/* Upper case of a letter of ASCII, in every locale. */
char tir_upper(char letter);

#endif
