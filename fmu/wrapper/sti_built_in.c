/* The tire for which the library was compiled.  See sti_values.h. */
#include "sti_values.h"

int sti_take_values(Call *call, Tire *tire)
{
    (void) call, (void) tire;
    return GOOD;
}

int sti_stored_values(Call *call, Tire *tire)
{
    (void) call, (void) tire;
    return GOOD;
}

double sti_width(const Call *call)
{
    (void) call;
    return TIRE_WIDTH;
}

const char *sti_title(const Call *call, char title[STI_TITLE])
{
    (void) call, (void) title;
    return TIRE_TITLE;
}
