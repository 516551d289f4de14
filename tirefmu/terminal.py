"""What the command line shows: progress, tables, results."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import partial
from typing import TYPE_CHECKING, Any

from rich.console import Console
from rich.table import Table
from rich.text import Text

from tirefmu.symbolic.escaping import visible
from tirefmu.tires import Tire

from .fit_tables import fit_lines, plain_table

if TYPE_CHECKING:
    from tirefmu.fitting import FitResult
    from tirefmu.fitting.solvers.interruption import Progress


class Terminal:
    r"""Standard output for results, standard error for progress; both silent when quiet.

    Text may come from a file: markup and emoji codes in it mean nothing, and what is not printable is shown as an
    escape sequence, so that a line stays one line.

    Parameters
    ----------
    quiet : bool

    Examples
    --------
    >>> Terminal().print("[bold]\x1b[2J run :bomb:.csv")
    [bold]\x1b[2J run :bomb:.csv
    >>> Terminal(quiet=True).print("nothing comes")
    """

    def __init__(self, quiet: bool = False) -> None:
        # Tables in a file or a pipe need not squeeze into a terminal's 80 columns.
        width = None if sys.stdout.isatty() else 140
        console = partial(Console, quiet=quiet, highlight=False, markup=False, emoji=False)
        self._out = console(soft_wrap=True, width=width)
        self._status = console(stderr=True)

    def print(self, *lines: str) -> None:
        """Print lines, each as it stands."""
        for line in lines:
            self._out.print(visible(line))

    def heading(self, title: str, text: str) -> None:
        """Print the first line of a part of the output."""
        self._out.print(Text.assemble((visible(title), "bold"), " ", visible(text)))

    @contextmanager
    def working(self, what: str) -> Iterator[None]:
        """Show what is going on while it goes on."""
        with self._status.status(visible(what)):
            yield

    @contextmanager
    def fitting(self) -> Iterator[Progress]:
        """Show stage, iteration and cost of a fit while it goes on."""
        with self._status.status("fitting") as status:

            def progress(stage: str, iteration: int, cost: float) -> None:
                status.update(f"{visible(stage)}: iteration {iteration}, cost {cost:.6g}")

            yield progress

    def fit_result(self, result: FitResult) -> None:
        """Print a fit: what it found, how good it is, what it keeps, what the data say of it, and how it ended."""
        for line in fit_lines(result):
            if isinstance(line, Table):
                self._out.print(line)
            else:
                self.print(line)

    def tire(self, tire: Tire, told: Mapping[str, Any], every: bool = False) -> None:
        """Print what is in a tire, as `describe` told it; every coefficient and every kept key on request."""
        side = f", {told['side']} side" if told["side"] else ""
        lines = [f"{told['name']}: {told['title']} ({told['model']}), coefficients in {told['signs']}{side}"]
        lines += [f"  {key}: {text}" for key, text in told["about"].items()]
        for name, value in told["nominal"].items():
            low, high = told["ranges"].get(name, (None, None))
            known = f", known for {low:g} .. {high:g}" if low is not None else ""
            unit = _unit(tire, name)
            lines.append(f"  {name}: nominal {value:g}{'' if unit == '1' else ' ' + unit}{known}")
        for key, title in (
            ("effects", "effects"),
            ("effects_at_neutral", "effects whose coefficients are all at neutral"),
            ("effects_absent", "effects left out"),
        ):
            if told[key]:
                lines.append(f"  {title}: {', '.join(told[key])}")
        lines += _about_the_file(told, every)
        self.print(*lines)
        if told["implausible"]:
            self._out.print(_doubts(told))
        self._out.print(_values(tire, told, every))
        if not every:
            self.print("--all lists every coefficient, what was assumed for missing ones, and what else the file holds")


def _unit(tire: Tire, name: str) -> str:
    return next(quantity.unit for quantity in tire.book.inputs if quantity.name == name)


def _about_the_file(told: Mapping[str, Any], every: bool) -> list[str]:
    lines = [f"  {note}" for note in told["notes"]]
    names = ", ".join(told["missing"]) if every else f"{len(told['missing'])} coefficients"
    lines += [f"  missing in the file, as its readers assume: {names}"] if told["missing"] else []
    unknown = [f"{e['key']} (near {e['near']})" if e["near"] else e["key"] for e in told["unknown"]]
    lines += [f"  unknown keys: {', '.join(unknown)}"] if unknown else []
    if every:
        unused = ", ".join(f"{entry['key']} = {entry['value']}" for entry in told["unused"])
        lines += [f"  kept, not read by this model: {unused}"] if unused else []
        lines += [f"  kept tables: {', '.join(told['tables'])}"] if told["tables"] else []
    return lines


def _doubts(told: Mapping[str, Any]) -> Table:
    table = plain_table("", "value", "what is wrong", title="Implausible")
    for doubt in told["implausible"]:
        value = "nan" if doubt["value"] is None else f"{doubt['value']:.6g}"
        table.add_row(doubt["name"], value, doubt["reason"])
    return table


def _values(tire: Tire, told: Mapping[str, Any], every: bool) -> Table:
    """Return the coefficients: those that somebody gave and that do something, or all."""
    table = plain_table("coefficient", "value", "unit", "", "what it is")
    for name, card in tire.book.coefficients.items():
        origin = "missing" if name in told["missing"] else ""
        if name in told["coefficients_at_neutral"]:
            origin = " ".join([origin, "neutral"]).strip()
        if every or not origin:
            table.add_row(name, f"{tire.values[name]:.6g}", card.unit, origin, card.description)
    return table
