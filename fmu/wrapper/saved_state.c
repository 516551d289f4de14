/* Saving, restoring and serializing an instance's state.  See instance.h. */
#include "instance.h"

#include "outputs.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

Status instance_save(Instance *self, void **slot)
{
    State *saved;

    if (!self || !slot)
        return instance_refuse(self, STATUS_ERROR, "the pointer for the saved state is NULL");
    saved = *slot ? *slot : malloc(sizeof *saved);
    if (!saved)
        return instance_refuse(self, STATUS_ERROR, "no memory for the state");
    state_compute_extras(&self->state); /* equal states have equal bytes, whether the host has read outputs or not */
    memcpy(saved, &self->state, sizeof *saved);
    *slot = saved;
    return STATUS_OK;
}

Status instance_restore(Instance *self, const void *saved)
{
    if (!self || !saved)
        return instance_refuse(self, STATUS_ERROR, "there is no state to restore");
    if (((const State *) saved)->kind != self->state.kind)
        return instance_refuse(self, STATUS_ERROR, "the saved state is of the other interface type");
    memcpy(&self->state, saved, sizeof self->state);
    return STATUS_OK;
}

Status instance_drop(const Instance *self, void **slot)
{
    if (!self)
        return STATUS_ERROR;
    if (slot) {
        free(*slot);
        *slot = NULL;
    }
    return STATUS_OK;
}

Status instance_serialized_size(Instance *self, const void *saved, size_t *size)
{
    if (!self || !saved || !size)
        return instance_refuse(self, STATUS_ERROR, "there is no state to serialize");
    *size = sizeof(State);
    return STATUS_OK;
}

Status instance_serialize(Instance *self, const void *saved, void *bytes, size_t size)
{
    if (!self || !saved || !bytes || size < sizeof(State))
        return instance_refuse(self, STATUS_ERROR, "a state takes %lu bytes", (unsigned long) sizeof(State));
    memcpy(bytes, saved, sizeof(State));
    return STATUS_OK;
}

/* The bytes are untrusted: accept only what a saved state can contain. */
static int is_state(const Instance *self, const State *state)
{
    size_t i;

    if (memcmp(state->token, self->tire.token, sizeof state->token) != 0 || state->mode < INSTANTIATED ||
        state->mode > TERMINATED || (state->kind != CO_SIMULATION && state->kind != MODEL_EXCHANGE) ||
        state->stop_time != state->stop_time || !isfinite(state->continuous.distance))
        return 0;
    for (i = 0; i < FIRST_STATE; i++)
        if ((i < FIRST_COMPUTED || i >= FIRST_PARAMETER) &&
            !instance_allows(self, (unsigned) i, state->values[i]))
            return 0;
#if SPIN
    if (state->brake_sense < -1 || state->brake_sense > 1)
        return 0;
#endif
    for (i = 0; i < N_HOST_INPUTS; i++)
        if (!isfinite(state->slopes[i]))
            return 0;
    for (i = 0; i < N_LAGGING; i++)
        if (!isfinite(state->continuous.lagging[i]))
            return 0;
#if N_MEMORY > 0
    for (i = 0; i < N_MEMORY; i++)
        if (!isfinite(state->continuous.memory[i]))
            return 0;
#endif
    return 1;
}

Status instance_deserialize(Instance *self, const void *bytes, size_t size, void **slot)
{
    State state;

    if (!self || !bytes || !slot || size != sizeof state)
        return instance_refuse(self, STATUS_ERROR, "a state takes %lu bytes", (unsigned long) sizeof state);
    memcpy(&state, bytes, sizeof state);
    if (!is_state(self, &state))
        return instance_refuse(self, STATUS_ERROR, "the bytes are not a serialized state of this FMU");
    if (!*slot && !(*slot = malloc(sizeof state)))
        return instance_refuse(self, STATUS_ERROR, "no memory for the state");
    state_changed(&state); /* computed values are not trusted but computed again */
    state_compute_extras(&state);
    memcpy(*slot, &state, sizeof state);
    return STATUS_OK;
}
