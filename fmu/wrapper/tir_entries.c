/* The entries of a property file that concern a tire.  See tir_entries.h. */
#include "tir_entries.h"

#include <math.h>
#include <stdarg.h>
#include <string.h>

#define COUNT(table) (sizeof(table) / sizeof *(table))

/* A spelling of a key. */
typedef struct {
    const char *name, *section;
    signed char powers[N_UNITS]; /* of the unit of its value */
    int target;
    int is_alias; /* the target has a name that counts first */
    int not_zero; /* 0 means that the value is unknown */
} Key;

typedef struct {
    const char *name;
    int unit;
    double factor;
} Spelling;

static const Key KEYS[TIR_N_KEYS] = TIR_KEYS;
static const Spelling SPELLINGS[] = TIR_SPELLINGS;
static const char *const UNIT_NAMES[N_UNITS] = TIR_UNIT_NAMES;
static const char *const IDLE_UNITS[] = TIR_IDLE_UNITS;
static const char *const SECTIONS[] = TIR_SECTIONS;
static const char *const OWN_SECTIONS[] = TIR_OWN_SECTIONS; /* without values of coefficients */
static const char *const EFFECTS[] = TIR_EFFECT_NAMES;
static const char *const FORMATS[] = TIR_FORMATS;
static const double FITTYPS[] = TIR_FITTYPS;

typedef char effects_fit[COUNT(EFFECTS) <= MOST_EFFECTS ? 1 : -1];

int tir_refuse(Reading *reading, const char *format, ...)
{
    va_list arguments;
    char *letter;

    va_start(arguments, format);
    vsnprintf(reading->problem, reading->size, format, arguments);
    va_end(arguments);
    for (letter = reading->problem; *letter; letter++)
        if (*letter < ' ' || *letter > '~')
            *letter = '?'; /* the text of a file is not the host's */
    return 0;
}

static int is_in(const char word[], const char *const words[], size_t n)
{
    size_t i;

    for (i = 0; i < n; i++)
        if (strcmp(word, words[i]) == 0)
            return 1;
    return 0;
}

static int is_own(const char section[]) { return strncmp(section, "TIREFMU", 7) == 0; }

/* ---------------------------------------------------------------- units */

/* Spellings differ in case, blanks, and these letters. */
static void fold(const char text[], char folded[TIR_WORD], const char *dropped)
{
    size_t n = 0;

    for (; *text && n + 1 < TIR_WORD; text++)
        if (!strchr(dropped, *text))
            folded[n++] = tir_upper(*text);
    folded[n] = 0;
}

static const Spelling *find_spelling(int unit, const char value[])
{
    char text[TIR_WORD], folded[TIR_WORD];
    size_t i;

    tir_unquote(value, text, sizeof text);
    fold(text, folded, " \t_.-");
    for (i = 0; i < COUNT(SPELLINGS); i++)
        if (SPELLINGS[i].unit == unit && strcmp(SPELLINGS[i].name, folded) == 0)
            return &SPELLINGS[i];
    return NULL;
}

/* [UNITS] counts before a unit in another section. */
static int take_unit(Reading *reading, const TirText *text)
{
    const int declares = strcmp(text->section, "UNITS") == 0;
    const Spelling *spelling;
    int unit;

    for (unit = 0; unit < N_UNITS && strcmp(UNIT_NAMES[unit], text->key) != 0;)
        unit++;
    if (unit == N_UNITS) {
        if (declares && !is_in(text->key, IDLE_UNITS, COUNT(IDLE_UNITS)))
            return tir_refuse(reading, "line %lu: unknown key %s in [UNITS]", text->line, text->key);
        return 1;
    }
    spelling = find_spelling(unit, text->value);
    if (!spelling && declares)
        return tir_refuse(reading, "line %lu: the unit %.40s of %s is unknown", text->line, text->value, text->key);
    if (spelling && !is_own(text->section) && (declares || !reading->unit_given[unit])) {
        reading->factors[unit] = spelling->factor;
        reading->unit_given[unit] = (char) declares;
    }
    return 1;
}

static double factor_of(const Reading *reading, const Key *key)
{
    double factor = 1.0;
    int unit, i;

    for (unit = 0; unit < N_UNITS; unit++)
        for (i = 0; i < key->powers[unit] || i < -key->powers[unit]; i++)
            factor = key->powers[unit] > 0 ? factor * reading->factors[unit] : factor / reading->factors[unit];
    return factor;
}

/* ---------------------------------------------------------------- entries */

/* Cut the next name off a list, or return NULL. */
static char *next_name(char **list)
{
    char *name;

    *list += strspn(*list, ", \t");
    name = *list;
    *list += strcspn(*list, ", \t");
    if (**list)
        *(*list)++ = 0;
    return *name ? name : NULL;
}

static int take_effects(Reading *reading, const TirText *text)
{
    char list[TIR_LINE], *rest = list, *name;
    size_t i;

    tir_unquote(text->value, list, sizeof list);
    reading->has_effects = 1;
    memset(reading->has, 0, sizeof reading->has);
    while ((name = next_name(&rest)) != NULL) {
        for (i = 0; i < COUNT(EFFECTS) && strcmp(EFFECTS[i], name) != 0;)
            i++;
        if (i == COUNT(EFFECTS))
            return tir_refuse(reading, "line %lu: this library has no effect %.60s: export a library of this tire",
                          text->line, name);
        reading->has[i] = 1;
    }
    return 1;
}

static int find_coefficient(const char name[])
{
    size_t i;

    for (i = 0; i < COUNT(KEYS); i++)
        if (!KEYS[i].is_alias && KEYS[i].target < N_COEFFICIENTS && strcmp(KEYS[i].name, name) == 0)
            return KEYS[i].target;
    return -1;
}

