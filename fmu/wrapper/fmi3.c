/* FMI 3.0: the supported functions, each translated to a call of instance.h. */
#include "fmi3Functions.h"

#define FMI(name) fmi3##name
#define FMI_INSTANCE fmi3Instance
#include "same_calls.h"

#include "arrays.h"

#define LACKS(type) return (fmi3Status) instance_lacks_type(instance, nValueReferences, type)

/* ---------------------------------------------------------------- instantiation */

const char *fmi3GetVersion(void) { return fmi3Version; }

static void log_message(const Instance *self, Status status, const char *category, const char *message)
{
    ((fmi3LogMessageCallback) self->logger)(self->environment, (fmi3Status) status, category, message);
}

fmi3Instance fmi3InstantiateCoSimulation(fmi3String instanceName, fmi3String instantiationToken,
                                         fmi3String resourcePath, fmi3Boolean visible, fmi3Boolean loggingOn,
                                         fmi3Boolean eventModeUsed, fmi3Boolean earlyReturnAllowed,
                                         const fmi3ValueReference requiredIntermediateVariables[],
                                         size_t nRequiredIntermediateVariables,
                                         fmi3InstanceEnvironment instanceEnvironment,
                                         fmi3LogMessageCallback logMessage,
                                         fmi3IntermediateUpdateCallback intermediateUpdate)
{
    Instance *self =
        instance_create(instanceName, instantiationToken, resourcePath, CO_SIMULATION, loggingOn, log_message,
                        (void (*)(void)) logMessage, instanceEnvironment);

    if (self && instance_use_events(self, eventModeUsed, earlyReturnAllowed) != STATUS_OK) {
        instance_free(self);
        return NULL;
    }
    return self;
}

fmi3Instance fmi3InstantiateModelExchange(fmi3String instanceName, fmi3String instantiationToken,
                                          fmi3String resourcePath, fmi3Boolean visible, fmi3Boolean loggingOn,
                                          fmi3InstanceEnvironment instanceEnvironment,
                                          fmi3LogMessageCallback logMessage)
{
    return instance_create(instanceName, instantiationToken, resourcePath, MODEL_EXCHANGE, loggingOn, log_message,
                           (void (*)(void)) logMessage, instanceEnvironment);
}

fmi3Instance fmi3InstantiateScheduledExecution(fmi3String instanceName, fmi3String instantiationToken,
                                               fmi3String resourcePath, fmi3Boolean visible,
                                               fmi3Boolean loggingOn,
                                               fmi3InstanceEnvironment instanceEnvironment,
                                               fmi3LogMessageCallback logMessage,
                                               fmi3ClockUpdateCallback clockUpdate,
                                               fmi3LockPreemptionCallback lockPreemption,
                                               fmi3UnlockPreemptionCallback unlockPreemption)
{
    if (logMessage)
        logMessage(instanceEnvironment, fmi3Error, "logStatusError", "this FMU does not support Scheduled Execution");
    return NULL;
}

void fmi3FreeInstance(fmi3Instance instance) { instance_free(instance); }

fmi3Status fmi3EnterInitializationMode(fmi3Instance instance, fmi3Boolean toleranceDefined,
                                       fmi3Float64 tolerance, fmi3Float64 startTime,
                                       fmi3Boolean stopTimeDefined, fmi3Float64 stopTime)
{
    Status status = instance_set_experiment(instance, startTime, stopTimeDefined, stopTime);

    return (fmi3Status) (status == STATUS_OK ? instance_enter_initialization(instance) : status);
}

/* ---------------------------------------------------------------- values */

fmi3Status fmi3GetFloat64(fmi3Instance instance, const fmi3ValueReference valueReferences[],
                          size_t nValueReferences, fmi3Float64 values[], size_t nValues)
{
    Scalars found;

    if (arrays_expand(instance, valueReferences, nValueReferences, nValues, &found) != STATUS_OK)
        return fmi3Error;
    return (fmi3Status) instance_get(instance, found.references, found.n, values);
}

