"""A model as C99 sources and their header: plain doubles, no state, no allocation."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import sympy as sp

from ..declarations import Option
from ..model import Model
from .definitions import INCLUDES, comment, definitions
from .expressions import PlainCPrinter
from .pairs import function_of, in_pairs
from .python import PLAIN_ROWS, origin
from .routines import JACOBIANS, PLAIN, Assignment, Routine

#: Above lines that are not in the book's order.
IN_PAIRS = "Two calls of a function that do not depend on each other are computed at a time"
PRINTER = PlainCPrinter()
#: The arguments of every routine.
ARRAYS = "const double inputs[], const double parameters[], double results[]"


def c_header(model: Model, routines: tuple[Routine, ...]) -> str:
    """Return the header: sizes, indices of inputs, parameters and results, prototypes, also of the Jacobians.

    `routines`: those that are no Jacobians.
    """
    quantities = routines[0]
    prefix = model.name.upper()
    remarks = {name: f"{declared.description} [{declared.unit}]" for name, declared in model.coefficients.items()}
    remarks |= {option.parameter: _meaning(option) for option in model.options}
    parts = [
        heading(model, "C99"),
        f"#ifndef TIREFMU_{prefix}_H\n#define TIREFMU_{prefix}_H\n\n#include <stddef.h>",
        _enumeration(prefix, "INPUTS", [(q.name, f"{q.description} [{q.unit}]") for q in model.inputs]),
        _enumeration(prefix, "PARAMETERS", [(name, remarks[name]) for name in model.parameters]),
        f"#define {prefix}_N_COEFFICIENTS {len(model.coefficients)}",
        _enumeration(prefix, "FORCES", [(q.name, f"{q.description} [{q.unit}]") for q in model.outputs]),
        _enumeration(prefix, "QUANTITIES", [(name, "") for name in quantities.labels]),
        f"{comment('Matrices are written row by row, one row a force.')}\n{_prototypes(model, routines, '')}",
        *_plain_prototypes(model, routines),
        f"{comment('Apply a routine to n rows of inputs, each giving n_results numbers.')}\n{_rows_prototype(model)};",
        "#endif",
    ]
    return "\n\n".join(parts) + "\n"


def c_values(model: Model, routines: tuple[Routine, ...]) -> str:
    """Return the source with the routines that are no Jacobians."""
    return _source(model, "C99", routines, [_rows(model)])


def c_jacobians(model: Model, routines: tuple[Routine, ...]) -> str:
    """Return the source with the Jacobians. Neither source calls the other."""
    return _source(model, "C99: Jacobians", routines, [])


def _source(model: Model, what: str, routines: tuple[Routine, ...], more: list[str]) -> str:
    parts = [_function(model, routine, routines) for routine in routines]
    plain = [routine for routine in routines if routine.variant == PLAIN]
    if plain:
        parts += [_is_plain(model), *(_chooser(model, routine) for routine in plain)]
    functions = "\n\n".join([*parts, *more])
    parts = [heading(model, what), f'#include "{model.name}.h"', INCLUDES, definitions(functions), functions]
    return "\n\n".join(parts) + "\n"


def heading(model: Model, what: str) -> str:
    """Return the comment at the head of a file."""
    return comment(f"{model.title}, in {what}.", origin(model))


def _enumeration(prefix: str, kind: str, names: list[tuple[str, str]]) -> str:
    lines = []
    for name, meaning in names:
        lines.append(f"    {prefix}_{name},{_beside(meaning)}")
    # The sizes are macros so that the preprocessor can use them.
    return f"#define {prefix}_N_{kind} {len(names)}\nenum {{\n" + "\n".join(lines) + "\n};"


def _beside(remark: str) -> str:
    return f" {comment(remark)}" if remark else ""


def _meaning(option: Option) -> str:
    first, second = option.values
    return f"{option.description}: 0 {first}, 1 {second}"


def _prototypes(model: Model, routines: tuple[Routine, ...], variant: str) -> str:
    """Print the prototypes of a variant; the Jacobians of the forces follow these."""
    names = [name for routine in routines if routine.variant == variant
             for name in (routine.name, *(JACOBIANS if routine.name == "forces" else ()))]  # fmt: skip
    return "\n".join(f"{_prototype(model, f'{name}_{variant}'.rstrip('_'))};" for name in names)


def _plain_prototypes(model: Model, routines: tuple[Routine, ...]) -> list[str]:
    prototypes = _prototypes(model, routines, PLAIN)
    remark = comment(PLAIN_ROWS, "The routines above find out by themselves.")
    return [f"{remark}\n{prototypes}"] if prototypes else []


def _prototype(model: Model, routine: str) -> str:
    return f"void {model.name}_{routine}({ARRAYS})"


def _is_plain(model: Model) -> str:
    prefix = model.name.upper()
    zeros = [f"inputs[{prefix}_{name}] == 0.0" for _, name in model.on_demand]
    zeros += [f"parameters[{prefix}_{option.parameter}] == 0.0" for option in model.plain_options]
    condition = "\n        && ".join(zeros)
    return (
        f"{comment(PLAIN_ROWS)}\n"
        "static inline int is_plain(const double inputs[], const double parameters[])\n"
        f"{{\n    return {condition};\n}}"
    )


def _chooser(model: Model, plain: Routine) -> str:
    """Print the routine that passes its row to the plain variant or to the general one."""
    arguments = "(inputs, parameters, results)"
    return (
        f"{_prototype(model, plain.name)}\n{{\n"
        f"    if (is_plain(inputs, parameters))\n        {model.name}_{plain.full_name}{arguments};\n"
        f"    else\n        {plain.name}_general{arguments};\n}}"
    )


def _rows_prototype(model: Model) -> str:
    routine = "void (*routine)(const double[], const double[], double[])"
    return f"void {model.name}_rows({routine}, size_t n, size_t n_results,\n               {ARRAYS})"


def _rows(model: Model) -> str:
    step = f"routine(inputs + i*{model.name.upper()}_N_INPUTS, parameters, results + i*n_results);"
    return f"{_rows_prototype(model)}\n{{\n    for (size_t i = 0; i < n; i++)\n        {step}\n}}"


def parameters_read(model: Model, routine: Routine) -> list[str]:
    """Return the declarations of the parameters that a routine reads."""
    prefix = model.name.upper()
    return [f"const double {name} = parameters[{prefix}_{name}];" for name in routine.uses(model.parameters)]


def statements(body: Sequence[Assignment], printer: PlainCPrinter = PRINTER, kind: str = "double") -> list[str]:
    """Return lines of a routine, chapter by chapter, each with its number and meaning."""
    lines = []
    for assignment in body:
        if assignment.heading:
            lines += ["", comment(assignment.heading)]
        value = printer.doprint(assignment.expression)
        lines.append(f"const {kind} {assignment.symbol} = {value};{_beside(assignment.remark)}")
    return lines


def paired_statements(body: Sequence[Assignment]) -> list[str]:
    """Return lines of a routine in which two calls of one elementary function form a pair."""
    lines, count = ["", comment(IN_PAIRS)], 0
    for members in in_pairs(body):
        if not function_of(members[0].expression):
            lines += statements(members)
        elif len(members) == 1:
            lines.append(f"const double {members[0].symbol} = {_call(members[0].expression)};")
        else:
            count += 1
            lines.append(f"const pair pair_{count} = {_call_of_pair(members)};")
            lines += [f"const double {member.symbol} = PAIR_AT(pair_{count}, {i});" for i, member in enumerate(members)]
    return lines


def _call(expression: sp.Expr) -> str:
    return f"fast_{expression.func.__name__.lower()}({', '.join(map(PRINTER.doprint, expression.args))})"


def _call_of_pair(members: Sequence[Assignment]) -> str:
    function, arguments = function_of(members[0].expression), []
    for call in (member.expression for member in members):
        shift = ["0.5" if isinstance(call, sp.cos) else "0.0"] if function == "shifted_sin" else []
        arguments.append([*map(PRINTER.doprint, call.args), *shift])
    pairs = (f"PAIR({first}, {second})" for first, second in zip(*arguments, strict=True))
    return f"fast_pair_{function}({', '.join(pairs)})"


def _function(model: Model, routine: Routine, routines: tuple[Routine, ...]) -> str:
    prefix = model.name.upper()
    inputs = routine.uses([quantity.name for quantity in model.inputs])
    parameters = parameters_read(model, routine)
    is_general = replace(routine, variant=PLAIN).full_name in {
        other.full_name for other in routines if other != routine
    }
    paired = routine.name == "forces" and not is_general
    lines = [f"(void) {name};" for name, read in (("inputs", inputs), ("parameters", parameters)) if not read]
    lines += [f"const double {name} = inputs[{prefix}_{name}];" for name in inputs]
    lines += [*parameters, *(paired_statements(routine.body) if paired else statements(routine.body)), ""]
    values = [value for row in routine.results for value in row]
    sparse = 2 * values.count(0) > len(values)
    if sparse:
        lines.append(f"memset(results, 0, {len(values)}*sizeof(double));")
    lines += [f"results[{i}] = {PRINTER.doprint(v)};" for i, v in enumerate(values) if not sparse or v != 0]
    body = "\n".join(f"    {line}" if line else "" for line in lines)
    head = f"static void {routine.name}_general({ARRAYS})" if is_general else _prototype(model, routine.full_name)
    summary = comment(routine.summary, *([PLAIN_ROWS] if routine.variant == PLAIN else []))
    return f"{summary}\n{head}\n{{\n{body}\n}}"
