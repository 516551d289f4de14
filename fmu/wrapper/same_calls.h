/* Functions of the standard that are functions of instance.h with the same arguments.
 *
 * Define before: FMI(name), which puts the prefix of the version in front of a name, and FMI_INSTANCE, the type of an
 * instance.  SAME_n(Function, call, types) defines a function with n arguments behind the instance.
 */
#ifndef SAME_CALLS_H
#define SAME_CALLS_H

#include "instance.h"

/* Arguments that the standard requires and this FMU does not need. */
#if defined __GNUC__
#pragma GCC diagnostic ignored "-Wunused-parameter"
#endif

typedef char discards_agree[(int) STATUS_DISCARD == (int) FMI(Discard) ? 1 : -1];
typedef char errors_agree[(int) STATUS_ERROR == (int) FMI(Error) ? 1 : -1];

#define EXPECT(c, pointer, what)                                       \
    do                                                                 \
        if (instance_expect_pointer(c, pointer, 1, what) != STATUS_OK) \
            return FMI(Error);                                         \
    while (0)

#define SAME_0(Function, call) \
    FMI(Status) FMI(Function)(FMI_INSTANCE c) { return (FMI(Status)) call(c); }
#define SAME_1(Function, call, A) \
    FMI(Status) FMI(Function)(FMI_INSTANCE c, A x1) { return (FMI(Status)) call(c, x1); }
#define SAME_2(Function, call, A, B) \
    FMI(Status) FMI(Function)(FMI_INSTANCE c, A x1, B x2) { return (FMI(Status)) call(c, x1, x2); }
#define SAME_3(Function, call, A, B, C) \
    FMI(Status) FMI(Function)(FMI_INSTANCE c, A x1, B x2, C x3) { return (FMI(Status)) call(c, x1, x2, x3); }
#define SAME_4(Function, call, A, B, C, D) \
    FMI(Status) FMI(Function)(FMI_INSTANCE c, A x1, B x2, C x3, D x4) { return (FMI(Status)) call(c, x1, x2, x3, x4); }

/* Those with equal names and arguments in both versions. */
SAME_0(ExitInitializationMode, instance_exit_initialization)
SAME_0(Terminate, instance_terminate)
SAME_0(Reset, instance_reset)
SAME_0(EnterEventMode, instance_enter_event)
SAME_0(EnterContinuousTimeMode, instance_enter_continuous)
SAME_3(SetDebugLogging, instance_choose_log, FMI(Boolean), size_t, const FMI(String) *)
SAME_2(SetContinuousStates, instance_set_states, const double *, size_t)
SAME_2(GetEventIndicators, instance_get_indicators, double *, size_t)
SAME_2(GetContinuousStates, instance_get_states, double *, size_t)
SAME_2(GetNominalsOfContinuousStates, instance_get_nominals, double *, size_t)
SAME_1(SetTime, instance_set_time, double)

FMI(Status) FMI(CompletedIntegratorStep)(FMI_INSTANCE c, FMI(Boolean) noSetFMUStatePriorToCurrentPoint,
                                         FMI(Boolean) *enterEventMode, FMI(Boolean) *terminateSimulation)
{
    EXPECT(c, enterEventMode, "the event information");
    EXPECT(c, terminateSimulation, "the event information");
    *enterEventMode = FMI(False);
    *terminateSimulation = FMI(False);
    return (FMI(Status)) instance_complete_step(c);
}

#endif
