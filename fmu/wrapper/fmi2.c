/* FMI 2.0: every function of the standard, each translated to a call of instance.h. */
#include "instance.h"

#include "fmi2Functions.h"

/* Arguments that the standard requires and this FMU does not need. */
#if defined __GNUC__
#pragma GCC diagnostic ignored "-Wunused-parameter"
#endif

typedef char discards_agree[(int) STATUS_DISCARD == (int) fmi2Discard ? 1 : -1];
typedef char errors_agree[(int) STATUS_ERROR == (int) fmi2Error ? 1 : -1];

#define EXPECT(pointer, what)                                          \
    do                                                                 \
        if (instance_expect_pointer(c, pointer, 1, what) != STATUS_OK) \
            return fmi2Error;                                          \
    while (0)
#define UNSUPPORTED(function) return (fmi2Status) instance_unsupported(c, #function)

/* ---------------------------------------------------------------- instantiation */

const char *fmi2GetTypesPlatform(void) { return fmi2TypesPlatform; }

const char *fmi2GetVersion(void) { return fmi2Version; }

/* FMI 2's logger is variadic; the message is already formatted and contains no '%'. */
static void log_message(const Instance *self, Status status, const char *category, const char *message)
{
    ((fmi2CallbackLogger) self->logger)(self->environment, self->name, (fmi2Status) status, category, message);
}

fmi2Component fmi2Instantiate(fmi2String instanceName, fmi2Type fmuType, fmi2String fmuGUID,
                              fmi2String fmuResourceLocation, const fmi2CallbackFunctions *functions,
                              fmi2Boolean visible, fmi2Boolean loggingOn)
{
    const Kind kind = fmuType == fmi2ModelExchange ? MODEL_EXCHANGE : CO_SIMULATION;

    return instance_create(instanceName, fmuGUID, fmuResourceLocation, kind, loggingOn, log_message,
                           functions ? (void (*)(void)) functions->logger : NULL,
                           functions ? functions->componentEnvironment : NULL);
}

void fmi2FreeInstance(fmi2Component c) { instance_free(c); }

fmi2Status fmi2SetDebugLogging(fmi2Component c, fmi2Boolean loggingOn, size_t nCategories,
                               const fmi2String categories[])
{
    return (fmi2Status) instance_choose_log(c, loggingOn, nCategories, categories);
}

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean toleranceDefined, fmi2Real tolerance,
                               fmi2Real startTime, fmi2Boolean stopTimeDefined, fmi2Real stopTime)
{
    return (fmi2Status) instance_set_experiment(c, startTime, stopTimeDefined, stopTime);
}

fmi2Status fmi2EnterInitializationMode(fmi2Component c) { return (fmi2Status) instance_enter_initialization(c); }

fmi2Status fmi2ExitInitializationMode(fmi2Component c) { return (fmi2Status) instance_exit_initialization(c); }

fmi2Status fmi2Terminate(fmi2Component c) { return (fmi2Status) instance_terminate(c); }

fmi2Status fmi2Reset(fmi2Component c) { return (fmi2Status) instance_reset(c); }

/* ---------------------------------------------------------------- values */

fmi2Status fmi2GetReal(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2Real value[])
{
    return (fmi2Status) instance_get(c, vr, nvr, value);
}

fmi2Status fmi2SetReal(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, const fmi2Real value[])
{
    return (fmi2Status) instance_set(c, vr, nvr, value);
}

