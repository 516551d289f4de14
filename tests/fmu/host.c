/* A host without Python: loads FMUs, steps them turn by turn and prints their forces.
 *
 *     host LIBRARY TOKEN [LIBRARY TOKEN ...]
 *
 * The environment variable RESOURCES is the path of the resources as the standard passes it.
 * FMI is 2 or 3.  Not linked with the math library: an FMU has to bring what it needs.
 */
#ifdef _WIN32
#include <windows.h>
#define RTLD_NOW 0
#define RTLD_GLOBAL 0
#define dlopen(path, flags) ((void *) LoadLibraryA(path))
#define dlsym(handle, name) ((void *) GetProcAddress((HMODULE) (handle), name))
#define dlerror() "the library cannot be loaded"
#else
#include <dlfcn.h>
#endif
#include <stdio.h>
#include <stdlib.h>

#if FMI == 2
#include "fmi2FunctionTypes.h"
#define NAME(function) "fmi2" #function
#define TYPE(function) fmi2##function##TYPE
static void log_2(void *e, const char *i, fmi2Status s, const char *c, const char *message, ...) { puts(message); }
static fmi2CallbackFunctions callbacks = {log_2, calloc, free, NULL, NULL};
#else
#include "fmi3FunctionTypes.h"
#define NAME(function) "fmi3" #function
#define TYPE(function) fmi3##function##TYPE
static void log_3(void *e, fmi3Status s, const char *c, const char *message) { puts(message); }
#endif

enum { FX = 5, LIMIT = 8 };

typedef struct {
    void *handle, *instance;
} Loaded;

/* dlsym gives a data pointer; POSIX lets it be a function. */
#define CALL(loaded, function) ((TYPE(function) *) dlsym((loaded).handle, NAME(function)))

static void *start(Loaded loaded, const char *token)
{
#if FMI == 2
    void *instance = CALL(loaded, Instantiate)("host", fmi2CoSimulation, token, getenv("RESOURCES"),
                                                   &callbacks, 0, 0);
    CALL(loaded, SetupExperiment)(instance, 0, 0.0, 0.0, 0, 0.0);
    CALL(loaded, EnterInitializationMode)(instance);
#else
    void *instance = CALL(loaded, InstantiateCoSimulation)("host", token, getenv("RESOURCES"), 0, 0, 0, 0, NULL,
                                                                0, NULL, log_3, NULL);
    CALL(loaded, EnterInitializationMode)(instance, 0, 0.0, 0.0, 0, 0.0);
#endif
    CALL(loaded, ExitInitializationMode)(instance);
    return instance;
}

static void turn(Loaded loaded, double time, double alpha)
{
    const unsigned inputs[] = {1, 2, 3, 4}, outputs[] = {FX, FX + 1, FX + 2};
    const double given[] = {0.04, alpha, 0.02, 850.0};
    double found[3];

#if FMI == 2
    CALL(loaded, SetReal)(loaded.instance, inputs, 4, given);
    CALL(loaded, GetReal)(loaded.instance, outputs, 3, found);
    CALL(loaded, DoStep)(loaded.instance, time, 0.5, 1);
#else
    bool event, terminate, early;
    double reached;
    CALL(loaded, SetFloat64)(loaded.instance, inputs, 4, given, 4);
    CALL(loaded, GetFloat64)(loaded.instance, outputs, 3, found, 3);
    CALL(loaded, DoStep)(loaded.instance, time, 0.5, 1, &event, &terminate, &early, &reached);
#endif
    printf("%.17g %.17g %.17g\n", found[0], found[1], found[2]);
}

int main(int argc, char **argv)
{
    Loaded loaded[LIMIT];
    int i, k, n = 0;

    for (i = 1; i + 1 < argc && n < LIMIT; i += 2, n++) {
        loaded[n].handle = dlopen(argv[i], RTLD_NOW | RTLD_GLOBAL); /* each sees the others' symbols */
        if (!loaded[n].handle) {
            fprintf(stderr, "%s\n", dlerror());
            return 1;
        }
        loaded[n].instance = start(loaded[n], argv[i + 1]);
    }
    for (k = 0; k < 3; k++)
        for (i = 0; i < n; i++)
            turn(loaded[i], 0.5 * k, 0.05 * k);
    for (i = 0; i < n; i++) {
        CALL(loaded[i], Terminate)(loaded[i].instance);
        CALL(loaded[i], FreeInstance)(loaded[i].instance);
    }
    return 0;
}
