"""A tire as a Modelica package: types, functions with derivatives, a record of coefficients, a wheel contact block."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import replace

from tirefmu.boundary.errors import TirefmuError
from tirefmu.boundary.escaping import c_comment, python_comment

from ...declarations import Quantity
from ..routines import Routine
from ..states import ENDINGS
from .expressions import ModelicaPrinter
from .layout import Layout, filled, wrapped
from .program import TOLERANCE, Program

LAYOUT = Layout(ModelicaPrinter(), "{name} := {value};", "// {}", c_comment, indent="  ")

#: Types of the package by unit, equal to those of Modelica.Units.SI: name, which is also the quantity; unit of display.
TYPES = {
    "N": ("Force", ""), "N m": ("Torque", ""), "rad": ("Angle", "deg"), "rad/s": ("AngularVelocity", ""),
    "Pa": ("Pressure", "bar"), "m": ("Length", ""), "m/s": ("Velocity", ""), "s": ("Time", ""),
    "N/m": ("TranslationalSpringConstant", ""), "N s/m": ("TranslationalDampingConstant", ""),
}  # fmt: skip

#: Replacement of a slip that lags: its state, and the slip as a function of the state.
ACTING = {"kappa": ("kappa_lagged", "kappa_lagged"), "alpha": ("tan_alpha_lagged", "atan(tan_alpha_lagged)")}

_PACKAGE = """\
@head@
//
// Usage:
//     (@outputs@) = @name@.forces(alpha = 0.05@argument@);   // other inputs have their nominal values
// Block WheelContact: an input that is not connected has a value in the declaration, such as wheel(Fz = @load@).
// Self-test: simulate @name@_selftest from @name@_selftest.mo.
package @name@ "@title@"

  package Types "Types as in Modelica.Units.SI"
@types@
  end Types;

@parts@

  function sgn1 "Sign, 1 at 0"
    input Real x;
    output Real y;
  algorithm
    y := if x >= 0.0 then 1.0 else -1.0;
  end sgn1;

end @name@;
"""

_FUNCTION = """\
  function @function@ "@summary@"
@inputs@
@outputs@
  protected
@locals@
  algorithm
@statements@
@assigned@@annotation@
  end @function@;"""

_BLOCK = """\
  connector RealInput = input Real "Input signal, as Modelica.Blocks.Interfaces.RealInput" annotation(Icon(
    graphics = {Polygon(points = {{-100, 100}, {100, 0}, {-100, -100}}, lineColor = {0, 0, 127},
    fillColor = {0, 0, 127}, fillPattern = FillPattern.Solid)}));

  connector RealOutput = output Real "Output signal, as Modelica.Blocks.Interfaces.RealOutput" annotation(Icon(
    graphics = {Polygon(points = {{-100, 100}, {100, 0}, {-100, -100}}, lineColor = {0, 0, 127},
    fillColor = {255, 255, 255}, fillPattern = FillPattern.Solid)}));

  block WheelContact "Forces of the tire@with_states@"
@declared@
  equation
@equations@
    annotation(Icon(coordinateSystem(extent = {{-100, -100}, {100, 100}}), graphics = {
      Rectangle(extent = {{-100, 100}, {100, -100}}, fillColor = {255, 255, 255}, fillPattern = FillPattern.Solid),
      Ellipse(extent = {{-70, 75}, {70, -65}}, fillColor = {64, 64, 64}, fillPattern = FillPattern.Solid),
      Ellipse(extent = {{-40, 45}, {40, -35}}, fillColor = {215, 215, 215}, fillPattern = FillPattern.Solid),
      Line(points = {{-90, -65}, {90, -65}}, thickness = 1),
      Text(extent = {{-150, 140}, {150, 105}}, textString = "%name", textColor = {0, 0, 255})}));
  end WheelContact;"""

_SELF_TEST = """\
@head@
//
// Self-test: simulate from 0 to @stop@ s. Each second is a row of stored results of tirefmu; the variables named
// after functions are the largest differences of the row, relative to the result or its typical size. An assertion
// stops the simulation if one exceeds the tolerance.
model @name@_selftest
  constant Real rows[@n_rows@, @n_inputs@] = {
@rows@};
  constant Real expected[@n_rows@, @n_results@] = {
@expected@};
  constant Real sizes[@n_results@] = {@sizes@};
  Integer row(start = 1, fixed = true);
@declared@
equation
  when time >= pre(row) then
    row = pre(row) + 1;
  end when;
