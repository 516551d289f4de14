/* FMI 2.0: every function of the standard, each translated to a call of instance.h. */
#include "fmi2Functions.h"

#define FMI(name) fmi2##name
#define FMI_INSTANCE fmi2Component
#include "same_calls.h"

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

fmi2Status fmi2SetupExperiment(fmi2Component c, fmi2Boolean toleranceDefined, fmi2Real tolerance,
                               fmi2Real startTime, fmi2Boolean stopTimeDefined, fmi2Real stopTime)
{
    return (fmi2Status) instance_set_experiment(c, startTime, stopTimeDefined, stopTime);
}

SAME_0(EnterInitializationMode, instance_enter_initialization)

/* ---------------------------------------------------------------- values */

SAME_3(GetReal, instance_get, const fmi2ValueReference *, size_t, fmi2Real *)
SAME_3(SetReal, instance_set, const fmi2ValueReference *, size_t, const fmi2Real *)

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

SAME_1(GetFMUstate, instance_save, fmi2FMUstate *)
SAME_1(SetFMUstate, instance_restore, fmi2FMUstate)
SAME_1(FreeFMUstate, instance_drop, fmi2FMUstate *)
SAME_2(SerializedFMUstateSize, instance_serialized_size, fmi2FMUstate, size_t *)
SAME_3(SerializeFMUstate, instance_serialize, fmi2FMUstate, fmi2Byte *, size_t)
SAME_3(DeSerializeFMUstate, instance_deserialize, const fmi2Byte *, size_t, fmi2FMUstate *)

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
    EXPECT(c, value, "the status");
    *value = fmi2False;
    return fmi2OK;
}

fmi2Status fmi2GetStatus(fmi2Component c, const fmi2StatusKind s, fmi2Status *value)
{
    if (s != fmi2DoStepStatus || !c)
        UNSUPPORTED(fmi2GetStatus of this kind);
    EXPECT(c, value, "the status");
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

SAME_4(SetRealInputDerivatives, instance_set_slopes, const fmi2ValueReference *, size_t, const fmi2Integer *,
       const fmi2Real *)

fmi2Status fmi2GetRealOutputDerivatives(fmi2Component c, const fmi2ValueReference vr[], size_t nvr,
                                        const fmi2Integer order[], fmi2Real value[])
{
    UNSUPPORTED(fmi2GetRealOutputDerivatives);
}

/* ---------------------------------------------------------------- Model Exchange */

fmi2Status fmi2NewDiscreteStates(fmi2Component c, fmi2EventInfo *eventInfo)
{
    int changed = 0;
    Status status;

    EXPECT(c, eventInfo, "the event information");
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

SAME_2(GetDerivatives, instance_get_rates, fmi2Real *, size_t)
