"""A model as a list of single operations, along which derivatives are carried forward or backward at run time.

Printed derivative routines are fast and long. Where they are wanted now and then, a short interpreter that goes along
this list gives the same numbers from a tenth of the code: each operation is differentiated in sequence, with the
values found there (Griewank and Walther, Evaluating Derivatives (2008), chapters 3 and 4).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace

import sympy as sp

from ..notation import Equation

#: Operations of two and three operands, then of one.
CODES = (
    *("ADD", "SUBTRACT", "MULTIPLY", "DIVIDE", "POWER", "LESS", "AT_MOST", "EQUAL", "AND", "OR", "CHOOSE"),
    *("ROOT", "SIN", "COS", "TAN", "ATAN", "ACOS", "EXP", "LOG", "SGN", "SGN1", "ABSOLUTE"),
)
#: By class: the operation, and whether its operands are exchanged.
_RELATIONS: dict[type[sp.Basic], tuple[str, bool]] = {
    sp.StrictLessThan: ("LESS", False),
    sp.LessThan: ("AT_MOST", False),
    sp.StrictGreaterThan: ("LESS", True),
    sp.GreaterThan: ("AT_MOST", True),
    sp.Equality: ("EQUAL", False),
}
_COMMUTE = ("ADD", "MULTIPLY", "EQUAL", "AND", "OR")


@dataclass(frozen=True)
class Operation:
    """An operation on the numbers in some slots, and the line that begins with it."""

    code: str
    operands: tuple[int, ...]
    begins: str = ""


@dataclass(frozen=True)
class Tape:
    """Slots of numbers: the leaves, the constants, then the result of each operation.

    - `leaves`: what is given from outside.
    - `operations`: in an order in which each reads only earlier slots. What is equal is computed once.
    - `slots`: the slots of leaves and lines by name.
    """

    leaves: tuple[str, ...]
    constants: tuple[float, ...]
    operations: tuple[Operation, ...]
    slots: dict[str, int]


def taped(lines: Sequence[Equation], leaves: Sequence[str]) -> Tape:
    """Return lines as operations.

    `lines`: each reads leaves and earlier lines only. Raises `NotImplementedError` if a line uses a function that has
    no operation.

    >>> from tirefmu.symbolic.notation import Chapter
    >>> eq, x, B = Chapter("Force"), *sp.symbols("x B", real=True)
    >>> y = eq("1", "y", 2 * sp.atan(B * x) - x)
    >>> tape = taped(eq.equations, ["x", "B"])
    >>> tape.constants, tape.slots["y"]
    ((2.0,), 6)
    >>> [(operation.code, operation.operands) for operation in tape.operations]
    [('MULTIPLY', (0, 1)), ('ATAN', (3,)), ('MULTIPLY', (2, 4)), ('SUBTRACT', (5, 0))]
    """
    recorder = _Recorder({name: slot for slot, name in enumerate(leaves)})
    for line in lines:
        recorder.record(line)
    first, n = len(leaves), len(recorder.constants)
    # While operations are found, constants have numbers below 0.
    shifted = {-1 - i: first + i for i in range(n)}
    shifted |= {first + i: first + n + i for i in range(len(recorder.operations))}
    operations = (
        replace(step, operands=tuple(shifted.get(k, k) for k in step.operands), begins=recorder.begins.get(step, ""))
        for step in recorder.operations
    )
    slots = {name: shifted.get(slot, slot) for name, slot in recorder.slots.items()}
    return Tape(tuple(leaves), tuple(recorder.constants), tuple(operations), slots)


@dataclass
class _Recorder:
    """Finds the operations of lines one after the other."""

    slots: dict[str, int]
    constants: dict[float, int] = field(default_factory=dict)
    operations: dict[Operation, int] = field(default_factory=dict)
    begins: dict[Operation, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        self._first = len(self.slots)

    def record(self, line: Equation) -> None:
        recorded = len(self.operations)
        self.slots[line.symbol.name] = self._slot(line.expression)
        for operation in list(self.operations)[recorded : recorded + 1]:
            self.begins[operation] = f"[{line.number}] {line.symbol}"

    def _slot(self, expression: sp.Expr) -> int:
        """Return the slot of an expression's value after its computation."""
        if expression.is_Symbol:
            return self.slots[expression.name]
        if not expression.free_symbols:
            return self.constants.setdefault(float(expression), -1 - len(self.constants))
        if expression.is_Add:
            return self._sum(expression.args)
        if expression.is_Mul:
            return self._product(expression.args)
        if expression.is_Pow:
            return self._power(expression.base, expression.exp)
        if isinstance(expression, sp.Piecewise):
            (value, condition), (otherwise, _) = expression.args
            return self._step("CHOOSE", *map(self._slot, (condition, value, otherwise)))
        if isinstance(expression, sp.And | sp.Or):
            return self._joined(type(expression).__name__.upper(), map(self._slot, expression.args))
        if type(expression) in _RELATIONS:
            code, turned = _RELATIONS[type(expression)]
            left, right = self._slot(expression.args[0]), self._slot(expression.args[1])
            return self._step(code, right, left) if turned else self._step(code, left, right)
        return self._step(type(expression).__name__.upper(), self._slot(expression.args[0]))

    def _sum(self, terms: Sequence[sp.Expr]) -> int:
        """Add up, then subtract."""
        taken = [term for term in terms if term.could_extract_minus_sign()]
        added = [term for term in terms if term not in taken]
        slot = self._joined("ADD", map(self._slot, added or [sp.S.Zero]))
        for term in taken:
            slot = self._step("SUBTRACT", slot, self._slot(-term))
        return slot

    def _product(self, factors: Sequence[sp.Expr]) -> int:
        """Multiply the factors of the numerator, and divide by the product of those of the denominator."""
        if factors[0] == -1:
            return self._step("SUBTRACT", self._slot(sp.S.Zero), self._slot(sp.Mul(*factors[1:])))
        below = [factor for factor in factors if factor.is_Pow and factor.exp.could_extract_minus_sign()]
        above = [factor for factor in factors if factor not in below]
        slot = self._joined("MULTIPLY", map(self._slot, above or [sp.S.One]))
        if not below:
            return slot
        divisors = (self._power(factor.base, -factor.exp) for factor in below)
        return self._step("DIVIDE", slot, self._joined("MULTIPLY", divisors))

    def _power(self, base: sp.Expr, exponent: sp.Expr) -> int:
        if exponent.could_extract_minus_sign():
            return self._step("DIVIDE", self._slot(sp.S.One), self._power(base, -exponent))
        slot = self._slot(base)
        if exponent in (1, 2, 3, 4):
            return self._joined("MULTIPLY", [slot] * int(exponent))
        if exponent == sp.Rational(1, 2):
            return self._step("ROOT", slot)
        return self._step("POWER", slot, self._slot(exponent))

    def _joined(self, code: str, slots: Iterable[int]) -> int:
        first, *rest = slots
        for slot in rest:
            first = self._step(code, first, slot)
        return first

    def _step(self, code: str, *operands: int) -> int:
        if code not in CODES:
            raise NotImplementedError(f"a line of the book uses {code.lower()}, which is no operation")
        operation = Operation(code, tuple(sorted(operands)) if code in _COMMUTE else operands)
        return self.operations.setdefault(operation, self._first + len(self.operations))
