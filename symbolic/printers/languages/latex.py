"""The book of equations of a tire in LaTeX: every line with number, symbol and unit, effects, coefficients."""

from __future__ import annotations

import re
from itertools import groupby

import sympy as sp
from sympy.printing.latex import LatexPrinter

from tirefmu.boundary.escaping import latex_text, line_comment

from ...notation import Equation
from .layout import Layout, filled
from .program import Program

LAYOUT = Layout(LatexPrinter(), "", "% {}", line_comment)

#: Words in names of quantities that are Greek letters.
_GREEK = ("alpha", "gamma", "kappa", "mu", "sigma", "rho", "omega", "phi", "psi", "zeta", "eps", "theta")

_DOCUMENT = r"""@head@
%
% Usage: pdflatex @name@.tex (packages amsmath and longtable). Self-test: the file must compile without an error; the
% equations are those of the code in the other languages, whose self-tests compare numbers (@name@_selftest.txt has the
% rows).
\documentclass[10pt]{article}
\usepackage[a4paper,margin=20mm]{geometry}
\usepackage{amsmath,longtable}
\allowdisplaybreaks
\setlength{\parindent}{0pt}
\begin{document}
\section*{@title@}
@about@

\subsection*{Inputs}
\begin{longtable}{lll}
@inputs@
\end{longtable}

\subsection*{Effects}
\begin{longtable}{lp{120mm}}
@effects@
\end{longtable}
@chapters@
@coefficients@
\end{document}
"""


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
    text = re.sub("|".join(_GREEK), lambda found: rf"\{found[0]} ".replace("eps", "varepsilon"), word)
    return text.strip()


def files(program: Program) -> dict[str, str]:
    """Return the document and the rows of the self-test: text by file name."""
    model = program.model
    effects = [(name, model.effects[name].physics) for name in program.effects]
    values = {
        "head": LAYOUT.head(program.header),
        "name": program.name,
        "title": latex_text(model.title),
        "about": "\n\n".join(latex_text(line) for line in program.header[1:2] + program.header[-4:]),
        "inputs": _rows((f"${symbol_text(q.name)}$", latex_text(q.unit), latex_text(q.description))
                        for q in program.inputs),
        "effects": _rows((rf"\texttt{{{latex_text(name)}}}", latex_text(text)) for name, text in effects),
        "chapters": "\n".join(_chapter(title, list(lines)) for title, lines in
                              groupby(program.lines, lambda line: line.chapter)),
        "coefficients": _coefficients(program),
    }  # fmt: skip
    return {f"{program.name}.tex": filled(_DOCUMENT, values), **program.data_files()}


def _rows(cells: object) -> str:
    return "\n".join(" & ".join(row) + r" \\" for row in cells)  # type: ignore[attr-defined]


def _chapter(title: str, lines: list[Equation]) -> str:
    """Return the equations of a chapter, each with its number, description and unit."""
    printer = BookPrinter()
    text = []
    for line in lines:
        about = latex_text(line.description or "step") + (f" [{latex_text(line.unit)}]" if line.named else "")
        text.append(rf"\textit{{{about}}}")
        text.append(r"\begin{equation}")
        text.append(rf"{printer.doprint(line.symbol)} = {printer.doprint(line.expression)}")
        text.append(rf"\tag{{{latex_text(line.number)}}}")
        text.append(r"\end{equation}")
    body = "\n".join(text)
    return f"\n\\subsection*{{{latex_text(title)}}}\n{body}"


def _coefficients(program: Program) -> str:
    """Return the tables of coefficients by section, with their values."""
    declared = program.model.coefficients
    parts = [r"\subsection*{Coefficients}"] if program.coefficients else []
    for section, names in groupby(program.coefficients, lambda name: declared[name].section):
        rows = [
            (f"${symbol_text(name)}$", f"{program.coefficients[name]:.8g}" if program.placement == "struct" else "",
             latex_text(declared[name].unit), latex_text(declared[name].description))
            for name in names
        ]  # fmt: skip
        title = rf"\multicolumn{{4}}{{l}}{{\textbf{{{latex_text(section)}}}}}\\"
        parts.append(f"\\begin{{longtable}}{{lrlp{{90mm}}}}\n{title}\n{_rows(rows)}\n\\end{{longtable}}")
    return "\n".join(parts)