@equations@
end @name@_selftest;
"""


def files(program: Program) -> dict[str, str]:
    """Return the package and its self-test: text by file name.

    Raises `TirefmuError` if the coefficients are in a file: Modelica reads none without an external library.
    """
    if program.placement == "file":
        raise TirefmuError("modelica reads no coefficients from a file: use --values inline or struct")
    printed = {routine.name: routine for routine in program.routines}
    parts = [_record(program)] if program.coefficients else []
    parts += [_function(program, routine) for routine in program.routines]
    if printed.keys() >= {"forces", "jacobian_inputs"}:
        parts.append(_derivative(program, printed["jacobian_inputs"]))
    if "forces" in printed:
        parts.append(_block(program, printed.get("states")))
    values = {
        "head": LAYOUT.head(program.header),
        "name": program.name,
        "title": python_comment(program.model.title),
        "outputs": ", ".join(quantity.name for quantity in program.outputs),
        "argument": ", coefficients = coefficients" if program.coefficients else "",
        "load": repr(program.nominal["Fz"]),
        "types": LAYOUT.indented((_type(unit) for unit in TYPES), 2),
        "parts": "\n\n".join(parts),
    }
    return {f"{program.name}.mo": filled(_PACKAGE, values), f"{program.name}_selftest.mo": _self_test(program)}


def _declared(kind: str, about: Quantity, value: str = "", attributes: str = "") -> str:
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
    known = re.fullmatch(rf"(1|{factor}(\.{factor})*)(/({factor}|\({factor}(\.{factor})+\)))?", unit)
    return f'unit = "{unit}"' if known else ""


def _record(program: Program) -> str:
    declared = program.model.coefficients
    values = program.coefficients.items()
    members = [
        _declared("", Quantity(key, declared[key].unit, declared[key].description), f" = {value!r}")
        for key, value in values
    ]
    return f'  record Coefficients "Coefficients of the tire"\n{LAYOUT.indented(members, 2)}\n  end Coefficients;'


def _inputs(program: Program) -> list[str]:
    lines = [_declared("input", q, f" = {program.nominal[q.name]!r}") for q in program.inputs]
    return [*lines, *_coefficients_input(program, " = Coefficients()")]


def _coefficients_input(program: Program, default: str = "") -> list[str]:
    return [f"input Coefficients coefficients{default};"] if program.coefficients else []


def _function(program: Program, routine: Routine) -> str:
    """Return a function; results are outputs by name, or a matrix."""
    meanings = {str(e.symbol): Quantity(str(e.symbol), e.unit, e.description) for e in program.lines}
    meanings |= {quantity.name: quantity for quantity in program.outputs}
    matrix = routine.name.startswith("jacobian_")
    members = {key: f"coefficients.{key}" for key in program.coefficients}
    layout = replace(LAYOUT, printer=ModelicaPrinter(members))
    assigned = [str(assignment.symbol) for assignment in routine.body]
    inner = [name for name in assigned if matrix or name not in routine.labels]
    if matrix:
        size = f"{len(routine.results)}, {len(routine.labels)}"
        outputs = [f'output Real result[{size}] "a row for each force, a column for each argument";']
        *rows, last = layout.rows(routine, "{{{}}},")
        results = ["result := {", *(f"  {row}" for row in rows), f"  {last.removesuffix(',')}}};"]
    else:
        outputs = [_declared("output", meanings[label]) for label in routine.labels]
        results = []
    values = {
        "function": routine.name,
        "summary": python_comment(routine.summary),
        "inputs": LAYOUT.indented(_inputs(program), 2),
        "outputs": LAYOUT.indented(outputs, 2),
        "locals": LAYOUT.indented((f"Real {name};" for name in inner), 2),
        "statements": layout.statements(routine, 2),
        "assigned": LAYOUT.indented(results, 2),
        "annotation": _annotation(program) if routine.name == "forces" else "",
    }
    return filled(_FUNCTION, values)


def _annotation(program: Program) -> str:
    if not any(routine.name == "jacobian_inputs" for routine in program.routines):
        return ""
    without = "(noDerivative = coefficients)" if program.coefficients else ""
    return f"\n    annotation(derivative{without} = forces_der);"


def _derivative(program: Program, jacobian: Routine) -> str:
    """Return the function of the time derivatives of the forces, by the chain rule."""
    names = program.input_names
    inputs = [f"input Real {name};" for name in names] + _coefficients_input(program)
    inputs += [f"input Real der_{name};" for name in names]
    outputs = [f"output Real der_{quantity.name};" for quantity in program.outputs]
    lines = [f"matrix := jacobian_inputs({', '.join(_arguments(program, names))});"]
    for i, (quantity, row) in enumerate(zip(program.outputs, jacobian.results, strict=True), 1):
        terms = [
            f"matrix[{i}, {k}]*der_{name}" for k, (name, value) in enumerate(zip(names, row, strict=True), 1) if value
        ]
        lines.append(f"der_{quantity.name} := {' + '.join(terms) or '0.0'};")
    values = {
        "function": "forces_der",
        "summary": "Derivatives of the forces by time",
        "inputs": LAYOUT.indented(inputs, 2),
        "outputs": LAYOUT.indented(outputs, 2),
        "locals": f"    Real matrix[{len(program.outputs)}, {len(names)}];",
        "statements": LAYOUT.indented(lines, 2),
        "assigned": "",
        "annotation": "",
    }
    return filled(_FUNCTION, values)


def _arguments(program: Program, values: Iterable[str]) -> list[str]:
    return [*values, *(["coefficients"] if program.coefficients else [])]


def _block(program: Program, states: Routine | None) -> str:
    """Return the block: inputs of the wheel, states that it integrates, forces at the lagged slips."""
    names = [label.removesuffix(f"_{ENDINGS[0]}") for label in states.labels[:: len(ENDINGS)]] if states else []
    given = [q for q in program.inputs if q.name not in names]
    rates, equations = [], []
    if states:
        rates = [f"Real {label};" for label in states.labels]
        call = f"states({', '.join(_arguments(program, program.input_names))});"
        equations = LAYOUT.lines(f"({', '.join(states.labels)}) = {call}")
        equations += [f"der({name}) = {name}_{ENDINGS[0]};" for name in names]
    acting = [ACTING[name][1] if name in ACTING and ACTING[name][0] in names else name for name in program.input_names]
    outputs = [quantity.name for quantity in program.outputs]
    equations += LAYOUT.lines(f"({', '.join(outputs)}) = forces({', '.join(_arguments(program, acting))});")
    declared = ["parameter Coefficients coefficients;"] if program.coefficients else []
    declared += [*_connectors("RealInput", given, -110), *_connectors("RealOutput", program.outputs, 110)]
    declared += [_declared("", q, attributes="start = 0.0, fixed = true") for q in program.inputs if q.name in names]
    values = {
        "with_states": " and its states" if states else "",
        "declared": LAYOUT.indented([*declared, *rates], 2),
        "equations": LAYOUT.indented(equations, 2),
    }
    return filled(_BLOCK, values)


def _self_test(program: Program) -> str:
    _, sizes, *rows = ([*map(float, line.split())] for line in program.check.splitlines())
    n = len(program.inputs)
    declared, equations, start = [], [], 0
    given = [f"rows[row, {i}]" for i in range(1, n + 1)]
    if program.coefficients:
        declared.append(f"{program.name}.Coefficients coefficients;")
    for routine, (function, size) in zip(program.routines, program.sizes(), strict=True):
        call = f"{program.name}.{function}({', '.join(_arguments(program, given))});"
        if function.startswith("jacobian_"):
            declared.append(f"Real {function}_result[{len(routine.results)}, {len(routine.labels)}];")
            equations += LAYOUT.lines(f"{function}_result = {call}")
            shape = ((i, k) for i in range(1, len(routine.results) + 1) for k in range(1, len(routine.labels) + 1))
            results = [f"{function}_result[{i}, {k}]" for i, k in shape]
        else:
            results = [f"{function}_{label}" for label in routine.labels]
            declared += [f"Real {name};" for name in results]
            equations += LAYOUT.lines(f"({', '.join(results)}) = {call}")
        terms = [f"abs({name} - expected[row, {k}])/max(sizes[{k}], abs(expected[row, {k}]))"
                 for k, name in enumerate(results, start + 1)]  # fmt: skip
        declared.append(f"Real {function};")
        equations += LAYOUT.lines(f"{function} = max({{{', '.join(terms)}}});")
        equations.append(f'assert({function} <= {TOLERANCE[function]!r}, "{function} differ");')
        start += size
    values = {
        "head": LAYOUT.head(program.header[:1]),
        "name": program.name,
        "stop": len(rows) - 1,
        "n_rows": len(rows),
        "n_inputs": n,
        "n_results": start,
        "rows": _matrix(row[:n] for row in rows),
        "expected": _matrix(row[n:] for row in rows),
        "sizes": _numbers(sizes),
        "declared": LAYOUT.indented(declared),
        "equations": LAYOUT.indented(equations),
    }
    return filled(_SELF_TEST, values)


def _matrix(rows: Iterable[Sequence[float]]) -> str:
    return ",\n".join(f"    {{{_numbers(row)}}}" for row in rows)


def _numbers(values: Iterable[float]) -> str:
    return "\n      ".join(line.rstrip() for line in wrapped([*map(repr, values)]))
