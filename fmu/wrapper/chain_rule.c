/* Derivatives of the model by the chain rule, one operation after the other.  See chain_rule.h.
 *
 * Operations whose operands have zero tangents are skipped.  A branch that is not taken, or the root of a constant 0,
 * therefore contributes 0 and not NaN.
 */
#include "chain_rule.h"

#include <math.h>
#include <string.h>

enum { CODE, FIRST_OPERAND, N_OPERANDS = 3, N_COLUMNS };

static const double constants[N_CONSTANTS] = CONSTANTS;
static const unsigned short force_slots[] = FORCE_SLOTS;
static const unsigned short quantity_slots[] = QUANTITY_SLOTS;
/* Unused operands are 0; the partial derivatives by them are 0 too. */
static const unsigned short operations[N_OPERATIONS][N_COLUMNS] = OPERATIONS;

enum { FIRST_RESULT = N_LEAVES + N_CONSTANTS };

unsigned chain_force(unsigned i) { return force_slots[i]; }

unsigned chain_quantity(unsigned i) { return quantity_slots[i]; }

/* NaN for NaN. */
static double sign(double x) { return x > 0.0 ? 1.0 : x < 0.0 ? -1.0 : x; }

static double result(unsigned code, double x, double y, double z)
{
    switch (code) {
    case ADD: return x + y;
    case SUBTRACT: return x - y;
    case MULTIPLY: return x * y;
    case DIVIDE: return x / y;
    case POWER: return pow(x, y);
    case LESS: return x < y;
    case AT_MOST: return x <= y;
    case EQUAL: return x == y;
    case AND: return x != 0.0 && y != 0.0;
    case OR: return x != 0.0 || y != 0.0;
    case CHOOSE: return x != 0.0 ? y : z;
    case ROOT: return sqrt(x);
    case SIN: return sin(x);
    case COS: return cos(x);
    case TAN: return tan(x);
    case ATAN: return atan(x);
    case ACOS: return acos(x);
    case EXP: return exp(x);
    case LOG: return log(x);
    case SGN: return sign(x);
    case SGN1: return x == 0.0 ? 1.0 : sign(x);
    default: return fabs(x); /* ABSOLUTE */
    }
}

void chain_values(const double inputs[N_INPUTS], const double parameters[N_PARAMETERS], double turning,
                  double values[N_SLOTS])
{
    size_t i;

    memcpy(values, inputs, N_INPUTS * sizeof *values);
    memcpy(values + FIRST_PARAMETER_LEAF, parameters, N_PARAMETERS * sizeof *values);
    values[TURNING_LEAF] = turning;
    memcpy(values + N_LEAVES, constants, sizeof constants);
    for (i = 0; i < N_OPERATIONS; i++) {
        const unsigned short *row = operations[i];

        values[FIRST_RESULT + i] = result(row[CODE], values[row[1]], values[row[2]], values[row[3]]);
    }
}

/* The derivatives of result r by the operands of an operation. */
static void partials(const unsigned short row[N_COLUMNS], const double values[], double r, double by[N_OPERANDS])
{
    const double x = values[row[1]], y = values[row[2]];

    by[0] = by[1] = by[2] = 0.0;
    switch (row[CODE]) {
    case ADD: by[0] = by[1] = 1.0; break;
    case SUBTRACT: by[0] = 1.0, by[1] = -1.0; break;
    case MULTIPLY: by[0] = y, by[1] = x; break;
    case DIVIDE: by[0] = 1.0 / y, by[1] = -r / y; break;
    case POWER: by[0] = y * pow(x, y - 1.0), by[1] = r != 0.0 ? r * log(x) : 0.0; break;
    case CHOOSE: by[x != 0.0 ? 1 : 2] = 1.0; break;
    case ROOT: by[0] = 0.5 / r; break;
    case SIN: by[0] = cos(x); break;
    case COS: by[0] = -sin(x); break;
    case TAN: by[0] = 1.0 + r * r; break;
    case ATAN: by[0] = 1.0 / (1.0 + x * x); break;
    case ACOS: by[0] = -1.0 / sqrt(1.0 - x * x); break;
    case EXP: by[0] = r; break;
    case LOG: by[0] = 1.0 / x; break;
    case ABSOLUTE: by[0] = sign(x); break;
    default: break; /* comparisons and signs: piecewise constant */
    }
}

void chain_forward(const double values[N_SLOTS], double tangents[N_SLOTS])
{
    double by[N_OPERANDS];
    size_t i, k;

    memset(tangents + N_LEAVES, 0, N_CONSTANTS * sizeof *tangents);
    for (i = 0; i < N_OPERATIONS; i++) {
        const unsigned short *row = operations[i], *slots = row + FIRST_OPERAND;
        double sum = 0.0;

        if (tangents[slots[0]] != 0.0 || tangents[slots[1]] != 0.0 || tangents[slots[2]] != 0.0) {
            partials(row, values, values[FIRST_RESULT + i], by);
            for (k = 0; k < N_OPERANDS; k++)
                if (by[k] != 0.0 && tangents[slots[k]] != 0.0)
                    sum += by[k] * tangents[slots[k]];
        }
        tangents[FIRST_RESULT + i] = sum;
    }
}

void chain_backward(const double values[N_SLOTS], double adjoints[N_SLOTS])
{
    double by[N_OPERANDS];
    size_t i, k;

    for (i = N_OPERATIONS; i-- > 0;) {
        const unsigned short *row = operations[i];

        if (adjoints[FIRST_RESULT + i] == 0.0)
            continue;
        partials(row, values, values[FIRST_RESULT + i], by);
        for (k = 0; k < N_OPERANDS; k++)
            if (by[k] != 0.0)
                adjoints[row[FIRST_OPERAND + k]] += by[k] * adjoints[FIRST_RESULT + i];
    }
}
