"""What a printout for another program contains, before any language: lines of a tire, functions, self-test."""

from __future__ import annotations

import re
import sys
from collections.abc import Collection, Mapping
from dataclasses import dataclass

import sympy as sp

from ....boundary.errors import TirefmuError
from ...declarations import Quantity
from ...model import Model
from ...model.lines import reaching, reduced
from ...notation import Equation
from ...reserved import no_state
from ..literals import Literal, folded
from ..routines import Routine, chosen_routines
from ..states import lagging_slips, state_lines

#: What can be printed, in the order of a self-test's results.
FUNCTIONS = ("forces", "quantities", "jacobian_inputs", "jacobian_parameters", "states")
#: Where the values of the coefficients are: in the lines, in a structure with default values, in a file.
PLACEMENTS = ("inline", "struct", "file")
#: Modules and namespaces that printouts use, in addition to Python's own: a file of the same name would hide them.
LIBRARIES = frozenset(["casadi", "jax", "numpy", "torch", "std", "core", "libm"])
#: Largest differences that a self-test accepts, relative to a result or its typical size.
TOLERANCE = {name: 1e-9 if name.startswith("jacobian_") else 1e-12 for name in FUNCTIONS}


@dataclass(frozen=True)
class PrintoutSelection:
    """What a user requests of a printout.

    - `functions`: of `FUNCTIONS`.
    - `placement`: of `PLACEMENTS`.
    - `outputs`: the forces and moments; all of the model if empty.
    """

    functions: tuple[str, ...] = FUNCTIONS[:3]
    placement: str = "inline"
    outputs: tuple[str, ...] = ()


@dataclass(frozen=True)
class PrintedProgram:
    """A printout before any language.

    - `name`: identifier: prefix of files, functions, modules.
    - `model`: the model of the tire, with its added effects.
    - `placement`: where the values of coefficients are: of `PLACEMENTS`.
    - `inputs`, `outputs`: the lagged slips are the last inputs if the states are printed.
    - `nominal`: the value of an absent input.
    - `coefficients`: those that the functions read; none if the values are in the lines.
    - `lines`: what the functions compute.
    - `routines`: what is printed, in order.
    - `effects`: the effects that the tire has.
    - `header`: lines of the comment at the head of each file, unescaped.
    - `check`: the text of the self-test's file.
    """

    name: str
    model: Model
    placement: str
    inputs: tuple[Quantity, ...]
    outputs: tuple[Quantity, ...]
    nominal: Mapping[str, float]
    coefficients: Mapping[str, float]
    lines: tuple[Equation, ...]
    routines: tuple[Routine, ...]
    effects: tuple[str, ...] = ()
    header: tuple[str, ...] = ()
    check: str = ""

    @property
    def input_names(self) -> list[str]:
        """The inputs in the order of the model."""
        return [quantity.name for quantity in self.inputs]

    @property
    def values_file(self) -> str:
        """The name of the file with the coefficients."""
        return f"{self.name}_coefficients.txt"

    @property
    def check_file(self) -> str:
        """The name of the file with the self-test's rows."""
        return f"{self.name}_selftest.txt"

    def data_files(self) -> dict[str, str]:
        """Return the files without code: the rows of the self-test, the coefficients where they are in a file."""
        files = {self.check_file: self.check}
        if self.placement == "file":
            files[self.values_file] = "".join(f"{name} {value!r}\n" for name, value in self.coefficients.items())
        return files


def program(
    name: str,
    model: Model,
    effects: Collection[str],
    values: Mapping[str, float],
    nominal: Mapping[str, float],
    selection: PrintoutSelection,
) -> PrintedProgram:
    """Return the printout of a tire, without header and self-test.

    `name`: any text; it becomes an identifier. `effects`: the effects that the tire has. Lines of other effects are not
    printed. `values`: every coefficient in ISO-W, as in the parameter vector of the generated code. `nominal`: the
    value of each absent input. Raises `TirefmuError` if derivatives by the coefficients are requested and the values
    are in the lines, or states of a tire that has none.
    """
    if selection.placement == "inline" and "jacobian_parameters" in selection.functions:
        raise TirefmuError("jacobian_parameters needs the coefficients as variables: use --values struct or file")
    # The parameter vector has the factor of an absent effect that changes the meaning of another coefficient.
    rescaling = {name for name, effect in model.effects.items() if effect.rescales}
    outputs = [quantity for quantity in model.outputs if not selection.outputs or quantity.name in selection.outputs]
    targets = [quantity.name for quantity in outputs]
    lines = reduced(model.equations, {*effects, *rescaling}, ())
    inputs, rates = model.inputs, ()
    if "states" in selection.functions:
        further, rates = state_lines(model, lines, effects)
        inputs, lines = (*inputs, *lagging_slips(model, lines)), (*lines, *further)
    if selection.outputs:
        lines = tuple(reaching(lines, [*targets, *map(str, rates)]))
    if selection.placement == "inline":
        lines = folded(lines, values)
    forces = {quantity.name for quantity in model.outputs}
    quantities = [line.symbol for line in lines if line.named and line.symbol.name not in forces]
    symbols = {symbol for line in lines for symbol in line.expression.free_symbols}
    read = {symbol.name for symbol in symbols if not isinstance(symbol, Literal)}
    read -= {line.symbol.name for line in lines}
    coefficients = {key: value for key, value in values.items() if key in read}
    routines = chosen_routines(
        lines,
        [function for function in FUNCTIONS if function in selection.functions],
        [quantity.symbol for quantity in outputs],
        [quantity.symbol for quantity in inputs],
        [sp.Symbol(key, real=True) for key in coefficients],
        quantities,
        rates,
    )
    return PrintedProgram(
        identifier(name), model, selection.placement, inputs, tuple(outputs),
        {**nominal, **{quantity.name: 0.0 for quantity in inputs if quantity.name not in nominal}}, coefficients,
        lines, routines, tuple(name for name in model.effects if name in effects),
    )  # fmt: skip


def operations(routine: Routine) -> int:
    """Return the number of additions, multiplications, divisions, functions and choices of a routine.

    >>> from ..routines import Assignment
    >>> x, y = sp.symbols("x y")
    >>> operations(Routine("f", "", (Assignment(y, 2 * sp.sin(x) + x + 1),), ((y,),), ("y",)))
    4
    """
    return sum(
        len(node.args) - 1 if node.is_Add or node.is_Mul else 1
        for assignment in routine.body
        for node in sp.preorder_traversal(assignment.expression)
        if node.is_Add or node.is_Mul or node.is_Pow or node.is_Function
    )


def identifier(text: str) -> str:
    """Return a text as an identifier of every language: lower case, digits and single underscores.

    It is not a word of a language, a function of C, a module that a printout imports or a device of Windows.

    >>> identifier("My Tire 205/55.tir"), identifier("2019 front"), identifier("for"), identifier("größe")
    ('my_tire_205_55_tir', 'tire_2019_front', 'tire_for', 'gr_e')
    >>> identifier("numpy"), identifier("gamma"), identifier("aux")
    ('tire_numpy', 'tire_gamma', 'tire_aux')
    """
    plain = re.sub("[^a-z0-9]+", "_", text.lower()).strip("_")[:40].strip("_")
    usable = not no_state(plain) and plain not in sys.stdlib_module_names and plain not in LIBRARIES
    return plain if usable else f"tire_{plain}".rstrip("_")
