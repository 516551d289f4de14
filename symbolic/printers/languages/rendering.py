"""Printouts from templates: a language is a printer of expressions, a layout of statements, and templates of its files.

The templates are in the folder `templates`, in the syntax of Jinja with delimiters that no language has:
``<@ value @>`` and ``<% block %>``. Texts of a file of the user pass the filter `remark`, which makes comments of them,
or `escaped`.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from itertools import accumulate
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined, pass_context
from jinja2.runtime import Context

from ...functions import SMALLEST_SQUARE
from ..definitions import IEEE_ONLY
from ..routines import Routine
from .layout import Layout, wrapped
from .program import TOLERANCE, PrintedProgram


@dataclass(frozen=True)
class Function(Routine):
    """A routine in a language.

    - `first`: index of its first result among those of all functions.
    """

    program: PrintedProgram = field(kw_only=True)
    layout: Layout = field(kw_only=True)
    first: int = 0

    @property
    def type(self) -> str:
        """Name of a type, such as JacobianInputs."""
        return "".join(word.capitalize() for word in self.name.split("_"))

    @property
    def is_matrix(self) -> bool:
        """Whether there is a row of results for each force."""
        return self.name.startswith("jacobian_")

    @property
    def n_rows(self) -> int:
        """Number of rows of a matrix."""
        return len(self.results)

    @property
    def size(self) -> int:
        """Number of results."""
        return sum(map(len, self.results))

    @property
    def tolerance(self) -> str:
        """Largest accepted relative difference, as a number of the language."""
        return repr(TOLERANCE[self.name])

    @cached_property
    def inputs(self) -> list[str]:
        """The inputs that it reads."""
        return self.uses(self.program.input_names)

    @cached_property
    def coefficients(self) -> list[str]:
        """The coefficients that it reads."""
        return self.uses(list(self.program.coefficients))

    @property
    def statements(self) -> str:
        """Its statements, indented."""
        return self.layout.statements(self)

    @property
    def assigned(self) -> list[str]:
        """Names of the local variables."""
        return [str(assignment.symbol) for assignment in self.body]

    @property
    def values(self) -> list[str]:
        """Its results as expressions, row by row."""
        return self.layout.values(self)

    def rows(self, row: str) -> list[str]:
        """Return the rows of a matrix as lines, each in the brackets of the language."""
        return self.layout.rows(self, row)


@dataclass(frozen=True)
class PrintedValue:
    """An input, an output or a coefficient: name, value, unit, description, and the last two in one text."""

    name: str
    unit: str
    description: str
    value: float = 0.0

    @property
    def about(self) -> str:
        """Description and unit."""
        return f"{self.description} [{self.unit}]"


def function_of(routine: Routine, program: PrintedProgram, layout: Layout, first: int = 0) -> Function:
    """Return a routine of a program in a language."""
    return Function(**vars(routine), program=program, layout=layout, first=first)


def functions_of(program: PrintedProgram, layout: Layout) -> list[Function]:
    """Return the functions of a program in a language."""
    begins = accumulate((sum(map(len, routine.results)) for routine in program.routines), initial=0)
    placed = zip(program.routines, begins, strict=False)
    return [function_of(routine, program, layout, first) for routine, first in placed]


def render(
    program: PrintedProgram,
    layout: Layout,
    templates: Mapping[str, str],
    filters: Mapping[str, Any] | None = None,
    **more: Any,
) -> dict[str, str]:
    """Return the files of a printout, with its data: text by file name.

    `templates`: template by file name, in which ``{}`` is the name of the program. `filters`: further filters of the
    templates. `more`: further variables; they replace those of `variables`.
    """
    environment = _environment(layout)
    environment.filters |= filters or {}
    content = {**variables(program, layout), **more}
    rendered = {
        file.format(program.name): environment.get_template(f"{template}.jinja").render(content)
        for file, template in templates.items()
    }
    return rendered | program.data_files()


@lru_cache(maxsize=16)
def _environment(layout: Layout) -> Environment:
    """Return the templates for a layout, compiled when they are first read."""
    environment = Environment(
        loader=FileSystemLoader(Path(__file__).parent / "templates"), undefined=StrictUndefined, autoescape=False,
        variable_start_string="<@", variable_end_string="@>", block_start_string="<%", block_end_string="%>",
        comment_start_string="<#", comment_end_string="#>", trim_blocks=True, lstrip_blocks=True,
        keep_trailing_newline=True,
    )  # fmt: skip
    environment.filters |= {
        "remark": layout.remark,
        "escaped": layout.escape,
        "broken": lambda code: "\n".join(layout.lines(code)),
        "wrapped": _wrapped,
        "text": repr,
        "quoted": lambda name: f'"{name}"',
        "result": _result,
    }
    return environment


@pass_context
def _result(context: Context, name: str) -> PrintedValue:
    """Return an output or the result of a line by its name."""
    result: PrintedValue = context["results"][name]
    return result


def _wrapped(items: Iterable[str], width: int = 100) -> str:
    """Return items in lines of a width, without blanks at their ends."""
    return "\n".join(line.rstrip() for line in wrapped(list(items), width))


def variables(program: PrintedProgram, layout: Layout) -> dict[str, Any]:
    """Return the variables that every template has."""
    declared, functions = program.model.coefficients, functions_of(program, layout)
    inputs = [PrintedValue(q.name, q.unit, q.description, program.nominal[q.name]) for q in program.inputs]
    outputs = [PrintedValue(q.name, q.unit, q.description) for q in program.outputs]
    lines = [PrintedValue(str(line.symbol), line.unit, line.description) for line in program.lines]
    return {
        "program": program,
        "smallest_square": SMALLEST_SQUARE,
        "ieee_only": IEEE_ONLY,
        "name": program.name,
        "title": program.model.title,
        "head": layout.head(program.header),
        "short_head": layout.head(program.header[:1]),
        "in_file": program.placement == "file",
        "in_struct": program.placement == "struct",
        "check_file": program.check_file,
        "values_file": program.values_file,
        "inputs": inputs,
        "outputs": outputs,
        "coefficients": [
            PrintedValue(name, declared[name].unit, declared[name].description, value)
            for name, value in program.coefficients.items()
        ],
        "results": {result.name: result for result in (*outputs, *lines)},
        "functions": functions,
        "n_results": sum(function.size for function in functions),
    }