#define LACKS_TYPE(Type)                                                                                      \
    fmi2Status fmi2Get##Type(fmi2Component c, const fmi2ValueReference vr[], size_t nvr, fmi2##Type value[]) \
    {                                                                                                         \
        return (fmi2Status) instance_lacks_type(c, nvr, #Type);                                              \
    }                                                                                                         \
    fmi2Status fmi2Set##Type(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,                     \
                             const fmi2##Type value[])                                                        \
    {                                                                                                         \
        return (fmi2Status) instance_lacks_type(c, nvr, #Type);                                              \
    }

LACKS_TYPE(Integer)
LACKS_TYPE(Boolean)
LACKS_TYPE(String)

fmi2Status fmi2GetDirectionalDerivative(fmi2Component c, const fmi2ValueReference vUnknown_ref[],
                                        size_t nUnknown, const fmi2ValueReference vKnown_ref[], size_t nKnown,
                                        const fmi2Real dvKnown[], fmi2Real dvUnknown[])
{
    return (fmi2Status) instance_derivative(c, vUnknown_ref, nUnknown, vKnown_ref, nKnown, dvKnown, dvUnknown);
}

/* ---------------------------------------------------------------- saved states */

fmi2Status fmi2GetFMUstate(fmi2Component c, fmi2FMUstate *FMUstate)
{
    return (fmi2Status) instance_save(c, FMUstate);
}

fmi2Status fmi2SetFMUstate(fmi2Component c, fmi2FMUstate FMUstate)
{
    return (fmi2Status) instance_restore(c, FMUstate);
}

fmi2Status fmi2FreeFMUstate(fmi2Component c, fmi2FMUstate *FMUstate)
{
    return (fmi2Status) instance_drop(c, FMUstate);
}

fmi2Status fmi2SerializedFMUstateSize(fmi2Component c, fmi2FMUstate FMUstate, size_t *size)
{
    return (fmi2Status) instance_serialized_size(c, FMUstate, size);
}

fmi2Status fmi2SerializeFMUstate(fmi2Component c, fmi2FMUstate FMUstate, fmi2Byte serializedState[], size_t size)
{
    return (fmi2Status) instance_serialize(c, FMUstate, serializedState, size);
}

fmi2Status fmi2DeSerializeFMUstate(fmi2Component c, const fmi2Byte serializedState[], size_t size,
                                   fmi2FMUstate *FMUstate)
{
    return (fmi2Status) instance_deserialize(c, serializedState, size, FMUstate);
}

/* ---------------------------------------------------------------- Co-Simulation */

fmi2Status fmi2DoStep(fmi2Component c, fmi2Real currentCommunicationPoint, fmi2Real communicationStepSize,
                      fmi2Boolean noSetFMUStatePriorToCurrentPoint)
{
    return (fmi2Status) instance_step(c, currentCommunicationPoint, communicationStepSize);
}

/* Steps are never pending and always complete. */
fmi2Status fmi2GetRealStatus(fmi2Component c, const fmi2StatusKind s, fmi2Real *value)
{
    static const unsigned time = TIME;

    if (s != fmi2LastSuccessfulTime)
        UNSUPPORTED(fmi2GetRealStatus of this kind);
    return (fmi2Status) instance_get(c, &time, 1, value);
}

fmi2Status fmi2GetBooleanStatus(fmi2Component c, const fmi2StatusKind s, fmi2Boolean *value)
{
    if (s != fmi2Terminated || !c)
        UNSUPPORTED(fmi2GetBooleanStatus of this kind);
    EXPECT(value, "the status");
    *value = fmi2False;
    return fmi2OK;
}

fmi2Status fmi2GetStatus(fmi2Component c, const fmi2StatusKind s, fmi2Status *value)
{
    if (s != fmi2DoStepStatus || !c)
        UNSUPPORTED(fmi2GetStatus of this kind);
    EXPECT(value, "the status");
    *value = fmi2OK;
    return fmi2OK;
}

fmi2Status fmi2GetIntegerStatus(fmi2Component c, const fmi2StatusKind s, fmi2Integer *value)
{
    UNSUPPORTED(fmi2GetIntegerStatus);
}

fmi2Status fmi2GetStringStatus(fmi2Component c, const fmi2StatusKind s, fmi2String *value)
{
    UNSUPPORTED(fmi2GetStringStatus);
}

fmi2Status fmi2CancelStep(fmi2Component c) { UNSUPPORTED(fmi2CancelStep); }

fmi2Status fmi2SetRealInputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                                       const fmi2Integer order[], const fmi2Real value[])
{
    return (fmi2Status) instance_set_slopes(c, vr, nvr, order, value);
}

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                                        const fmi2Integer order[], fmi2Real value[])
{
    UNSUPPORTED(fmi2GetRealOutputDerivatives);
}

/* ---------------------------------------------------------------- Model Exchange */

fmi2Status fmi2EnterEventMode(fmi2Component c) { return (fmi2Status) instance_enter_event(c); }

fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo *eventInfo)
{
    int changed = 0;
    Status status;

    EXPECT(eventInfo, "the event information");
    status = instance_update_discrete(c, &changed);
    if (status != STATUS_OK)
        return (fmi2Status) status;
    eventInfo->newDiscreteStatesNeeded = fmi2False;
    eventInfo->terminateSimulation = fmi2False;
    eventInfo->nominalsOfContinuousStatesChanged = fmi2False;
    eventInfo->valuesOfContinuousStatesChanged = changed ? fmi2True : fmi2False;
    eventInfo->nextEventTimeDefined = fmi2False;
    eventInfo->nextEventTime = 0.0;
    return fmi2OK;
}

fmi2Status fmi2EnterContinuousTimeMode(fmi2Component c) { return (fmi2Status) instance_enter_continuous(c); }

fmi2Status fmi2CompletedIntegratorStep(fmi2Component c, fmi2Boolean noSetFMUStatePriorToCurrentPoint,
                                       fmi2Boolean *enterEventMode, fmi2Boolean *terminateSimulation)
{
    EXPECT(enterEventMode, "the event information");
    EXPECT(terminateSimulation, "the event information");
    *enterEventMode = fmi2False;
    *terminateSimulation = fmi2False;
    return (fmi2Status) instance_complete_step(c);
}

fmi2Status fmi2SetTime(fmi2Component c, fmi2Real time) { return (fmi2Status) instance_set_time(c, time); }

fmi2Status fmi2SetContinuousStates(fmi2Component c, const fmi2Real x[], size_t nx)
{
    return (fmi2Status) instance_set_states(c, x, nx);
}

fmi2Status fmi2GetDerivatives(fmi2Component c, fmi2Real derivatives[], size_t nx)
{
    return (fmi2Status) instance_get_rates(c, derivatives, nx);
}

fmi2Status fmi2GetEventIndicators(fmi2Component c, fmi2Real eventIndicators[], size_t ni)
{
    return (fmi2Status) instance_get_indicators(c, eventIndicators, ni);
}

fmi2Status fmi2GetContinuousStates(fmi2Component c, fmi2Real x[], size_t nx)
{
    return (fmi2Status) instance_get_states(c, x, nx);
}

fmi2Status fmi2GetNominalsOfContinuousStates(fmi2Component c, fmi2Real x_nominal[], size_t nx)
{
    return (fmi2Status) instance_get_nominals(c, x_nominal, nx);
}