fmi3Status fmi3SetFloat64(fmi3Instance instance, const fmi3ValueReference valueReferences[],
                          size_t nValueReferences, const fmi3Float64 values[], size_t nValues)
{
    Scalars found;

    if (arrays_expand(instance, valueReferences, nValueReferences, nValues, &found) != STATUS_OK)
        return fmi3Error;
    return (fmi3Status) instance_set(instance, found.references, found.n, values);
}

#define LACKS_TYPE(Type)                                                                                \
    fmi3Status fmi3Get##Type(fmi3Instance instance, const fmi3ValueReference valueReferences[],         \
                             size_t nValueReferences, fmi3##Type values[], size_t nValues)              \
    {                                                                                                   \
        LACKS(#Type);                                                                                   \
    }                                                                                                   \
    fmi3Status fmi3Set##Type(fmi3Instance instance, const fmi3ValueReference valueReferences[],         \
                             size_t nValueReferences, const fmi3##Type values[], size_t nValues)        \
    {                                                                                                   \
        LACKS(#Type);                                                                                   \
    }

LACKS_TYPE(Float32)
LACKS_TYPE(Int8)
LACKS_TYPE(UInt8)
LACKS_TYPE(Int16)
LACKS_TYPE(UInt16)
LACKS_TYPE(Int32)
LACKS_TYPE(UInt32)
LACKS_TYPE(Int64)
LACKS_TYPE(UInt64)
LACKS_TYPE(Boolean)
LACKS_TYPE(String)

fmi3Status fmi3GetBinary(fmi3Instance instance, const fmi3ValueReference valueReferences[],
                         size_t nValueReferences, size_t valueSizes[], fmi3Binary values[], size_t nValues)
{
    LACKS("Binary");
}

fmi3Status fmi3SetBinary(fmi3Instance instance, const fmi3ValueReference valueReferences[],
                         size_t nValueReferences, const size_t valueSizes[], const fmi3Binary values[],
                         size_t nValues)
{
    LACKS("Binary");
}

fmi3Status fmi3GetClock(fmi3Instance instance, const fmi3ValueReference valueReferences[],
                        size_t nValueReferences, fmi3Clock values[])
{
    LACKS("Clock");
}

fmi3Status fmi3SetClock(fmi3Instance instance, const fmi3ValueReference valueReferences[],
                        size_t nValueReferences, const fmi3Clock values[])
{
    LACKS("Clock");
}

fmi3Status fmi3GetDirectionalDerivative(fmi3Instance instance, const fmi3ValueReference unknowns[],
                                        size_t nUnknowns, const fmi3ValueReference knowns[], size_t nKnowns,
                                        const fmi3Float64 seed[], size_t nSeed, fmi3Float64 sensitivity[],
                                        size_t nSensitivity)
{
    Scalars of, by;

    if (arrays_expand(instance, unknowns, nUnknowns, nSensitivity, &of) != STATUS_OK ||
        arrays_expand(instance, knowns, nKnowns, nSeed, &by) != STATUS_OK)
        return fmi3Error;
    return (fmi3Status) instance_derivative(instance, of.references, of.n, by.references, by.n, seed, sensitivity);
}

fmi3Status fmi3GetAdjointDerivative(fmi3Instance instance, const fmi3ValueReference unknowns[], size_t nUnknowns,
                                    const fmi3ValueReference knowns[], size_t nKnowns, const fmi3Float64 seed[],
                                    size_t nSeed, fmi3Float64 sensitivity[], size_t nSensitivity)
{
    Scalars of, by;

    if (arrays_expand(instance, unknowns, nUnknowns, nSeed, &of) != STATUS_OK ||
        arrays_expand(instance, knowns, nKnowns, nSensitivity, &by) != STATUS_OK)
        return fmi3Error;
    return (fmi3Status) instance_adjoint(instance, of.references, of.n, by.references, by.n, seed, sensitivity);
}

/* ---------------------------------------------------------------- saved states */

SAME_1(GetFMUState, instance_save, fmi3FMUState *)
SAME_1(SetFMUState, instance_restore, fmi3FMUState)
SAME_1(FreeFMUState, instance_drop, fmi3FMUState *)
SAME_2(SerializedFMUStateSize, instance_serialized_size, fmi3FMUState, size_t *)
SAME_3(SerializeFMUState, instance_serialize, fmi3FMUState, fmi3Byte *, size_t)
SAME_3(DeserializeFMUState, instance_deserialize, const fmi3Byte *, size_t, fmi3FMUState *)

/* ---------------------------------------------------------------- Co-Simulation */

fmi3Status fmi3DoStep(fmi3Instance instance, fmi3Float64 currentCommunicationPoint,
                      fmi3Float64 communicationStepSize, fmi3Boolean noSetFMUStatePriorToCurrentPoint,
                      fmi3Boolean *eventHandlingNeeded, fmi3Boolean *terminateSimulation,
                      fmi3Boolean *earlyReturn, fmi3Float64 *lastSuccessfulTime)
{
    const Status status = instance_step(instance, currentCommunicationPoint, communicationStepSize);
    const Instance *self = instance;
    const int done = self && status == STATUS_OK;

    if (eventHandlingNeeded)
        *eventHandlingNeeded = done && self->has_event_mode && instance_had_event(self);
    if (terminateSimulation)
        *terminateSimulation = fmi3False;
    if (earlyReturn)
        *earlyReturn = done && self->state.values[TIME] < currentCommunicationPoint + communicationStepSize;
    if (lastSuccessfulTime && self)
        *lastSuccessfulTime = self->state.values[TIME];
    return (fmi3Status) status;
}

/* ---------------------------------------------------------------- events */

SAME_0(EnterStepMode, instance_enter_stepping)

fmi3Status fmi3UpdateDiscreteStates(fmi3Instance instance, fmi3Boolean *discreteStatesNeedUpdate,
                                    fmi3Boolean *terminateSimulation,
                                    fmi3Boolean *nominalsOfContinuousStatesChanged,
                                    fmi3Boolean *valuesOfContinuousStatesChanged,
                                    fmi3Boolean *nextEventTimeDefined, fmi3Float64 *nextEventTime)
{
    int changed = 0;
    Status status;

    EXPECT(instance, discreteStatesNeedUpdate, "the event information");
    EXPECT(instance, terminateSimulation, "the event information");
    EXPECT(instance, nominalsOfContinuousStatesChanged, "the event information");
    EXPECT(instance, valuesOfContinuousStatesChanged, "the event information");
    EXPECT(instance, nextEventTimeDefined, "the event information");
    EXPECT(instance, nextEventTime, "the event information");
    status = instance_update_discrete(instance, &changed);
    if (status != STATUS_OK)
        return (fmi3Status) status;
    *discreteStatesNeedUpdate = fmi3False;
    *terminateSimulation = fmi3False;
    *nominalsOfContinuousStatesChanged = fmi3False;
    *valuesOfContinuousStatesChanged = changed != 0;
    *nextEventTimeDefined = fmi3False;
    *nextEventTime = 0.0;
    return fmi3OK;
}

/* ---------------------------------------------------------------- Model Exchange */

SAME_2(GetContinuousStateDerivatives, instance_get_rates, fmi3Float64 *, size_t)

fmi3Status fmi3GetNumberOfEventIndicators(fmi3Instance instance, size_t *nEventIndicators)
{
    EXPECT(instance, nEventIndicators, "the number");
    *nEventIndicators = N_INDICATORS;
    return fmi3OK;
}

fmi3Status fmi3GetNumberOfContinuousStates(fmi3Instance instance, size_t *nContinuousStates)
{
    EXPECT(instance, nContinuousStates, "the number");
    *nContinuousStates = N_CONTINUOUS;
    return fmi3OK;
}
