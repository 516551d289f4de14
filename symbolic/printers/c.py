"""A model as a C99 source and its header: plain doubles, math.h, no state, no allocation."""

from __future__ import annotations

import re

from ..model import Model
from .expressions import PlainCPrinter
from .python import HEADER
from .routines import Routine

INLINES = {
    "square": "static inline double square(double x) { return x*x; }",
    "cube": "static inline double cube(double x) { return x*x*x; }",
    "cubed_sqrt": "static inline double cubed_sqrt(double x) { return x*sqrt(x); }",
}

#: What every routine takes.
ARRAYS = "const double inputs[], const double parameters[], double results[]"


def c_header(model: Model, routines: tuple[Routine, ...]) -> str:
    """Return the header: sizes, places of inputs, parameters and results, prototypes.

    Parameters
    ----------
    model : Model
    routines : tuple of Routine

    Returns
    -------
    str
    """
    quantities, _, slips, *_ = routines
    prefix = model.name.upper()
    parts = [
        _heading(model),
        f"#ifndef TIREFMU_{prefix}_H\n#define TIREFMU_{prefix}_H\n\n#include <stddef.h>",
        _enumeration(prefix, "INPUTS", [(q.name, f"{q.description} [{q.unit}]") for q in model.inputs]),
        _enumeration(prefix, "PARAMETERS", [(c.name, f"{c.description} [{c.unit}]") for c in model.parameters]),
        _enumeration(prefix, "FORCES", [(q.name, f"{q.description} [{q.unit}]") for q in model.outputs]),
        _enumeration(prefix, "QUANTITIES", [(name, "") for name in quantities.labels]),
        f"#define {prefix}_N_SLIPS {len(slips.labels)}",
        "/* Matrices are written row by row, one row a force. */\n"
        + "\n".join(f"{_prototype(model, routine)};" for routine in routines),
        f"/* Apply a routine to n rows of inputs, each giving n_results numbers. */\n{_rows_prototype(model)};",
        "#endif",
    ]
    return "\n\n".join(parts) + "\n"


def c_source(model: Model, routines: tuple[Routine, ...]) -> str:
    """Return the source with every routine of a model.

    Parameters
    ----------
    model : Model
    routines : tuple of Routine

    Returns
    -------
    str
    """
    functions = "\n\n".join([*(_function(model, routine) for routine in routines), _rows(model)])
    inlines = "\n".join(text for name, text in INLINES.items() if re.search(rf"\b{name}\(", functions))
    return f'{_heading(model)}\n\n#include "{model.name}.h"\n\n#include <math.h>\n\n{inlines}\n\n{functions}\n'


def _heading(model: Model) -> str:
    return f"/* {model.title}, in C99.\n   {HEADER.format(name=model.name)} */"


def _enumeration(prefix: str, kind: str, names: list[tuple[str, str]]) -> str:
    lines = []
    for name, meaning in names:
        remark = f" /* {meaning} */" if meaning else ""
        lines.append(f"    {prefix}_{name},{remark}")
    # The sizes are macros so that the preprocessor can use them.
    return f"#define {prefix}_N_{kind} {len(names)}\nenum {{\n" + "\n".join(lines) + "\n};"


def _prototype(model: Model, routine: Routine) -> str:
    return f"void {model.name}_{routine.name}({ARRAYS})"


def _rows_prototype(model: Model) -> str:
    routine = "void (*routine)(const double[], const double[], double[])"
    return f"void {model.name}_rows({routine}, size_t n, size_t n_results,\n               {ARRAYS})"


def _rows(model: Model) -> str:
    step = f"routine(inputs + i*{model.name.upper()}_N_INPUTS, parameters, results + i*n_results);"
    return f"{_rows_prototype(model)}\n{{\n    for (size_t i = 0; i < n; i++)\n        {step}\n}}"


def _function(model: Model, routine: Routine) -> str:
    printer = PlainCPrinter()
    prefix = model.name.upper()
    names = {"inputs": [q.name for q in model.inputs], "parameters": [c.name for c in model.parameters]}
    lines = [
        f"const double {name} = {array}[{prefix}_{name}];"
        for array, order in names.items()
        for name in routine.uses(order)
    ]
    for assignment in routine.body:
        if assignment.heading:
            lines += ["", f"/* {assignment.heading} */"]
        remark = f" /* {assignment.remark} */" if assignment.remark else ""
        lines.append(f"const double {assignment.symbol} = {printer.doprint(assignment.expression)};{remark}")
    lines.append("")
    for i, value in enumerate(value for row in routine.results for value in row):
        lines.append(f"results[{i}] = {printer.doprint(value)};")
    body = "\n".join(f"    {line}" if line else "" for line in lines)
    return f"/* {routine.summary} */\n{_prototype(model, routine)}\n{{\n{body}\n}}"
