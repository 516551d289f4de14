"""A formula as text and back: arithmetic, a few functions, names; nothing that could run."""

from __future__ import annotations

import ast
import operator
from collections.abc import Callable
from typing import Any

import sympy as sp

from ..errors import EffectError, nearest
from ..functions import absolute, sgn, sgn1

FUNCTIONS: dict[str, Any] = {
    "sin": sp.sin, "cos": sp.cos, "tan": sp.tan, "atan": sp.atan, "exp": sp.exp, "log": sp.log, "sqrt": sp.sqrt,
    "tanh": lambda x: 1 - 2 / (sp.exp(2 * x) + 1), "abs": absolute, "absolute": absolute, "sgn": sgn, "sgn1": sgn1,
}  # fmt: skip
OPERATORS: dict[type[ast.operator], Callable[[Any, Any], Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Pow: operator.pow,
}


def formula(text: str, place: str) -> sp.Expr:
    """Return the expression that a text describes.

    Parameters
    ----------
    text : str
        ``1 + TMU1*(T - TREF)``: + - * / **, brackets, and the functions of `FUNCTIONS`.
    place : str
        Where it stands, for messages.

    Returns
    -------
    sympy.Expr
        Every name is a real symbol.

    Raises
    ------
    EffectError
        If the text is no formula.

    Examples
    --------
    >>> formula("1 + 2*TMU1*abs(T)", "example")
    2*TMU1*absolute(T) + 1
    """
    try:
        tree = ast.parse(text.strip(), mode="eval")
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        raise EffectError(f"{place}: {text!r} is not a formula") from None
    try:
        return sp.sympify(_read(tree.body, place))
    except (RecursionError, OverflowError, ZeroDivisionError):
        raise EffectError(f"{place}: {text!r} cannot be worked out") from None


def formula_text(expression: sp.Expr) -> str:
    """Return the text of an expression, which `formula` reads."""
    return str(sp.sstr(expression, full_prec=False))


def _read(node: ast.expr, place: str) -> Any:
    if isinstance(node, ast.Constant) and isinstance(node.value, (int, float)) and not isinstance(node.value, bool):
        return sp.Integer(node.value) if isinstance(node.value, int) else sp.Float(repr(node.value))
    if isinstance(node, ast.Name):
        return sp.pi if node.id == "pi" else sp.Symbol(node.id, real=True)
    if isinstance(node, ast.UnaryOp) and isinstance(node.op, (ast.USub, ast.UAdd)):
        value = _read(node.operand, place)
        return -value if isinstance(node.op, ast.USub) else value
    if isinstance(node, ast.BinOp) and type(node.op) in OPERATORS:
        left, right = _read(node.left, place), _read(node.right, place)
        if isinstance(node.op, ast.Pow) and right.is_Number and abs(right) > 99:
            raise EffectError(f"{place}: a power of {right} is too high")
        return OPERATORS[type(node.op)](left, right)
    if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and len(node.args) == 1 and not node.keywords:
        if node.func.id not in FUNCTIONS:
            raise EffectError(f"{place}: unknown function {node.func.id!r}{nearest(node.func.id, FUNCTIONS)}")
        return FUNCTIONS[node.func.id](_read(node.args[0], place))
    raise EffectError(f"{place}: {ast.unparse(node)!r} has no place in a formula")
