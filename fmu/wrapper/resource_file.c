/* Files in the resources of the FMU, whose path comes from the host.  See resource_file.h. */
#include "resource_file.h"

#include <string.h>

#define SCHEME "file:"
#define LONGEST_PATH 4096

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
static int find_path(const char *resources, const char *name, char path[LONGEST_PATH])
{
    const int is_uri = strncmp(resources, SCHEME, strlen(SCHEME)) == 0;
    const char *from = is_uri ? path_of_uri(resources) : resources;
    size_t n = 0;

    for (; *from; from++) {
        if (n + 2 + strlen(name) >= LONGEST_PATH)
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
    strcpy(path + n, name);
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

FILE *resource_open(const char *resources, const char *name)
{
    char path[LONGEST_PATH];
    return resources && find_path(resources, name, path) ? open_file(path) : NULL;
}
