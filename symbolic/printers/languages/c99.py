"""A tire as one C99 file in double precision: no allocation, no state, nothing but math.h."""

from __future__ import annotations

from collections.abc import Iterable

from tirefmu.boundary.escaping import c_comment

from ..definitions import comment
from ..routines import Routine
from .expressions import C99Printer
from .layout import Layout, filled
from .program import TOLERANCE, Program

LAYOUT = Layout(C99Printer(), "const double {name} = {value};", "/* {} */", c_comment)

_HEADER = """\
@head@

/* Usage:
       #include "@name@.h"
       @name@_inputs inputs = @name@_nominal;
       double forces[@guard@_N_FORCES];
       inputs.alpha = 0.05;
       @name@_forces(&inputs, @argument@forces);
   Link with -lm. Self-test: compile @name@_selftest.c and run it in this folder. */
#ifndef TIREFMU_@guard@_H
#define TIREFMU_@guard@_H

#include <math.h>
@file_includes@
@structures@

#ifndef TIREFMU_FUNCTIONS
#define TIREFMU_FUNCTIONS
static inline double tirefmu_square(double x) { return x*x; }
static inline double tirefmu_cube(double x) { return x*x*x; }
static inline double tirefmu_fourth(double x) { return (x*x)*(x*x); }
static inline double tirefmu_cubed_sqrt(double x) { return x*sqrt(x); }
/* NaN stays NaN. */
static inline double tirefmu_sgn(double x) { return x > 0.0 ? 1.0 : x < 0.0 ? -1.0 : x == x ? 0.0 : x; }
static inline double tirefmu_sgn1(double x) { return x >= 0.0 ? 1.0 : x < 0.0 ? -1.0 : x; }
#endif

@functions@

#endif
"""

_READ_FILE = """\
/* Read coefficients from a text file with lines "NAME value"; 0 if it cannot be read or one is missing. */
static inline int @name@_read_coefficients(const char *path, @name@_coefficients *coefficients)
{
    char key[65];
    double value;
    int found = 0;
    FILE *file = fopen(path, "r");
    if (!file)
        return 0;
    while (fscanf(file, "%64s %lf", key, &value) == 2) {
@assignments@
    }
    fclose(file);
    return found == @count@;
}"""

_SELF_TEST = """\
@head@

/* Self-test: cc -std=c99 @name@_selftest.c -lm -o selftest && ./selftest
   Compares @name@.h with the stored results of tirefmu in @check_file@ and prints the largest difference of each
   function, relative to the result or its typical size. Exit code 1: a difference exceeds the tolerance. */
#include "@name@.h"

#include <stdio.h>

int main(void)
{
    static double sizes[@n_results@], expected[@n_results@], results[@n_results@];
    double largest[@n_functions@] = {0.0};
    int n = 0, ok, i, k;
    FILE *file = fopen("@check_file@", "r");
@read_coefficients@    ok = file && fscanf(file, "%d", &n) == 1 && n > 0;
    for (k = 0; ok && k < @n_results@; k++)
        ok = fscanf(file, "%lf", &sizes[k]) == 1;
    for (i = 0; ok && i < n; i++) {
        @name@_inputs inputs = @name@_nominal;
@read@
        for (k = 0; ok && k < @n_results@; k++)
            ok = fscanf(file, "%lf", &expected[k]) == 1;
@calls@
        for (k = 0; k < @n_results@; k++) {
            const double size = fmax(sizes[k], fabs(expected[k]));
            const double difference = fabs(results[k] - expected[k])/size;
            double *function = &largest[@which@];
            if (!(difference <= *function))
                *function = difference >= 0.0 ? difference : INFINITY; /* NaN stays the largest */
        }
    }
@report@
    return ok ? 0 : 1;
}
"""


def files(program: Program) -> dict[str, str]:
    """Return the C file, its self-test and their data: text by file name."""
    name = program.name
    values = {
        "head": LAYOUT.head(program.header),
        "name": name,
        "guard": name.upper(),
        "argument": f"&{name}_default_coefficients, " if program.placement == "struct" else _argument(program),
        "file_includes": "#include <stdio.h>\n#include <string.h>\n" if program.placement == "file" else "",
        "structures": "\n\n".join(_structures(program)),
        "functions": "\n\n".join(_functions(program)),
    }
    return {f"{name}.h": filled(_HEADER, values), f"{name}_selftest.c": _self_test(program), **program.data_files()}


def _argument(program: Program) -> str:
    return "&coefficients, " if program.coefficients else ""


