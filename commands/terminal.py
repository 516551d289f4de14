"""Output of the command line: progress, tables, results."""

from __future__ import annotations

import re
import sys
from collections.abc import Iterable, Mapping, Sequence
from functools import partial
from shutil import get_terminal_size
from textwrap import wrap
from typing import TYPE_CHECKING, Any

from rich.console import Console
from rich.table import Table
from rich.text import Text

from ..boundary.escaping import shortened, visible
from ..boundary.terminal_table import plain_table
from ..drawing.labels import drawn_unit, drawn_value
from ..tires import Tire
from . import progress
from .arguments import json_is_printed

if TYPE_CHECKING:
    from ..fitting import FitResult
    from ..measurements import DataFinding, Recording

#: Columns of the output.
LINE = 100
#: Most recordings whose selected rows are printed one by one, and the longest name of one there.
FEW, LONGEST_SOURCE = 3, 60
#: How a line begins whose first word is red.
WARNING = "warning: "
#: Styles of the grades of a result.
GRADES = {"good": "bold green", "limited": "bold yellow", "bad": "bold red"}
#: A command to enter, with the words that introduce it.
COMMAND = re.compile(r"(?:[\w ]{1,40}: |\()?tirefmu [a-z-]+ .*")


def wrapped(text: str) -> list[str]:
    """Return the lines of a printable text, of at most `LINE` columns; a word and a command to enter remain whole.

    >>> [len(line) for line in wrapped("  - " + 40 * "word ")]
    [98, 98, 13]
    """
    if len(text) <= LINE:
        return [text]
    command = COMMAND.search(text)
    begin, end = (text[: command.start()], [command[0].lstrip()]) if command else (text, [])
    later = " " * (len(text) - len(text.lstrip()) + 2)
    lines = wrap(begin, LINE, subsequent_indent=later, break_long_words=False, break_on_hyphens=False)
    return lines + [later * bool(lines) + line for line in end]


