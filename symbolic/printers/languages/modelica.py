"""A tire as a Modelica package: types, functions with derivatives, a record of coefficients, a wheel contact block."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from ....boundary.errors import TirefmuError
from ....boundary.escaping import c_comment, python_comment
from ...declarations import Quantity
from ..states import ENDINGS
from .expressions import ModelicaPrinter
from .layout import Layout
from .program import PrintedProgram
from .rendering import Function, PrintedValue, functions_of, render

LAYOUT = Layout(ModelicaPrinter(), "{name} := {value};", "// {}", c_comment, indent="  ")

#: Types of the package by unit, equal to those of Modelica.Units.SI: name, which is also the quantity; unit of display.
TYPES = {
    "N": ("Force", ""), "N m": ("Torque", ""), "rad": ("Angle", "deg"), "rad/s": ("AngularVelocity", ""),
    "Pa": ("Pressure", "bar"), "m": ("Length", ""), "m/s": ("Velocity", ""), "s": ("Time", ""),
    "N/m": ("TranslationalSpringConstant", ""), "N s/m": ("TranslationalDampingConstant", ""),
}  # fmt: skip

#: Replacement of a slip that lags: its state, and the slip as a function of the state.
ACTING = {"kappa": ("kappa_lagged", "kappa_lagged"), "alpha": ("tan_alpha_lagged", "atan(tan_alpha_lagged)")}


def files(program: PrintedProgram) -> dict[str, str]:
    """Return the package and its self-test: text by file name.

    Raises `TirefmuError` if the coefficients are in a file: Modelica reads none without an external library.
    """
    if program.placement == "file":
        raise TirefmuError("modelica reads no coefficients from a file: use --values inline or struct")
    members = {key: f"coefficients.{key}" for key in program.coefficients}
    functions = functions_of(program, replace(LAYOUT, printer=ModelicaPrinter(members)))
    printed = {function.name: function for function in functions}
    templates = {"{}.mo": "modelica.mo", "{}_selftest.mo": "modelica_selftest.mo"}
    rendered = render(
        program, LAYOUT, templates, {"declared": _declared, "quotable": python_comment}, functions=functions,
        types=map(_type, TYPES), load=repr(program.nominal["Fz"]), has_forces="forces" in printed,
        has_derivative=printed.keys() >= {"forces", "jacobian_inputs"}, ending=ENDINGS[0],
        arguments=_arguments(program, program.input_names), derivatives=_derivatives(program, printed),
        **_wheel(program, printed), **_rows(program, functions),
    )  # fmt: skip
    return {name: text for name, text in rendered.items() if name.endswith(".mo")}


def _arguments(program: PrintedProgram, values: Sequence[str]) -> list[str]:
    return [*values, *(["coefficients"] if program.coefficients else [])]


def _derivatives(program: PrintedProgram, printed: Mapping[str, Function]) -> list[tuple[str, list[str]]]:
    """Return the terms of the time derivative of each force, by the chain rule."""
    if "jacobian_inputs" not in printed:
        return []
    rows = zip(program.outputs, printed["jacobian_inputs"].results, strict=True)
    return [
        (quantity.name, [f"matrix[{i}, {k}]*der_{name}"
                         for k, (name, value) in enumerate(zip(program.input_names, row, strict=True), 1) if value])
        for i, (quantity, row) in enumerate(rows, 1)
    ]  # fmt: skip


def _wheel(program: PrintedProgram, printed: Mapping[str, Function]) -> dict[str, Any]:
    """Return the parts of the block: inputs of the wheel, states that it integrates, arguments of the forces."""
    rates = printed["states"].labels if "states" in printed else ()
    states = [label.removesuffix(f"_{ENDINGS[0]}") for label in rates[:: len(ENDINGS)]]
    given = [quantity for quantity in program.inputs if quantity.name not in states]
    lagged = [ACTING.get(name, ("", "")) for name in program.input_names]
    acting = [slip if state in states else name
              for name, (state, slip) in zip(program.input_names, lagged, strict=True)]  # fmt: skip
    connectors = [*_connectors("RealInput", given, -110), *_connectors("RealOutput", program.outputs, 110)]
    return {
        "rates": rates, "states": states, "connectors": connectors, "acting": _arguments(program, acting),
    }  # fmt: skip


def _rows(program: PrintedProgram, functions: Sequence[Function]) -> dict[str, Any]:
    """Return the tables of the self-test, and the results of each function and their differences."""
    _, sizes, *rows = ([*map(float, line.split())] for line in program.check.splitlines())
    n, values, terms = len(program.inputs), {}, {}
    for function in functions:
        shape = ((i, k) for i in range(1, function.n_rows + 1) for k in range(1, len(function.labels) + 1))
        name = function.name
        values[name] = ([f"{name}_result[{i}, {k}]" for i, k in shape] if function.is_matrix
                        else [f"{name}_{label}" for label in function.labels])  # fmt: skip
        terms[name] = [f"abs({value} - expected[row, {k}])/max(sizes[{k}], abs(expected[row, {k}]))"
                       for k, value in enumerate(values[name], function.first + 1)]  # fmt: skip
    return {
        "sizes": sizes, "rows": rows, "given": [row[:n] for row in rows], "expected": [row[n:] for row in rows],
        "row_arguments": _arguments(program, [f"rows[row, {i}]" for i in range(1, n + 1)]), "values": values,
        "terms": terms,
    }  # fmt: skip


def _declared(about: PrintedValue, kind: str, value: str = "", attributes: str = "") -> str:
    """Return the declaration of a Real with its type or unit and its description."""
    type_ = f"Types.{TYPES[about.unit][0]}" if about.unit in TYPES else "Real"
    attributes = ", ".join(filter(None, ["" if about.unit in TYPES else _unit(about.unit), attributes]))
    text = f"{kind} {type_} {about.name}{f'({attributes})' if attributes else ''}{value}"
    return f'{text} "{python_comment(about.description)}";'.strip()


def _type(unit: str) -> str:
    """Return the definition of a type.

    >>> _type("N m")
    'type Torque = Real(final quantity = "Torque", final unit = "N.m");'
    """
    return f"type {TYPES[unit][0]} = Real({_attributes(unit, 'final ')});"


def _attributes(unit: str, prefix: str = "") -> str:
    """Return quantity, unit and unit of display of a variable."""
    quantity, display = TYPES.get(unit, ("", ""))
    texts = [f'quantity = "{quantity}"' if quantity else "", _unit(unit)]
    shown = [f'displayUnit = "{display}"'] if display else []
    return ", ".join([*(prefix + text for text in texts if text), *shown])


def _connectors(kind: str, quantities: Sequence[Quantity], x: int) -> list[str]:
    """Return the declarations of signals, one below the other at a side of the icon."""
    lines = []
    for i, q in enumerate(quantities, 1):
        y = 100 - 200 * i // (len(quantities) + 1)
        lines.append(f'{kind} {q.name}({_attributes(q.unit)}) "{python_comment(q.description)}"')
        place = f"{{{{{x - 10}, {y - 10}}}, {{{x + 10}, {y + 10}}}}}"
        lines.append(f"  annotation(Placement(transformation(extent = {place})));")
    return lines


def _unit(text: str) -> str:
    r"""Return the attribute of a unit in Modelica; none for a text that is not a unit.

    >>> _unit("N m"), _unit("1/rad^2"), _unit('mm " x')
    ('unit = "N.m"', 'unit = "1/rad2"', '')
    """
    unit = text.replace("^", "").replace(" ", ".")
    factor = "[A-Za-z]+[0-9]*"
    plain = re.fullmatch(rf"(1|{factor}(\.{factor})*)(/({factor}|\({factor}(\.{factor})+\)))?", unit)
    return f'unit = "{unit}"' if plain else ""