def _structures(program: Program) -> list[str]:
    name = program.name
    inputs = [(q.name, f"{q.description} [{q.unit}]") for q in program.inputs]
    parts = [
        _structure(f"{name}_inputs", "Operating conditions.", inputs),
        _constant(f"{name}_inputs {name}_nominal", [program.nominal[q.name] for q in program.inputs]),
    ]
    if program.coefficients:
        declared = program.model.coefficients
        members = [(key, f"{declared[key].description} [{declared[key].unit}]") for key in program.coefficients]
        parts.append(_structure(f"{name}_coefficients", "Coefficients.", members))
        if program.placement == "struct":
            values = program.coefficients.values()
            parts.append(_constant(f"{name}_coefficients {name}_default_coefficients", values))
    units = {quantity.name: f"{quantity.description} [{quantity.unit}]" for quantity in program.outputs}
    units |= {str(line.symbol): f"{line.description} [{line.unit}]" for line in program.lines}
    for routine in program.routines:
        size = f"#define {name.upper()}_N_{routine.name.upper()} {sum(map(len, routine.results))}"
        if routine.name.startswith("jacobian_"):
            rows, columns = len(routine.results), len(routine.results[0])
            parts.append(f"{comment(f'{rows} rows, one a force; {columns} columns.')}\n{size}")
            continue
        labels = [f"    {name}_{routine.name}_{label}, {comment(units[label])}" for label in routine.labels]
        parts.append(f"{comment(f'Indices in the results of {name}_{routine.name}.')}\n{size}\nenum {{\n"
                     + "\n".join(labels) + "\n};")  # fmt: skip
    return parts


def _structure(name: str, meaning: str, members: Iterable[tuple[str, str]]) -> str:
    body = "\n".join(f"    double {member}; {comment(text)}" for member, text in members)
    return f"{comment(meaning)}\ntypedef struct {{\n{body}\n}} {name};"


def _constant(declared: str, values: Iterable[float]) -> str:
    return f"static const {declared} = {{\n" + "\n".join(f"    {value!r}," for value in values) + "\n};"


def _functions(program: Program) -> list[str]:
    parts = [_function(program, routine) for routine in program.routines]
    if program.placement == "file":
        assignments = "\n".join(
            f'        if (!strcmp(key, "{key}")) {{\n            coefficients->{key} = value;\n            found++;\n'
            "        }"
            for key in program.coefficients
        )
        values = {"name": program.name, "assignments": assignments, "count": len(program.coefficients)}
        parts.append(filled(_READ_FILE, values))
    return parts


def _function(program: Program, routine: Routine) -> str:
    name = program.name
    inputs, used = routine.uses(program.input_names), routine.uses(list(program.coefficients))
    parameters = [f"const {name}_inputs *inputs"]
    parameters += [f"const {name}_coefficients *coefficients"] if program.coefficients else []
    read = [] if inputs else ["(void) inputs;"]
    read += [f"const double {key} = inputs->{key};" for key in inputs]
    read += [] if used or not program.coefficients else ["(void) coefficients;"]
    read += [f"const double {key} = coefficients->{key};" for key in used]
    values = enumerate(LAYOUT.values(routine))
    written = [line for i, value in values for line in LAYOUT.lines(f"results[{i}] = {value};")]
    return (
        f"{comment(routine.summary)}\n"
        f"static inline void {name}_{routine.name}({', '.join(parameters)}, double results[])\n{{\n"
        f"{LAYOUT.indented(read)}\n{LAYOUT.statements(routine)}\n\n{LAYOUT.indented(written)}\n}}"
    )


def _self_test(program: Program) -> str:
    name, argument = program.name, _argument(program)
    starts, calls, report = [0], [], []
    for i, (function, size) in enumerate(program.sizes()):
        calls.append(f"{name}_{function}(&inputs, {argument}results + {starts[-1]});")
        starts.append(starts[-1] + size)
        report.append(f'printf("{function} %.3g\\n", largest[{i}]);')
        report.append(f"ok = ok && largest[{i}] <= {TOLERANCE[function]!r};")
    load = f"    {name}_coefficients coefficients = {name}_default_coefficients;\n"
    if program.placement == "file":
        load = (
            f"    {name}_coefficients coefficients;\n"
            f'    if (!{name}_read_coefficients("{program.values_file}", &coefficients))\n        return 1;\n'
        )
    values = {
        "head": LAYOUT.head(program.header[:1]),
        "name": name,
        "check_file": program.check_file,
        "n_results": starts[-1],
        "n_functions": len(calls),
        "which": " + ".join(f"(k >= {start})" for start in starts[1:-1]) or "0",
        "read_coefficients": load if program.coefficients else "",
        "read": LAYOUT.indented(
            [f'ok = ok && fscanf(file, "%lf", &inputs.{key}) == 1;' for key in program.input_names], 2
        ),
        "calls": LAYOUT.indented(calls, 2),
        "report": LAYOUT.indented(report),
    }
    return filled(_SELF_TEST, values)
