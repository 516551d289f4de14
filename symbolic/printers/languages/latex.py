"""The book of equations of a tire in LaTeX: every line with number, symbol and unit, effects, coefficients."""

from __future__ import annotations

import re
from itertools import groupby

import sympy as sp
from sympy.printing.latex import LatexPrinter

from ....boundary.escaping import latex_text, line_comment
from .layout import Layout
from .program import PrintedProgram
from .rendering import render

LAYOUT = Layout(LatexPrinter(), "", "% {}", line_comment)

#: Words in names of quantities that are Greek letters.
_GREEK = ("alpha", "gamma", "kappa", "mu", "sigma", "rho", "omega", "phi", "psi", "zeta", "eps", "theta")


class BookPrinter(LatexPrinter):
    r"""LaTeX of the lines, with symbols as a book prints them.

    >>> BookPrinter().doprint(sp.Symbol("K_yalpha") * sp.sin(2 * sp.Symbol("PKY2")))
    'K_{y\\alpha} \\sin{\\left(2 \\mathrm{PKY2} \\right)}'
    """

    def _print_Symbol(self, expr: sp.Symbol, style: str = "plain") -> str:
        return symbol_text(expr.name)

    def _print_Literal(self, expr: sp.Expr, style: str = "plain") -> str:
        text = str(self._print(sp.Float(expr.value)))
        return text if expr.value >= 0 else rf"\left({text}\right)"

    def _print_sgn(self, expr: sp.Expr, exp: str = "") -> str:
        return self._named(r"\operatorname{sgn}", expr, exp)

    def _print_sgn1(self, expr: sp.Expr, exp: str = "") -> str:
        return self._named(r"\operatorname{sgn}_1", expr, exp)

    def _print_absolute(self, expr: sp.Expr, exp: str = "") -> str:
        text = rf"\left|{self._print(expr.args[0])}\right|"
        return f"{text}^{{{exp}}}" if exp else text

    def _named(self, name: str, expr: sp.Expr, exp: str) -> str:
        power = f"^{{{exp}}}" if exp else ""
        return rf"{name}{power}\left({self._print(expr.args[0])}\right)"


def symbol_text(name: str) -> str:
    r"""Return a name as mathematics: coefficients upright, quantities with indices and Greek letters.

    >>> symbol_text("PKY1"), symbol_text("mu_y"), symbol_text("alpha"), symbol_text("F_z01")
    ('\\mathrm{PKY1}', '\\mu_{y}', '\\alpha', 'F_{z01}')
    """
    if re.fullmatch("[A-Z][A-Z0-9_]+", name):
        return rf"\mathrm{{{name}}}".replace("_", r"\_")
    base, *indices = name.split("_")
    letters = _greek(base) if len(base) > 1 and not base.startswith("\\") else base
    if len(base) > 1 and letters == base:
        letters = rf"\mathit{{{base}}}"
    return f"{letters}_{{{','.join(map(_greek, indices))}}}" if indices else letters


def _greek(word: str) -> str:
    text = re.sub("|".join(_GREEK), lambda match: rf"\{match[0]} ".replace("eps", "varepsilon"), word)
    return text.strip()


def files(program: PrintedProgram) -> dict[str, str]:
    """Return the document and the rows of the self-test: text by file name."""
    declared = program.model.coefficients
    sections = groupby(program.coefficients, lambda name: declared[name].section)
    chapters = groupby(program.lines, lambda line: line.chapter)
    filters = {"latex": latex_text, "symbol": symbol_text, "math": BookPrinter().doprint}
    return render(
        program, LAYOUT, {"{}.tex": "latex.tex"}, filters, chapters=chapters,
        sections=[(section, set(names)) for section, names in sections],
    )  # fmt: skip
