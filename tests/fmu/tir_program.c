/* Reads property files as a library with the Standard Tyre Interface does.
 *
 * The names of files are lines of the input.  Prints, for each, a line with width, parameters and ranges, or with a
 * question mark and the problem.
 */
#include <stdio.h>
#include <string.h>

#include "tir_tire.h"
#include "tire_values.h"

#include <float.h>

int main(void)
{
    static const double starts[] = START_VALUES;
    static char name[1024], problem[256];
    static TirTire tire;
    size_t i;

    while (fgets(name, sizeof name, stdin)) {
        name[strcspn(name, "\n")] = 0;
        memcpy(tire.parameters, starts + FIRST_PARAMETER, sizeof tire.parameters);
        if (!tir_read(name, &tire, problem, sizeof problem)) {
            printf("?%s\n", problem);
            continue;
        }
        printf("%.17g", tire.width);
        for (i = 0; i < N_HOST_PARAMETERS; i++)
            printf(" %.17g", tire.parameters[i]);
        for (i = 0; i < N_INPUTS; i++)
            printf(" %.17g %.17g", tire.ranges[i][0], tire.ranges[i][1]);
        puts("");
    }
    return 0;
}
