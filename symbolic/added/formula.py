"""Conversion of formulas from and to text: arithmetic, a few functions, names; no executable code, limited size.

The text is untrusted input. Its length, depth and size are checked before anything is computed. Subexpressions of
numbers are evaluated here in fractions and floats of limited size, not by SymPy, which would evaluate
``exp(exp(exp(99)))`` to the last digit.
"""

from __future__ import annotations

import ast
import math
import operator
import re
import warnings
from collections.abc import Callable
from fractions import Fraction
from functools import lru_cache
from typing import Any

import sympy as sp
from sympy.printing.str import StrPrinter

from ...boundary.errors import EffectError, nearest
from ...boundary.escaping import quoted
from ..functions import absolute, sgn, sgn1

#: Limits of a formula: characters; nesting depth (n for a sum of n terms); names, numbers and operations.
LONGEST, DEEPEST, MAX_PARTS = 2000, 80, 600
#: Limits of its numbers: other than 0 they are between 1/LARGEST and LARGEST; powers.
LARGEST, HIGHEST_POWER = 1e50, 99

FUNCTIONS: dict[str, Any] = {
    "sin": sp.sin, "cos": sp.cos, "tan": sp.tan, "atan": sp.atan, "exp": sp.exp, "log": sp.log, "sqrt": sp.sqrt,
    "tanh": lambda x: 1 - 2 / (sp.exp(2 * x) + 1), "abs": absolute, "absolute": absolute, "sgn": sgn, "sgn1": sgn1,
}  # fmt: skip
OPERATORS: dict[type[ast.operator], Callable[..., Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Pow: operator.pow,
}
#: The same functions for numbers.
ON_NUMBERS: dict[str, Callable[..., Any]] = {
    **{name: getattr(math, name) for name in ("sin", "cos", "tan", "atan", "exp", "log", "sqrt", "tanh")},
    "abs": abs,
    "absolute": abs,
    "sgn": lambda x: (x > 0) - (x < 0),
    "sgn1": lambda x: 1 if x >= 0 else -1,
}

#: Maximum number of conversions until the printed text of an expression is read as the same expression.
MAX_FORMS = 5

_NOT_ALLOWED = re.compile(r"[^A-Za-z0-9_+\-*/().\s]")


class _Refused(ValueError):
    """Reason why a part of a formula is rejected."""


def formula(text: str, location: str) -> sp.Expr:
    """Return the expression of a text.

    `text`: ``1 + TMU1*(T - TREF)``: + - * / **, brackets, numbers, ``pi``, and the functions of `FUNCTIONS`.
    `location`: origin of the text, for messages. Returns: names are real symbols. Numbers are rational or doubles,
    finite and of limited size. Raises `EffectError` if the text is not a formula, exceeds the limits of this module, or
    a part of it has no real value.

    >>> formula("1 + 2*TMU1*abs(T)", "example")
    2*TMU1*absolute(T) + 1
    >>> formula("T/(2 - 2)", "example")
    Traceback (most recent call last):
    ...
    tirefmu.boundary.errors.EffectError: example: 'T / (2 - 2)' divides by 0
    """
    try:
        return _expression(text)
    except EffectError as error:
        raise EffectError(f"{location}: {error}") from None


@lru_cache(maxsize=4096)
def _expression(text: str) -> sp.Expr:
    """Return the expression of a text, which is read once: a file, its checks and the lines of a model ask for it."""
    try:
        expression = _read(_tree(text))
        for _ in range(MAX_FORMS):  # SymPy may print brackets that it removes on reading
            again = _read(_tree(formula_text(expression)))
            if again == expression:
                return expression
            expression = again
    except _Refused as error:
        raise EffectError(f"{quoted(text)} {error}") from None
    raise EffectError(f"{quoted(text)} has no reproducible text")


def formula_text(expression: sp.Expr) -> str:
    """Return the text of an expression; `formula` is the inverse.

    >>> formula_text(formula("0.1*T*0.7 + sqrt(2)", "example"))
    '0.06999999999999999*T + 1.4142135623730951'
    """
    return str(_TextPrinter().doprint(expression))


class _TextPrinter(StrPrinter):
    """SymPy's text with all digits of floats."""

    def _print_Float(self, expr: Any) -> str:
        return repr(float(expr))


def _tree(text: str) -> ast.expr:
    """Return the syntax tree of a text within the limits."""
    if len(text) > LONGEST:
        raise _Refused(f"has more than {LONGEST} characters")
    if character := _NOT_ALLOWED.search(text):
        raise _Refused(f"is not a formula: {character[0]!r} is not allowed in a formula")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")  # 1or 2
            tree = ast.parse(f"({text.strip()}\n)", mode="eval").body
    except (SyntaxError, ValueError, RecursionError, MemoryError, Warning):
        raise _Refused("is not a formula") from None
    level, parts = [tree], 0
    for _ in range(DEEPEST):
        parts += len(level)
        level = [below for node in level for below in ast.iter_child_nodes(node) if isinstance(below, ast.expr)]
    if level:
        raise _Refused(f"is nested more than {DEEPEST} levels deep")
    if parts > MAX_PARTS:
        raise _Refused(f"has more than {MAX_PARTS} numbers, names and operations")
    return tree


def _read(node: ast.expr) -> sp.Expr:
    """Return the checked expression of a node."""
    if isinstance(node, ast.Constant) and isinstance(node.value, (int, float)) and not isinstance(node.value, bool):
        value = node.value
        return _worked_out(node, lambda: _number(value))
    if isinstance(node, ast.Name):
        return sp.Float(math.pi) if node.id == "pi" else sp.Symbol(node.id, real=True)
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, (ast.USub, ast.UAdd)):
        value = _read(node.operand)
        return -value if isinstance(node.op, ast.USub) else value
    if isinstance(node, ast.BinOp) and type(node.op) in OPERATORS:
        operands = [node.left, node.right]
        apply = on_numbers = OPERATORS[type(node.op)]
    elif isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and len(node.args) == 1 and not node.keywords:
        if node.func.id not in FUNCTIONS:
            raise EffectError(f"unknown function {node.func.id!r}{nearest(node.func.id, FUNCTIONS)}")
        operands, apply = node.args, FUNCTIONS[node.func.id]
        on_numbers = ON_NUMBERS[node.func.id]
    else:
        raise EffectError(f"{quoted(ast.unparse(node))} is not allowed in a formula")
    values = [_read(operand) for operand in operands]
    return _worked_out(node, lambda: _applied(node, values, apply, on_numbers))


