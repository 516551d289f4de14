"""What the command line shows: progress, tables, results."""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from rich.console import Console
from rich.markup import escape
from rich.table import Table

from tirefmu.tires import Tire

if TYPE_CHECKING:
    from tirefmu.fitting import FitResult
    from tirefmu.fitting.session import Progress


class Terminal:
    """Standard output for results, standard error for progress; both silent when quiet.

    Parameters
    ----------
    quiet : bool

    Examples
    --------
    >>> Terminal(quiet=True).print("nothing comes")
    """

    def __init__(self, quiet: bool = False) -> None:
        # Tables in a file or a pipe need not squeeze into a terminal's 80 columns.
        width = None if sys.stdout.isatty() else 140
        self._out = Console(quiet=quiet, highlight=False, soft_wrap=True, width=width)
        self._status = Console(quiet=quiet, stderr=True, highlight=False)

    def print(self, text: str) -> None:
        """Print a line as it stands: names of files may hold brackets."""
        self._out.print(text, markup=False)

    def heading(self, title: str, text: str) -> None:
        """Print the first line of a part of the output."""
        self._out.print(f"[bold]{title}[/bold] {text}")

    @contextmanager
    def working(self, what: str) -> Iterator[None]:
        """Show what is going on while it goes on."""
        with self._status.status(escape(what)):
            yield

    @contextmanager
    def fitting(self) -> Iterator[Progress]:
        """Show stage, iteration and cost of a fit while it goes on."""
        with self._status.status("fitting") as status:

            def progress(stage: str, iteration: int, cost: float) -> None:
                status.update(f"{escape(stage)}: iteration {iteration}, cost {cost:.6g}")

            yield progress

    def fit_result(self, result: FitResult) -> None:
        """Print a fit: coefficients, quality, constraints, stages, notes."""
        self._out.print(_coefficients(result))
        self._out.print(_channels(result))
        self._out.print(_stages(result))
        self._out.print(_margins(result))
        for note in result.notes:
            self.print(f"note: {note}")
        self.print(f"fit {result.status} ({result.method}), {result.seconds:.1f} s")

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
        self.print("\n".join(lines))
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
    table = _table("", "value", "what is wrong", title="Implausible")
    for doubt in told["implausible"]:
        value = "nan" if doubt["value"] is None else f"{doubt['value']:.6g}"
        table.add_row(doubt["name"], value, doubt["reason"])
    return table


def _values(tire: Tire, told: Mapping[str, Any], every: bool) -> Table:
    """Return the coefficients: those that somebody gave and that do something, or all."""
    table = _table("coefficient", "value", "unit", "", "what it is")
    for name, card in tire.book.coefficients.items():
        origin = "missing" if name in told["missing"] else ""
        if name in told["coefficients_at_neutral"]:
            origin = " ".join([origin, "neutral"]).strip()
        if every or not origin:
            table.add_row(name, f"{tire.values[name]:.6g}", card.unit, origin, card.description)
    return table


def _table(*columns: str, title: str = "") -> Table:
    table = Table(title=title or None, title_justify="left", box=None, pad_edge=False, header_style="bold")
    for column in columns:
        numeric = column not in (
            "coefficient",
            "unit",
            "what it is",
            "what is wrong",
            "stage",
            "recording",
            "channel",
            "constraint",
            "at",
            "",
        )
        table.add_column(column, justify="right" if numeric else "left")
    return table


def _coefficients(result: FitResult) -> Table:
    table = _table(
        "coefficient", "guess", "lower", "upper", "value", "unit", "", title=f"Coefficients ({result.signs} signs)"
    )
    for c in result.coefficients:
        remark = "at bound" if c.at_bound else "" if c.determined else "not determined"
        table.add_row(c.name, *(f"{v:.5g}" for v in (c.guess, c.lower, c.upper, c.value)), c.unit, remark)
    return table


def _channels(result: FitResult) -> Table:
    table = _table("recording", "channel", "rows", "RMSE", "unit", "R2", "R2 uncentred", title="Quality")
    for c in result.channels:
        table.add_row(
            escape(c.recording), c.channel, f"{c.rows}", f"{c.rmse:.4g}", c.unit, f"{c.r2:.5f}", f"{c.r2_uncentred:.5f}"
        )
    return table


def _stages(result: FitResult) -> Table:
    table = _table(
        "stage", "rows", "free", "iterations", "R2 uncentred", "", title=f"Stages of recipe {escape(result.recipe)}"
    )
    for s in result.stages:
        reason = "" if s.converged else s.reason
        table.add_row(escape(s.name), f"{s.rows}", f"{s.free}", f"{s.iterations}", f"{s.r2_uncentred:.5f}", reason)
    return table


def _margins(result: FitResult) -> Table:
    table = _table("constraint", "tightest", "margin", "at", title="Constraints, verified over the operating range")
    for m in result.margins:
        table.add_row(
            m.constraint, f"{m.worst:.4g}", f"{m.margin:.3g}", ", ".join(f"{k} {v:.3g}" for k, v in m.at.items())
        )
    return table
