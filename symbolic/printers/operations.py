"""The tape of a model (`tirefmu.symbolic.model.tape`) with the rolling radius of a wheel, and its tables in C."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from textwrap import wrap

import sympy as sp

from ..model import Model
from ..model.lines import reaching
from ..model.tape import CODES, Operation, Tape, taped
from ..notation import Equation
from .c import heading
from .definitions import comment

#: How fast a wheel turns where its host gives that: a leaf of its own, by which `rolling_radius_lines` find R_e.
TURNING = "turning"
ROLLING_RADIUS = "rolling_radius"


def rolling_radius_lines(model: Model) -> list[Equation]:
    """Return the lines of the effective rolling radius of a wheel whose speed of turning is given.

    In the book the radius depends on kappa, which depends on that speed.

    Returns: none if the model has only the free radius.
    """
    radius, turning = model.quantity("rolling_radius"), model.quantity("wheel_speed")
    lines = [line for line in model.lines((), plain=True) if line.symbol.name != turning]
    return reaching(lines, [radius])


def model_tape(model: Model) -> Tape:
    """Return the lines of the forces, named quantities and the rolling radius of a wheel as operations.

    Returns: its leaves are inputs, parameters and `TURNING`; the radius of a turning wheel is called `ROLLING_RADIUS`.

    >>> from tirefmu.symbolic.models import model_named
    >>> tape = model_tape(model_named("mf96"))
    >>> tape.leaves[:4], tape.leaves[tape.slots["rolling_radius"]]
    (('kappa', 'alpha', 'gamma', 'Fz'), 'UNLOADED_RADIUS')
    """
    lines = model.lines()
    targets = [quantity.name for quantity in model.outputs] + [line.symbol.name for line in lines if line.named]
    wheel = rolling_radius_lines(model)
    renamed = {line.symbol: sp.Symbol(f"{line.symbol}_wheel", real=True) for line in wheel}
    renamed[sp.Symbol(model.quantity("wheel_speed") or "omega", real=True)] = sp.Symbol(TURNING, real=True)
    turned = [
        replace(line, symbol=renamed[line.symbol], expression=line.expression.xreplace(renamed)) for line in wheel
    ]
    inputs = [quantity.name for quantity in model.inputs]
    tape = taped([*reaching(lines, targets), *turned], [*inputs, *model.parameters, TURNING])
    radius = tape.slots[f"{model.quantity('rolling_radius')}_wheel" if wheel else "UNLOADED_RADIUS"]
    return replace(tape, slots=tape.slots | {ROLLING_RADIUS: radius})


def c_operations(model: Model) -> str:
    """Return the header with a model's operations, as macros that initialize tables in C.

    Returns: a row of operations has a code and up to three slots.
    """
    tape, lines, prefix = model_tape(model), model.lines(), model.name.upper()
    outputs = [quantity.name for quantity in model.outputs]
    named = [line.symbol.name for line in lines if line.named and line.symbol.name not in outputs]
    sizes = {"LEAVES": len(tape.leaves), "CONSTANTS": len(tape.constants), "OPERATIONS": len(tape.operations)}
    parts = [
        heading(model, "C: its lines as single operations, along which derivatives are carried"),
        f"#ifndef TIREFMU_{prefix}_OPERATIONS_H\n#define TIREFMU_{prefix}_OPERATIONS_H",
        "enum {\n" + "\n".join(_wrapped(", ".join(CODES))) + "\n};",
        comment("Slots: inputs, parameters, the speed at which a wheel turns, constants, results of operations."),
        "\n".join(f"#define {prefix}_N_{name} {size}" for name, size in sizes.items()),
        f"#define {prefix}_N_SLOTS {sum(sizes.values())}",
        f"#define {prefix}_ROLLING_RADIUS {tape.slots[ROLLING_RADIUS]}",
        _table(f"{prefix}_CONSTANTS", _wrapped(", ".join(map(repr, tape.constants)))),
        _table(f"{prefix}_FORCE_SLOTS", _wrapped(", ".join(str(tape.slots[name]) for name in outputs))),
        _table(f"{prefix}_QUANTITY_SLOTS", _wrapped(", ".join(str(tape.slots[name]) for name in named))),
        _table(f"{prefix}_OPERATIONS", _rows(tape.operations)),
        "#endif",
    ]
    return "\n\n".join(parts) + "\n"


def _rows(operations: Iterable[Operation]) -> list[str]:
    """Return the lines of the table, each line of the book under its number and name."""
    rows: list[str] = []
    waiting: list[str] = []
    for operation in operations:
        if operation.begins:
            rows += [*_wrapped(" ".join(waiting)), f"    {comment(operation.begins)}"]
            waiting = []
        waiting.append(f"{{{','.join([operation.code, *map(str, operation.operands)])}}},")
    return [*rows, *_wrapped(" ".join(waiting))]


def _table(name: str, rows: Sequence[str]) -> str:
    return " \\\n".join([f"#define {name} {{", *rows]) + " \\\n}"


def _wrapped(text: str) -> list[str]:
    return wrap(text, 118, initial_indent="    ", subsequent_indent="    ", break_on_hyphens=False)
