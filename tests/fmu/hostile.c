/* An FMU for Co-Simulation with a fault that its token selects. */

#include <signal.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define FUNCTION(name) __attribute__((visibility("default"))) int fmi2##name(void) { return 0; }

FUNCTION(GetTypesPlatform) FUNCTION(GetVersion) FUNCTION(SetDebugLogging) FUNCTION(SetupExperiment)
FUNCTION(EnterInitializationMode) FUNCTION(ExitInitializationMode) FUNCTION(Terminate) FUNCTION(Reset)
FUNCTION(GetReal) FUNCTION(GetInteger) FUNCTION(GetBoolean) FUNCTION(GetString)
FUNCTION(SetReal) FUNCTION(SetInteger) FUNCTION(SetBoolean) FUNCTION(SetString)
FUNCTION(GetFMUstate) FUNCTION(SetFMUstate) FUNCTION(FreeFMUstate) FUNCTION(SerializedFMUstateSize)
FUNCTION(SerializeFMUstate) FUNCTION(DeSerializeFMUstate) FUNCTION(GetDirectionalDerivative)
FUNCTION(SetRealInputDerivatives) FUNCTION(GetRealOutputDerivatives) FUNCTION(CancelStep) FUNCTION(GetStatus)
FUNCTION(GetRealStatus) FUNCTION(GetIntegerStatus) FUNCTION(GetBooleanStatus) FUNCTION(GetStringStatus)

typedef void (*logger_type)(void *, const char *, int, const char *, const char *, ...);
static char fault[64];
static logger_type log_message;

static void act(const char *when)
{
    if (strncmp(fault, when, strlen(when)) != 0)
        return;
    const char *what = fault + strlen(when);
    if (strcmp(what, "hang") == 0)
        for (;;)
            pause();
    if (strcmp(what, "crash") == 0)
        raise(SIGSEGV);
    if (strcmp(what, "abort") == 0)
        abort();
    if (strcmp(what, "exit") == 0)
        exit(0);
    if (strcmp(what, "print") == 0) {
        puts("printed by the FMU");
        fputs("complaint of the FMU\n", stderr);
        fflush(stdout);
    }
    if (strcmp(what, "leave") == 0) {
        int child = fork();
        while (child == 0)
            pause();
        FILE *file = fopen(getenv("HOSTILE_FILE"), "w");
        fprintf(file, "%d", child);
        fclose(file);
    }
}

__attribute__((visibility("default"))) void *fmi2Instantiate(const char *name, int type, const char *token,
                                                             const char *resources, const void *const *functions)
{
    (void)name, (void)type, (void)resources;
    strncpy(fault, token, sizeof fault - 1);
    memcpy(&log_message, functions, sizeof log_message);
    act("load ");
    return fault;
}

__attribute__((visibility("default"))) int fmi2DoStep(void)
{
    act("step ");
    if (strcmp(fault, "step refuse") == 0) {
        log_message(NULL, "hostile", 3, "error", "\033[2J a line\nand another");
        return 3;
    }
    return 0;
}

__attribute__((visibility("default"))) void fmi2FreeInstance(void)
{
    act("free ");
}
