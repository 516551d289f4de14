/* The tire from resources/tire_values.bin, which is untrusted.  See tire.h.
 *
 * The file is the structure `Contents`: little-endian, of fixed size.  `structure` identifies the variables for which
 * this binary was compiled.
 */
#include "instance.h"

#include <float.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#define FILE_NAME "tire_values.bin"
#define SCHEME "file:"
#define LONGEST_PATH 4096

static const char FORMAT[8] = "TIREFMU1";

typedef struct {
    char format[sizeof FORMAT];
    char structure[sizeof STRUCTURE - 1];
    Tire tire;
} Contents;

typedef char contents_have_no_gaps
    [sizeof(Contents) == sizeof FORMAT + sizeof STRUCTURE - 1 + TOKEN_SIZE + NOTE_SIZE + sizeof(uint64_t) +
                             (3 * N_VALUES + 2 * N_INPUTS) * sizeof(double)
         ? 1
         : -1];

/* ---------------------------------------------------------------- path */

static int digit(char c)
{
    return c >= '0' && c <= '9' ? c - '0' : c >= 'a' && c <= 'f' ? c - 'a' + 10 : c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
}

/* Where the path begins in a URI: file:///path, file://host/path or file:/path.  Windows: without the / before C:. */
static const char *path_of_uri(const char *uri)
{
    const char *path = uri + strlen(SCHEME);

    if (strncmp(path, "//", 2) == 0) {
        path += 2;
        while (*path && *path != '/')
            path++;
    }
#ifdef _WIN32
    if (path[0] == '/' && path[1] && (path[2] == ':' || path[2] == '|'))
        path++;
#endif
    return path;
}

/* Write the path of the file.  FMI 2 passes a URI, FMI 3 a path.  Returns 0 if it is too long or malformed. */
static int find_path(const char *resources, char path[LONGEST_PATH])
{
    const int is_uri = strncmp(resources, SCHEME, strlen(SCHEME)) == 0;
    const char *from = is_uri ? path_of_uri(resources) : resources;
    size_t n = 0;

    for (; *from; from++) {
        if (n + 1 + sizeof FILE_NAME >= LONGEST_PATH)
            return 0;
        if (is_uri && *from == '%') {
            if (digit(from[1]) < 0 || digit(from[2]) < 0 || digit(from[1]) + digit(from[2]) == 0)
                return 0;
            path[n++] = (char) (16 * digit(from[1]) + digit(from[2]));
            from += 2;
        } else {
            path[n++] = *from;
        }
    }
    if (n == 0)
        return 0;
    if (path[n - 1] != '/' && path[n - 1] != '\\')
        path[n++] = '/';
    memcpy(path + n, FILE_NAME, sizeof FILE_NAME);
    return 1;
}

#ifdef _WIN32
/* Convert UTF-8 to UTF-16.  Returns 0 for malformed text. */
static int widen(const char *text, wchar_t wide[LONGEST_PATH])
{
    const unsigned char *from = (const unsigned char *) text;
    size_t n = 0;

    while (*from) {
        const int more = *from < 0x80 ? 0 : *from < 0xC2 ? -1 : *from < 0xE0 ? 1 : *from < 0xF0 ? 2 : *from < 0xF5 ? 3 : -1;
        unsigned long code;
        int i;

        if (more < 0)
            return 0;
        code = more == 0 ? *from : *from & (0x3Fu >> more);
        from++;
        for (i = 0; i < more; i++, from++) {
            if ((*from & 0xC0) != 0x80)
                return 0;
            code = code << 6 | (*from & 0x3Fu);
        }
        if (code >= 0x10000) {
            wide[n++] = (wchar_t) (0xD800 + ((code - 0x10000) >> 10));
            code = 0xDC00 + ((code - 0x10000) & 0x3FF);
        }
        wide[n++] = (wchar_t) code;
    }
    wide[n] = 0;
    return 1;
}

static FILE *open_file(const char *path)
{
    wchar_t wide[LONGEST_PATH];
    return widen(path, wide) ? _wfopen(wide, L"rb") : NULL;
}
#else
static FILE *open_file(const char *path) { return fopen(path, "rb"); }
#endif

/* ---------------------------------------------------------------- contents */

/* Text of an array that ends within it.  '%' is not allowed: FMI 2's logger would take the text for a format. */
static int is_text(const char text[], size_t size)
{
    size_t i;

    for (i = 0; i < size && text[i]; i++)
        if (text[i] < ' ' || text[i] > '~' || text[i] == '%')
            return 0;
    return i < size;
}

static const char *check(const Tire *tire)
{
    size_t i;

    if (!is_text(tire->token, TOKEN_SIZE) || !is_text(tire->note, NOTE_SIZE))
        return FILE_NAME " is damaged: a text is malformed";
    if (tire->count < FIRST_EXTRA || tire->count > N_VALUES)
        return FILE_NAME " is damaged: the number of values is wrong";
    for (i = 0; i < N_VALUES; i++) {
        if (!isfinite(tire->starts[i]) || !isfinite(tire->lower[i]) || !isfinite(tire->upper[i]))
            return FILE_NAME " is damaged: a value is not finite";
        if (tire->starts[i] < tire->lower[i] || tire->starts[i] > tire->upper[i])
            return FILE_NAME " is damaged: a value is outside its limits";
    }
    for (i = 0; i < N_INPUTS; i++)
        if (!(tire->ranges[i][0] <= tire->ranges[i][1])) /* NaN too */
            return FILE_NAME " is damaged: a valid range is empty";
    return NULL;
}

const char *tire_find(const char *resources, Tire *tire)
{
    char path[LONGEST_PATH];
    Contents contents;
    FILE *file;
    size_t size;
    int more;

    if (!resources || !find_path(resources, path))
        return "the host does not pass the path of the resources, where " FILE_NAME " is";
    file = open_file(path);
    if (!file)
        return FILE_NAME " in the resources cannot be opened";
    size = fread(&contents, 1, sizeof contents, file);
    more = size == sizeof contents && fgetc(file) != EOF;
    fclose(file);
    if (size != sizeof contents || more)
        return FILE_NAME " is damaged: its size is wrong";
    if (memcmp(contents.format, FORMAT, sizeof FORMAT) != 0 ||
        memcmp(contents.structure, STRUCTURE, sizeof contents.structure) != 0)
        return FILE_NAME " is not for this binary";
    *tire = contents.tire;
    return check(tire);
}