class Terminal:
    r"""Standard output for results, standard error for progress; both silent when quiet.

    With ``--json -`` standard output has the JSON only, and the text goes to standard error.

    Text may come from a file: markup and emoji codes are printed literally, and characters that are not printable as
    escape sequences, so that a line remains one line.

    >>> Terminal().print("[bold]\x1b[2J run :bomb:.csv")
    [bold]\x1b[2J run :bomb:.csv
    >>> Terminal(quiet=True).print("no output")
    """

    def __init__(self, quiet: bool = False) -> None:
        width = min(get_terminal_size().columns, LINE) if sys.stdout.isatty() else LINE
        console = partial(Console, quiet=quiet, highlight=False, markup=False, emoji=False)
        self._out = console(soft_wrap=True, width=width, stderr=json_is_printed())
        self._status = console(stderr=True, soft_wrap=True)
        # Each shows progress until the end of its with block.
        self.working = partial(progress.showing, self._status)
        self.counting = partial(progress.counting, self._status)
        self.fitting = partial(progress.fitting, self._status)
        self.stages = partial(progress.showing_stages, self._status)

    def print(self, *lines: str) -> None:
        """Print lines literally."""
        for line in lines:
            self._styled("", line)

    def heading(self, title: str, text: str) -> None:
        """Print the heading of a part of the output."""
        self._styled(visible(title), f" {text}", "bold")

    def graded(self, begin: str, text: str, grade: str) -> None:
        """Print a result whose begin has the color of its grade: "good", "limited" or "bad"."""
        self._styled(begin, text, GRADES[grade])

    def _styled(self, begin: str, text: str, style: str = "") -> None:
        """Print a wrapped text; its printable begin has a style."""
        for number, line in enumerate(wrapped(begin + visible(text))):
            self._out.print(Text.assemble((line[: len(begin)], style), line[len(begin) :]) if number == 0 else line)

    def _warned(self, line: str) -> None:
        """Print a line; the first word of a warning is red."""
        begin = WARNING if line.startswith(WARNING) else ""
        self._styled(begin, line.removeprefix(begin), "bold red")

    def begin(self, line: str) -> None:
        """Print a line of progress."""
        self._status.print(visible(line))

    def selection(self, *recordings: Recording) -> None:
        """Print how many rows of each recording were selected, if rows were selected, and what is not read."""
        counts = [(part.source, part.about["selected"]) for part in recordings if part.about.get("selected")]
        if len(counts) > FEW:
            self.print(f"rows are selected in {len(counts)} recordings")
        else:
            self.print(*(f"{shortened(visible(source), LONGEST_SOURCE)}: {count}" for source, count in counts))
        ignored = list(dict.fromkeys(filter(None, (recording.about.get("ignored", "") for recording in recordings))))
        others = f"; others of {len(ignored) - 1} more" if len(ignored) > 1 else ""
        self.not_read(shortened(visible(ignored[0]), LONGEST_SOURCE) + others if ignored else "")

    def not_read(self, ignored: str) -> None:
        """Print what of a file is not read; nothing without it."""
        if ignored:
            self.print(f"not read: {ignored}")

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

    def findings(self, findings: Iterable[DataFinding]) -> None:
        """Print findings about the data: a serious one as a warning, any other as a note."""
        for finding in findings:
            self._warned(f"{'warning' if finding.serious else 'note'}: {finding}")

    def fit_result(self, result: FitResult, every: bool = False) -> None:
        """Print a fit: the first screen, or with `every` all findings, coefficients, constraints and stages."""
        from ..fitting.reporting.text_tables import fit_lines, short_fit_lines, verdict_lines

        if every:
            self.print(*verdict_lines(result.verdict))
            self.findings(result.data_findings)
        for line in fit_lines(result) if every else short_fit_lines(result, result.verdict):
            if isinstance(line, Table):
                self._out.print(line)
            else:
                self._warned(line)

    def tire(self, tire: Tire, summary: Mapping[str, Any], every: bool = False) -> None:
        """Print the summary of a tire from `describe`; with `every` all coefficients and unused keys."""
        side = f", {summary['side']} side" if summary["side"] else ""
        lines = [
            f"{summary['name']}: {summary['title']} ({summary['model']}), coefficients in {summary['signs']}{side}"
        ]
        lines += [f"  {key}: {text}" for key, text in summary["about"].items()]
        for name, value in summary["nominal"].items():
            low, high = summary["ranges"].get(name, (None, None))
            at, *ends = (f"{drawn_value(name, number):.5g}" for number in (value, low, high) if number is not None)
            unit = drawn_unit(name).replace("-", "")
            lines.append(f"  {name}: nominal {at} {unit}".rstrip() + f", valid from {' to '.join(ends)}" * bool(ends))
        lines.append(f"  UNLOADED_RADIUS: {tire.values['UNLOADED_RADIUS']:g} m")
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
        self._out.print(_characteristics(tire, summary))
        if every:
            self._out.print(_values(tire, summary))
        else:
            self.print("--all lists every coefficient, assumed values, and other contents of the file")


def _about_the_file(summary: Mapping[str, Any], every: bool) -> list[str]:
    lines = [f"  {note}" for note in (*summary["notes"], *summary["not_measured"])]
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


def _characteristics(tire: Tire, summary: Mapping[str, Any]) -> Table:
    """Return friction and slip stiffness over load."""
    lines = summary["characteristics"]
    units = {name: tire.symbolic_model.structure.quantities[name][0] for name in lines[0] if name != "Fz"}
    header = [f"{name} ({unit})".replace("(1)", "(-)") for name, unit in units.items()]
    table = plain_table("load (N)", *header, title="Upright, in pure slip, in ISO-W signs")
    for line in lines:
        table.add_row(
            f"{line['Fz']:g}", *(f"{line[name]:{'.0f' if abs(line[name]) >= 1e3 else '.4g'}}" for name in units)
        )
    return table


def _values(tire: Tire, summary: Mapping[str, Any]) -> Table:
    """Return all coefficients."""
    table = plain_table("coefficient", "value", "unit", "", "description")
    for name, declared in tire.symbolic_model.coefficients.items():
        origin = "missing" if name in summary["missing"] else ""
        if name in summary["coefficients_at_neutral"]:
            origin = " ".join([origin, "neutral"]).strip()
        table.add_row(name, f"{tire.values[name]:.6g}", declared.unit, origin, declared.description)
    return table
