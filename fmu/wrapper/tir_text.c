/* The lines of a property file.  See tir_text.h. */
#include "tir_text.h"

#include <locale.h>
#include <stdlib.h>
#include <string.h>

#define MOST_BYTES 10000000ul
/* The exact decimals of a number have more digits than any file states. */
#define LONGEST_NUMBER 400
#define LONGEST_POINT 8

char tir_upper(char letter) { return (char) (letter >= 'a' && letter <= 'z' ? letter - 'a' + 'A' : letter); }

static int is_blank(char letter) { return letter == ' ' || (letter >= '\t' && letter <= '\r'); }

static int is_digit(char letter) { return letter >= '0' && letter <= '9'; }

static int is_letter(char letter) { return tir_upper(letter) >= 'A' && tir_upper(letter) <= 'Z'; }

/* ---------------------------------------------------------------- lines */

/* Read a line without its end.  Returns 0 at the end of the file. */
static int read_line(TirText *text, char line[TIR_LINE])
{
    size_t n = 0;
    int letter;

    text->cut = 0;
    while ((letter = fgetc(text->file)) != EOF && letter != '\n' && letter != '\r') {
        if (++text->bytes > MOST_BYTES) {
            text->problem = "the file is too large";
            return 0;
        }
        if (n + 1 < TIR_LINE)
            line[n++] = letter ? (char) letter : '?';
        else
            text->cut = 1;
    }
    line[n] = 0;
    text->line++;
    if (letter == '\r' && (letter = fgetc(text->file)) != '\n' && letter != EOF)
        ungetc(letter, text->file);
    text->bytes++;
    return letter != EOF || n > 0;
}

/* End the line before its comment.  A quote that is not closed is an apostrophe. */
static void cut_comment(TirText *text, char line[])
{
    size_t i;

    for (i = 0; line[i]; i++) {
        if (line[i] == '\'' || line[i] == '"') {
            const char *closing = strchr(line + i + 1, line[i]);
            if (closing)
                i = (size_t) (closing - line);
        } else if (line[i] == '$' || line[i] == '!') {
            line[i] = 0;
            text->cut = 0;
            return;
        }
    }
}

/* The first letter that is not blank; blanks at the end are removed. */
static char *trim(char line[])
{
    size_t n;

    while (is_blank(*line))
        line++;
    for (n = strlen(line); n > 0 && is_blank(line[n - 1]); n--)
        line[n - 1] = 0;
    return line;
}

static void copy_word(char word[TIR_WORD], const char *from, size_t n)
{
    size_t i;

    for (i = 0; i < n && i + 1 < TIR_WORD; i++)
        word[i] = tir_upper(from[i]);
    word[i] = 0;
}

/* The length of the key that a line begins with; 0 for a line that is not `KEY = value`. */
static size_t key_length(const char line[])
{
    size_t n = 0, i;

    if (!is_letter(line[0]))
        return 0;
    while (is_letter(line[n]) || is_digit(line[n]) || line[n] == '_')
        n++;
    for (i = n; is_blank(line[i]);)
        i++;
    return line[i] == '=' ? n : 0;
}

/* Returns 0 for a section that is not closed, or with text behind it. */
static int open_section(TirText *text, char line[])
{
    char *name = line + 1, *end = strchr(name, ']');

    if (!end || end[1] || strchr(name, '[')) {
        text->problem = "a section is not closed, or text is behind it";
        return 0;
    }
    *end = 0;
    name = trim(name);
    copy_word(text->section, name, strlen(name));
    text->in_table = 0;
    return 1;
}

TirKind tir_next(TirText *text)
{
    char buffer[TIR_LINE], *line;
    size_t n;

    while (read_line(text, buffer)) {
        line = buffer;
        if (text->line == 1 && strncmp(line, "\xef\xbb\xbf", 3) == 0)
            line += 3;
        if (text->line == 1 && (strncmp(line, "\xff\xfe", 2) == 0 || strncmp(line, "\xfe\xff", 2) == 0)) {
            text->problem = "the text is UTF-16: save it as UTF-8";
            return TIR_BROKEN;
        }
        cut_comment(text, line);
        line = trim(line);
        if (*line == '[') {
            if (!open_section(text, line))
                return TIR_BROKEN;
            continue;
        }
        n = key_length(line);
        if (n > 0) {
            copy_word(text->key, line, n);
            strcpy(text->value, trim(strchr(line, '=') + 1));
            text->in_table = 0;
            return TIR_ENTRY;
        }
        if (*line && *text->section) {
            text->in_table = text->in_table || *line == '{' || *line == '(';
            strcpy(text->value, line);
            return TIR_ROW;
        }
    }
    return text->problem || ferror(text->file) ? TIR_BROKEN : TIR_END;
}

/* ---------------------------------------------------------------- values */

void tir_unquote(const char value[], char text[], size_t size)
{
    size_t n = strlen(value);

    if (n > 1 && (value[0] == '\'' || value[0] == '"') && strchr(value + 1, value[0]) == value + n - 1) {
        value++;
        n -= 2;
    }
    while (n > 0 && is_blank(*value))
        value++, n--;
    while (n > 0 && is_blank(value[n - 1]))
        n--;
    if (n >= size)
        n = size - 1;
    memcpy(text, value, n);
    text[n] = 0;
}

static size_t count_digits(const char text[])
{
    size_t n = 0;
    while (is_digit(text[n]))
        n++;
    return n;
}

int tir_number(const char value[], double *number)
{
    /* strtod reads the decimal point of the host's locale. */
    const char *point = localeconv()->decimal_point;
    char text[LONGEST_NUMBER], found[LONGEST_NUMBER + LONGEST_POINT + 1];
    size_t n = 0, i = 0, whole, part = 0;

    tir_unquote(value, text, sizeof text);
    if (strlen(text) + 1 >= sizeof text || strlen(point) > LONGEST_POINT)
        return 0;
    if (text[i] == '+' || text[i] == '-')
        found[n++] = text[i++];
    whole = count_digits(text + i);
    memcpy(found + n, text + i, whole);
    n += whole, i += whole;
    if (text[i] == '.') {
        part = count_digits(text + i + 1);
        strcpy(found + n, point);
        n += strlen(point);
        memcpy(found + n, text + i + 1, part);
        n += part, i += part + 1;
    } else if (text[i] == '+' || text[i] == '-') {
        return 0; /* Fortran's exponent without a letter follows a point */
    }
    if (whole + part == 0)
        return 0;
    if (text[i]) { /* an exponent: e, E, d or D, or Fortran's sign alone */
        const int named = tir_upper(text[i]) == 'E' || tir_upper(text[i]) == 'D';
        const size_t sign = text[i + named] == '+' || text[i + named] == '-';
        const size_t digits = count_digits(text + i + named + sign);

        if ((!named && !sign) || digits == 0 || text[i + named + sign + digits])
            return 0;
        found[n++] = 'e';
        memcpy(found + n, text + i + named, sign + digits);
        n += sign + digits;
    }
    found[n] = 0;
    *number = strtod(found, NULL);
    return 1;
}
