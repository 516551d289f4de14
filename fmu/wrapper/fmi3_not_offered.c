/* The functions of FMI 3.0 that this FMU does not support: each one exists, logs an error and returns it. */
#include "instance.h"

#include "fmi3Functions.h"

/* Arguments that the standard requires and this FMU does not need. */
#if defined __GNUC__
#pragma GCC diagnostic ignored "-Wunused-parameter"
#endif

#define NOT_OFFERED(function, ...)                                     \
    fmi3Status function(__VA_ARGS__)                                   \
    {                                                                  \
        return (fmi3Status) instance_unsupported(instance, #function); \
    }
/* Accepted for no clocks. */
#define OF_CLOCKS(function, ...)                                                                                     \
    fmi3Status function(fmi3Instance instance, const fmi3ValueReference valueReferences[], size_t nValueReferences, \
                        __VA_ARGS__)                                                                                 \
    {                                                                                                                \
        return (fmi3Status) instance_lacks_type(instance, nValueReferences, "Clock");                                \
    }

/* ---------------------------------------------------------------- dependencies, structure */

NOT_OFFERED(fmi3GetNumberOfVariableDependencies, fmi3Instance instance, fmi3ValueReference valueReference,
            size_t *nDependencies)
NOT_OFFERED(fmi3GetVariableDependencies, fmi3Instance instance, fmi3ValueReference dependent,
            size_t elementIndicesOfDependent[], fmi3ValueReference independents[],
            size_t elementIndicesOfIndependents[], fmi3DependencyKind dependencyKinds[], size_t nDependencies)
NOT_OFFERED(fmi3EnterConfigurationMode, fmi3Instance instance)
NOT_OFFERED(fmi3ExitConfigurationMode, fmi3Instance instance)

/* ---------------------------------------------------------------- clocks and events */

OF_CLOCKS(fmi3GetIntervalDecimal, fmi3Float64 intervals[], fmi3IntervalQualifier qualifiers[])
OF_CLOCKS(fmi3GetIntervalFraction, fmi3UInt64 counters[], fmi3UInt64 resolutions[], fmi3IntervalQualifier qualifiers[])
OF_CLOCKS(fmi3GetShiftDecimal, fmi3Float64 shifts[])
OF_CLOCKS(fmi3GetShiftFraction, fmi3UInt64 counters[], fmi3UInt64 resolutions[])
OF_CLOCKS(fmi3SetIntervalDecimal, const fmi3Float64 intervals[])
OF_CLOCKS(fmi3SetIntervalFraction, const fmi3UInt64 counters[], const fmi3UInt64 resolutions[])
OF_CLOCKS(fmi3SetShiftDecimal, const fmi3Float64 shifts[])
OF_CLOCKS(fmi3SetShiftFraction, const fmi3UInt64 counters[], const fmi3UInt64 resolutions[])

NOT_OFFERED(fmi3EvaluateDiscreteStates, fmi3Instance instance)
NOT_OFFERED(fmi3GetOutputDerivatives, fmi3Instance instance, const fmi3ValueReference valueReferences[],
            size_t nValueReferences, const fmi3Int32 orders[], fmi3Float64 values[], size_t nValues)
NOT_OFFERED(fmi3ActivateModelPartition, fmi3Instance instance, fmi3ValueReference clockReference,
            fmi3Float64 activationTime)
