"""Equations as MathML, which browsers draw without scripts: for the documentation and for reports."""

from __future__ import annotations

import re
from typing import Any
from unicodedata import lookup

import sympy as sp
from sympy.printing.mathml import MathMLPresentationPrinter

#: Words in names of quantities that are Greek letters.
GREEK = {
    word: lookup(f"GREEK SMALL LETTER {word}".upper())
    for word in ("alpha", "gamma", "kappa", "mu", "sigma", "rho", "omega", "phi", "psi", "zeta", "epsilon", "theta")
}
GREEK["eps"] = GREEK["epsilon"]
_WORDS = re.compile("|".join(GREEK))


class BookMathML(MathMLPresentationPrinter):  # type: ignore[misc,unused-ignore]  # SymPy has no types
    """MathML of the lines, with coefficients upright and quantities with indices and Greek letters."""

    def _print_Symbol(self, expr: sp.Symbol, style: str = "plain") -> Any:
        return self._name(expr.name)

    def _print_Literal(self, expr: Any) -> Any:
        return self._print(sp.Float(expr.value))

    def _print_Float(self, expr: sp.Float) -> Any:
        digits, _, power = f"{float(expr):.8g}".partition("e")
        number = self._leaf("mn", digits)
        if not power:
            return number
        ten = self._with("msup", self._leaf("mn", "10"), self._leaf("mn", str(int(power))))
        return ten if digits == "1" else self._with("mrow", number, self._leaf("mo", "·"), ten)

    def _print_Piecewise(self, expr: sp.Piecewise) -> Any:
        rows = []
        for value, condition in expr.args:
            otherwise = condition == sp.true
            text = self._leaf("mtext", " otherwise" if otherwise else " if ")
            cell = self._with("mtd", text) if otherwise else self._with("mtd", text, self._print(condition))
            rows.append(self._with("mtr", self._with("mtd", self._print(value)), cell))
        return self._with("mrow", self._leaf("mo", "{"), self._with("mtable", *rows))

    def _print_sgn(self, expr: Any) -> Any:
        return self._call(self._leaf("mi", "sgn"), expr)

    def _print_sgn1(self, expr: Any) -> Any:
        return self._call(self._with("msub", self._leaf("mi", "sgn"), self._leaf("mn", "1")), expr)

    def _print_expm1(self, expr: Any) -> Any:
        return self._call(self._leaf("mi", "expm1"), expr)

    def _print_absolute(self, expr: Any) -> Any:
        bar = self._leaf("mo", "|")
        return self._with("mrow", bar, self._print(expr.args[0]), self._leaf("mo", "|"))

    def _call(self, function: Any, expr: Any) -> Any:
        opened, closed = self._leaf("mo", "("), self._leaf("mo", ")")
        return self._with("mrow", function, opened, self._print(expr.args[0]), closed)

    def _name(self, name: str) -> Any:
        """Return a name: a coefficient, or a letter with its indices."""
        if re.fullmatch("[A-Z][A-Z0-9_]+", name):
            leaf = self._leaf("mi", name)
            leaf.setAttribute("mathvariant", "normal")
            return leaf
        base, *indices = name.split("_")
        letter = self._leaf("mi", _greek(base))
        return self._with("msub", letter, self._leaf("mi", ",".join(map(_greek, indices)))) if indices else letter

    def _leaf(self, tag: str, text: str) -> Any:
        element = self.dom.createElement(tag)
        element.appendChild(self.dom.createTextNode(text))
        return element

    def _with(self, tag: str, *children: Any) -> Any:
        element = self.dom.createElement(tag)
        for child in children:
            element.appendChild(child)
        return element


def _greek(word: str) -> str:
    return _WORDS.sub(lambda match: GREEK[match[0]], word)


def equation_mathml(symbol: sp.Symbol | str, expression: sp.Expr) -> str:
    """Return an equation as a MathML element for a page.

    `symbol`: the left-hand side. Returns: one line; texts are escaped.

    >>> equation_mathml("mu_y", 2 * sp.Symbol("PDY1"))[:38]
    '<math display="block"><mrow><msub><mi>'
    """
    printer = BookMathML({"mul_symbol": "dot"})
    left = symbol if isinstance(symbol, sp.Symbol) else sp.Symbol(symbol)
    sides = [printer._print(side).toxml() for side in (left, expression)]
    return f'<math display="block"><mrow>{sides[0]}<mo>=</mo>{sides[1]}</mrow></math>'
