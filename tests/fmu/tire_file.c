/* Instances from mutated files of values, by paths and URIs: each is refused with a line in the log, or it steps. */
#include "fmi2Functions.h"
#include "fmi3Functions.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define LARGEST 100000

static int logged;

static void log_message(void *environment, fmi3Status status, const char *category, const char *message)
{
    (void) environment;
    (void) status;
    (void) category;
    logged += message[0] != 0;
}

static void log_message_2(void *environment, const char *name, fmi2Status status, const char *category,
                          const char *message, ...)
{
    log_message(environment, (fmi3Status) status, category, message);
    (void) name;
}

static void write_file(const char *path, const unsigned char *bytes, size_t n)
{
    FILE *file = fopen(path, "wb");

    if (!file || fwrite(bytes, 1, n, file) != n || fclose(file))
        exit(2);
}

/* Returns whether there is an instance. */
static int try_3(const char *resources)
{
    fmi3Boolean flags[3];
    fmi3Float64 reached, value;
    const fmi3ValueReference first = 8;
    fmi3Instance tire =
        fmi3InstantiateCoSimulation("tire", "{1}", resources, 0, 0, 0, 0, NULL, 0, NULL, log_message, NULL);

    if (!tire)
        return 0;
    if (fmi3EnterInitializationMode(tire, 0, 0.0, 0.0, 0, 0.0) || fmi3ExitInitializationMode(tire))
        exit(3);
    fmi3DoStep(tire, 0.0, 0.01, 0, flags, flags + 1, flags + 2, &reached);
    fmi3GetFloat64(tire, &first, 1, &value, 1);
    fmi3FreeInstance(tire);
    return 1;
}

static int try_2(const char *resources)
{
    const fmi2CallbackFunctions callbacks = {log_message_2, calloc, free, NULL, NULL};
    fmi2Component tire = fmi2Instantiate("tire", fmi2ModelExchange, "{1}", resources, &callbacks, 0, 0);

    if (tire)
        fmi2FreeInstance(tire);
    return tire != NULL;
}

int main(int argc, char *argv[])
{
    static unsigned char good[LARGEST], bytes[LARGEST];
    static char path[5000], folder[5000], uri[5000], longest[9000];
    const char *wrong[] = {"", "file:", "file:///%", "file:///%4", "file:///%zz", "file:///%00", "file://host", NULL};
    int accepted = 0, refused = 0, before, is_instance, k;
    size_t n, size, i;
    FILE *file;

    if (argc != 2)
        return 1;
    snprintf(path, sizeof path, "%s/values", argv[1]);
    file = fopen(path, "rb");
    n = file ? fread(good, 1, sizeof good, file) : 0;
    if (n == 0 || n == sizeof good || fclose(file))
        return 1;
    snprintf(folder, sizeof folder, "%s/resources of 100 %%", argv[1]);
    snprintf(path, sizeof path, "%s/tire_values.bin", folder);
    snprintf(uri, sizeof uri, "file://%s/resources%%20of%%20100%%20%%25", argv[1]);
    write_file(path, good, n);
    if (!try_3(folder) || !try_2(folder) || !try_2(uri))
        return 4;
    for (i = 0; i < sizeof wrong / sizeof *wrong; i++)
        if (try_2(wrong[i]) || try_3(wrong[i]))
            return 5;
    memset(longest, 'x', sizeof longest - 1);
    if (try_3(longest))
        return 6;
    srand(1);
    for (k = 0; k < 20000; k++) {
        memcpy(bytes, good, n);
        size = rand() % 10 ? n : (size_t) rand() % (n + 2);
        for (i = (size_t) rand() % 3; i-- > 0;)
            bytes[rand() % (rand() % 2 ? n : 400)] = (unsigned char) rand();
        write_file(path, bytes, size);
        before = logged;
        is_instance = try_3(folder);
        if (!is_instance && logged == before)
            return 7;
        accepted += is_instance;
        refused += !is_instance;
    }
    printf("%d accepted, %d refused\n", accepted, refused);
    return 0;
}
