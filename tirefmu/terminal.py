"""Output of the command line: progress, tables, results."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import AbstractContextManager
from functools import partial
from typing import TYPE_CHECKING, Any

from rich.console import Console
from rich.table import Table
from rich.text import Text

from tirefmu.boundary.escaping import visible
from tirefmu.tires import Tire

from . import progress
from .fit_tables import fit_lines, plain_table, verdict_lines

if TYPE_CHECKING:
    from tirefmu.fitting import FitResult
    from tirefmu.measurements import Finding, Recording


class Terminal:
    r"""Standard output for results, standard error for progress; both silent when quiet.

    Text may come from a file: markup and emoji codes are printed literally, and characters that are not printable as
    escape sequences, so that a line remains one line.

    >>> Terminal().print("[bold]\x1b[2J run :bomb:.csv")
    [bold]\x1b[2J run :bomb:.csv
    >>> Terminal(quiet=True).print("no output")
    """

    def __init__(self, quiet: bool = False) -> None:
        # Tables in a file or a pipe are not limited to a terminal's 80 columns.
        width = None if sys.stdout.isatty() else 140
        console = partial(Console, quiet=quiet, highlight=False, markup=False, emoji=False)
        self._out = console(soft_wrap=True, width=width)
        self._status = console(stderr=True, soft_wrap=True)

    def print(self, *lines: str) -> None:
        """Print lines literally."""
        for line in lines:
            self._out.print(visible(line))

    def heading(self, title: str, text: str) -> None:
        """Print the heading of a part of the output."""
        self._out.print(Text.assemble((visible(title), "bold"), " ", visible(text)))

    def working(self, what: str) -> AbstractContextManager[object]:
        """Show the current activity until it ends."""
        return progress.showing(self._status, what)

    def begin(self, line: str) -> None:
        """Print a line of progress."""
        self._status.print(visible(line))

    def counting(
        self, what: str, *, singly: bool = False, expected: tuple[int, float] | None = None
    ) -> AbstractContextManager[Callable[[int, int], None]]:
        """Show how many parts of a computation are finished, and the time left (`progress.counting`)."""
        return progress.counting(self._status, what, singly=singly, expected=expected)

    def fitting(self) -> AbstractContextManager[progress.FitProgress]:
        """Show stage, iteration and cost of a running fit, and the time left."""
        return progress.fitting(self._status)

    def stages(self, stages: Sequence[tuple[str, float]]) -> AbstractContextManager[progress.Stages]:
        """Show stages whose names and work are known, and the time left."""
        return progress.showing_stages(self._status, stages)

    def selection(self, *recordings: Recording) -> None:
        """Print how many rows of each recording were selected, if rows were selected."""
        for recording in recordings:
            if count := recording.about.get("selected"):
                self.print(f"{recording.source}: {count}")

    def table(self, title: str, content: tuple[Sequence[str], Sequence[Sequence[str]]], *, most: int = 1000) -> None:
        """Print a table of texts; rows beyond the limit are counted."""
        if self._out.quiet:
            return  # rendering takes longer than an inspection
        header, rows = content
        table = plain_table(*header, title=title)
        for row in rows[:most]:
            table.add_row(*row)
        self._out.print(table)
        if len(rows) > most:
            self.print(f"and {len(rows) - most} more (--all lists them)")

    def findings(self, findings: Iterable[Finding]) -> None:
        """Print findings about the data: a serious one as a warning, any other as a note."""
        for finding in findings:
            if finding.serious:
                self._out.print(Text.assemble(("warning: ", "bold red"), visible(str(finding))))
            else:
                self.print(f"note: {finding}")

    def fit_result(self, result: FitResult, every: bool = False) -> None:
        """Print a fit: verdict, findings about the data, goodness of fit, what is not determined, and status.

        With `every` also all coefficients, constraints and stages.
        """
        self.print(*verdict_lines(result.verdict))
        self.findings(result.data_findings)
        for line in fit_lines(result, every):
            if isinstance(line, Table):
                self._out.print(line)
            else:
                self.print(line)

    def tire(self, tire: Tire, summary: Mapping[str, Any], every: bool = False) -> None:
        """Print the summary of a tire from `describe`; with `every` all coefficients and unused keys."""
        side = f", {summary['side']} side" if summary["side"] else ""
        lines = [
            f"{summary['name']}: {summary['title']} ({summary['model']}), coefficients in {summary['signs']}{side}"
        ]
        lines += [f"  {key}: {text}" for key, text in summary["about"].items()]
        for name, value in summary["nominal"].items():
            low, high = summary["ranges"].get(name, (None, None))
            valid = f", valid from {low:g} to {high:g}" if low is not None else ""
            unit = _unit(tire, name)
            lines.append(f"  {name}: nominal {value:g}{'' if unit == '1' else ' ' + unit}{valid}")
        for key, title in (
            ("effects", "effects"),
            ("effects_at_neutral", "effects with all coefficients neutral"),
            ("effects_absent", "absent effects"),
        ):
            if summary[key]:
                lines.append(f"  {title}: {', '.join(summary[key])}")
        lines += _about_the_file(summary, every)
        self.print(*lines)
        if summary["implausible"]:
            self._out.print(_doubts(summary))
        self._out.print(_values(tire, summary, every))
        if not every:
            self.print("--all lists every coefficient, assumed values, and other contents of the file")


def _unit(tire: Tire, name: str) -> str:
    return next(quantity.unit for quantity in tire.symbolic_model.inputs if quantity.name == name)


def _about_the_file(summary: Mapping[str, Any], every: bool) -> list[str]:
    lines = [f"  {note}" for note in summary["notes"]]
    names = ", ".join(summary["missing"]) if every else f"{len(summary['missing'])} coefficients"
    lines += [f"  missing in the file, default values assumed: {names}"] if summary["missing"] else []
    assumed = ", ".join(f"{name} = {value:g}" for name, value in summary["assumed"].items())
    lines += [f"  assumed, not measured: {assumed}"] if assumed else []
    unknown = [f"{e['key']} (near {e['near']})" if e["near"] else e["key"] for e in summary["unknown"]]
    lines += [f"  unknown keys: {', '.join(unknown)}"] if unknown else []
    ignored = ", ".join(f"{entry['key']} = {entry['value']}" for entry in summary["ignored"])
    lines += [f"  given but ignored by {summary['model']}: {ignored}"] if ignored else []
    if every:
        unused = ", ".join(f"{entry['key']} = {entry['value']}" for entry in summary["unused"])
        lines += [f"  known keys that this model does not read: {unused}"] if unused else []
        lines += [f"  other tables: {', '.join(summary['tables'])}"] if summary["tables"] else []
    return lines


def _doubts(summary: Mapping[str, Any]) -> Table:
    table = plain_table("", "value", "problem", title="Implausible values")
    for doubt in summary["implausible"]:
        value = "nan" if doubt["value"] is None else f"{doubt['value']:.6g}"
        table.add_row(doubt["name"], value, doubt["reason"])
    return table


def _values(tire: Tire, summary: Mapping[str, Any], every: bool) -> Table:
    """Return the coefficients: those that are given and not neutral, or all."""
    table = plain_table("coefficient", "value", "unit", "", "description")
    for name, declared in tire.symbolic_model.coefficients.items():
        origin = "missing" if name in summary["missing"] else ""
        if name in summary["coefficients_at_neutral"]:
            origin = " ".join([origin, "neutral"]).strip()
        if every or not origin:
            table.add_row(name, f"{tire.values[name]:.6g}", declared.unit, origin, declared.description)
    return table