/* A file of tirefmu lists the coefficients that were not given. */
static void take_assumed(Reading *reading, const TirText *text)
{
    char list[TIR_LINE], *rest = list, *name;

    tir_unquote(text->value, list, sizeof list);
    while ((name = next_name(&rest)) != NULL)
        if (find_coefficient(name) >= 0)
            reading->assumed[find_coefficient(name)] = 1;
}

/* Of several values, the last one in the key's own section, else the last one. */
static int take_value(Reading *reading, const TirText *text)
{
    size_t i;
    int own;

    for (i = 0; i < COUNT(KEYS) && strcmp(KEYS[i].name, text->key) != 0;)
        i++;
    if (i == COUNT(KEYS))
        return 1;
    own = strcmp(KEYS[i].section, text->section) == 0;
    if (reading->own_section[i] && !own)
        return 1;
    reading->own_section[i] = (char) own;
    reading->given[i] = *text->value != 0;
    if (reading->given[i] && !tir_number(text->value, &reading->values[i]))
        return tir_refuse(reading, "line %lu: %s = %.40s is not a number", text->line, text->key, text->value);
    return 1;
}

static int take_entry(Reading *reading, const TirText *text)
{
    const int rank = strcmp(text->section, "MODEL") == 0 ? 2 : 1;

    if (strcmp(text->section, "TIREFMU_ADDED") == 0)
        return tir_refuse(reading, "line %lu: this library has no effect %.60s: export a library of this tire", text->line,
                      text->key);
    if (text->cut)
        return !is_in(text->section, OWN_SECTIONS, COUNT(OWN_SECTIONS)) || strcmp(text->section, "TIREFMU") == 0
                   ? tir_refuse(reading, "line %lu is too long", text->line)
                   : 1;
    if (strcmp(text->section, "TIREFMU") == 0) {
        if (strcmp(text->key, "TIREFMU_MODEL") == 0)
            tir_unquote(text->value, reading->model, sizeof reading->model);
        return strcmp(text->key, "EFFECTS") == 0 ? take_effects(reading, text) : 1;
    }
    if (strcmp(text->section, "TIREFMU_ASSUMED") == 0)
        take_assumed(reading, text);
    if (is_in(text->section, OWN_SECTIONS, COUNT(OWN_SECTIONS)))
        return 1;
    if (strcmp(text->key, "FITTYP") == 0 && rank >= reading->fittyp_given && *text->value) {
        reading->fittyp_given = rank;
        if (!tir_number(text->value, &reading->fittyp))
            return tir_refuse(reading, "line %lu: FITTYP = %.40s is not a number", text->line, text->value);
    } else if (strcmp(text->key, "PROPERTY_FILE_FORMAT") == 0 && rank >= reading->format_given) {
        reading->format_given = rank;
        tir_unquote(text->value, reading->format, sizeof reading->format);
    }
    return take_unit(reading, text) && (strcmp(text->section, "UNITS") == 0 || take_value(reading, text));
}

static int take_entries(Reading *reading, TirText *text)
{
    TirKind kind;

    while ((kind = tir_next(text)) == TIR_ENTRY || kind == TIR_ROW) {
        if (kind == TIR_ROW && !text->in_table && is_in(text->section, SECTIONS, COUNT(SECTIONS)))
            return tir_refuse(reading, "line %lu: %.40s in [%s] is not KEY = value", text->line, text->value, text->section);
        if (kind == TIR_ENTRY && !take_entry(reading, text))
            return 0;
    }
    return kind == TIR_END ? 1 : tir_refuse(reading, "line %lu: %s", text->line, text->problem ? text->problem : "unreadable");
}

/* ---------------------------------------------------------------- model and values */

static int check_model(Reading *reading)
{
    char folded[TIR_WORD];
    size_t i;

    if (*reading->model)
        return strcmp(reading->model, TIR_MODEL) == 0
                   ? 1
                   : tir_refuse(reading, "the tire has the model %s, this library %s", reading->model, TIR_MODEL);
    if (reading->fittyp_given) {
        for (i = 0; i < COUNT(FITTYPS); i++)
            if (reading->fittyp == FITTYPS[i])
                return 1;
        return tir_refuse(reading, "FITTYP %g is not the model of this library, %s", reading->fittyp, TIR_MODEL);
    }
    fold(reading->format, folded, " _.-");
    if (*folded && is_in(folded, FORMATS, COUNT(FORMATS)))
        return 1;
    if (*folded)
        return tir_refuse(reading, "without FITTYP, the format %s does not state the model %s", reading->format, TIR_MODEL);
    return tir_refuse(reading, "the file states no FITTYP and no PROPERTY_FILE_FORMAT");
}

static int scale_values(Reading *reading)
{
    size_t i;
    double value;

    for (i = 0; i < COUNT(KEYS); i++) {
        const Key *key = &KEYS[i];

        if (!reading->given[i] || (key->is_alias && reading->known[key->target]))
            continue;
        value = reading->values[i] * factor_of(reading, key);
        if (!isfinite(value))
            return tir_refuse(reading, "%s is too large", key->name);
        if (value == 0.0 && key->not_zero)
            continue;
        reading->found[key->target] = value;
        reading->known[key->target] = 1;
    }
    return 1;
}

int tir_read_entries(Reading *reading, const char path[])
{
    TirText text;
    int i, good;

    memset(&text, 0, sizeof text);
    for (i = 0; i < N_UNITS; i++)
        reading->factors[i] = 1.0;
    text.file = fopen(path, "rb");
    if (!text.file)
        return tir_refuse(reading, "the file cannot be opened");
    good = take_entries(reading, &text);
    fclose(text.file);
    return good && check_model(reading) && scale_values(reading);
}