def _worked_out(node: ast.expr, compute: Callable[[], sp.Expr]) -> sp.Expr:
    try:
        return compute()
    except _Refused as error:
        raise EffectError(f"{quoted(ast.unparse(node))} {error}") from None


def _applied(
    node: ast.expr, values: list[sp.Expr], apply: Callable[..., Any], on_numbers: Callable[..., Any]
) -> sp.Expr:
    """Return the result of an operation: a number if the operands are numbers, else an expression of limited size."""
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Pow):
        _refuse_power(*values)
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Div) and values[1].is_zero:
        raise _Refused("divides by 0")
    if all(value.is_Number for value in values):
        return _of_numbers(on_numbers, [_plain(value) for value in values])
    # SymPy simplifies sqrt(x**2) to Abs(x); `absolute` has a derivative at 0.
    made = sp.sympify(apply(*values)).replace(sp.Abs, absolute)
    return _settled(made)


def _refuse_power(base: sp.Expr, power: sp.Expr) -> None:
    if power.is_Number and abs(power) > HIGHEST_POWER:
        raise _Refused(f"has a power of {float(power):.9g}: it is too high")
    if base.is_Number and base <= 0 and not power.is_Number:
        raise _Refused("has a variable power of a base that is not positive")


def _of_numbers(apply: Callable[..., Any], values: list[Fraction | float]) -> sp.Expr:
    try:
        return _number(apply(*values))
    except ZeroDivisionError:
        raise _Refused("divides by 0") from None
    except OverflowError:
        raise _Refused("is too large") from None
    except ValueError as error:
        raise error if isinstance(error, _Refused) else _Refused("has no real value") from None


def _plain(number: sp.Expr) -> Fraction | float:
    return Fraction(int(number.p), int(number.q)) if number.is_Rational else float(number)


def _number(value: Any) -> sp.Expr:
    """Return an int, a Fraction or a float as a number of a formula if it is within the limits."""
    if isinstance(value, complex):
        raise _Refused("has no real value")
    if value == 0:
        return sp.Integer(0)
    if not 1 / LARGEST <= abs(value) <= LARGEST:
        raise _Refused(f"is not 0 and not between 1/{LARGEST:g} and {LARGEST:g} in size")
    if isinstance(value, float):
        return sp.Float(value)
    exact = Fraction(value)
    small = max(abs(exact.numerator), exact.denominator) <= LARGEST
    return sp.Rational(exact.numerator, exact.denominator) if small else sp.Float(float(exact))


def _settled(expression: sp.Expr) -> sp.Expr:
    """Return an expression with constant parts evaluated, or reject it if it exceeds the limits."""
    parts = 0
    constants: dict[sp.Expr, sp.Expr] = {}
    level = [expression]
    for _ in range(DEEPEST):
        below: list[sp.Expr] = []
        for node in level:
            parts += 1
            if node.is_Symbol:
                continue
            if node.is_Number and node.is_finite:
                _number(_plain(node))
            elif node.args and all(argument.is_Number for argument in node.args):
                constants[node] = _constant(node)
            elif node.is_Atom:
                raise _Refused("has no real value")
            else:
                if node.is_Pow:
                    _refuse_power(*node.args)
                below += node.args
        level = below
    if level or parts > MAX_PARTS:
        raise _Refused("is too large when expanded")
    return expression.xreplace(constants) if constants else expression


def _constant(node: sp.Expr) -> sp.Expr:
    """Return the value of a power of numbers, which SymPy separates: sqrt(2) from sqrt(2*x)."""
    if not node.is_Pow:
        raise _Refused("has a constant part: enter its value")
    _refuse_power(*node.args)
    base, power = (_plain(argument) for argument in node.args)
    return _of_numbers(operator.pow, [base, power])
