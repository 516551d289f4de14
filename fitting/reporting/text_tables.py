"""Terminal report of a fit: tables and lines of text."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from rich.table import Table

from ...boundary.terminal_table import plain_table

if TYPE_CHECKING:
    from ..results.fitted import Fitted
    from ..results.verdict import Verdict

#: Rows of a table of evidence that are printed without --all.
FEW = 3


def verdict_lines(verdict: Verdict) -> Iterator[str]:
    """Yield the verdict of a fit and its reasons, a line each."""
    yield f"verdict: {verdict.word}"
    for reason in verdict.reasons:
        yield f"  - {reason}"


def fit_lines(result: Fitted, every: bool = True) -> Iterator[Table | str]:
    """Yield the tables and lines of a fit after its verdict, in order; without `every` what needs attention."""
    from .report_text import bootstrap_summary, extrapolation_text, ripple_texts

    yield _channels(result)
    yield from _coefficients(result, every)
    if result.bootstrap:
        yield bootstrap_summary(result.bootstrap)
    if result.held_out:
        yield _held_out(result)
    if result.temperature:
        yield result.temperature.text()
    if result.findings.stiffnesses:
        yield _stiffnesses(result)
    if every or not all(stage.converged for stage in result.stages):
        yield _stages(result)
    if result.margins:
        yield from _margins(result, every)
        yield extrapolation_text(result)
    yield from _differences(result, every)
    yield from ripple_texts(result.findings.ripples)
    for direction in result.findings.undetermined:
        yield f"not identifiable: {', '.join(direction.coefficients)}: {direction.reason}"
    for rows in result.excluded_rows:
        yield f"note: {rows}"
    for note in result.notes:
        yield f"note: {note}"
    yield f"fit {result.status} ({result.run.method}), {result.run.seconds:.1f} s"
    if not every:
        yield "--all lists every coefficient, constraint and stage"


def _coefficients(result: Fitted, every: bool) -> Iterator[Table | str]:
    """Yield the coefficients; without `every` those at a bound or not determined, and those with further intervals."""
    from .report_text import bootstrap_text, interval_text

    further = ["bootstrap (95 %)"] * bool(result.bootstrap)
    table = plain_table(
        "coefficient", "initial", "lower", "upper", "value", "+- (95 %)", *further, "unit", "",
        title=f"Coefficients ({result.signs} signs)",
    )  # fmt: skip
    remarkable = {name for direction in result.findings.undetermined for name in direction.coefficients}
    remarkable |= {c.name for c in result.coefficients if c.other is not None}
    consequences = {consequence.name: consequence.text() for consequence in result.bounds}
    every = every or bool(result.bootstrap)
    for c in result.coefficients:
        if not (every or c.at_bound or c.from_family or not c.determined or c.name in remarkable):
            continue
        remark = (
            f"at bound: {consequences.get(c.name, '')}".rstrip(": ")
            if c.at_bound
            else f"or {c.other:.5g}"
            if c.other is not None
            else "from the family"
            if c.from_family
            else ""
        )
        remark = remark if c.determined or c.at_bound else "not determined"
        numbers = (f"{v:.5g}" for v in (c.guess, c.lower, c.upper, c.value))
        resampled = [bootstrap_text(result, c.name)] * bool(result.bootstrap)
        table.add_row(c.name, *numbers, interval_text(c.interval), *resampled, c.unit, remark)
    if table.row_count:
        yield table
    if not every and (others := len(result.coefficients) - table.row_count):
        yield f"{others} coefficients are determined and not at a bound"


def _channels(result: Fitted) -> Table:
    from .report_text import interval_text, worst_text

    table = plain_table(
        "recording", "channel", "fitted rows", "RMSE", "R2", "all rows", "RMSE", "R2", "unit", "noise floor",
        "largest error", title="Goodness of fit, over the fitted rows and over all rows",
    )  # fmt: skip
    for c in result.channels:
        largest = worst_text(result, c.recording, c.channel)
        table.add_row(
            c.recording, c.channel, f"{c.fitted_rows}", f"{c.fitted_rmse:.4g}", f"{c.fitted_r2:.5f}", f"{c.rows}",
            f"{c.rmse:.4g}", f"{c.r2:.5f}", c.unit, interval_text(c.noise_floor), largest,
        )  # fmt: skip
    return table


def _held_out(result: Fitted) -> Table:
    table = plain_table(
        "recording",
        "channel",
        "rows",
        "RMSE",
        "out of sample",
        "unit",
        "",
        title="Cross-validation over operating conditions",
    )
    for c in result.held_out:
        worse = f"{c.held_out / c.in_sample - 1:+.1%}" if c.in_sample > 0 else ""
        table.add_row(c.recording, c.channel, f"{c.rows}", f"{c.in_sample:.4g}", f"{c.held_out:.4g}", c.unit, worse)
    return table


def _stiffnesses(result: Fitted) -> Table:
    from .load_table import stiffness_by_load

    table = plain_table(
        "recording", "force", "load (N)", "conditions", "data", "tire", "unit", "error",
        title="Slip stiffness: means, and the errors of single conditions",
    )  # fmt: skip
    for recording, channel, load, s in stiffness_by_load(result.findings):
        numbers = f"{s.read:.5g}", f"{s.fitted:.5g}", s.unit, s.error_text
        table.add_row(recording, channel, f"{load:.0f}", f"{s.conditions}", *numbers)
    return table


def _stages(result: Fitted) -> Table:
    table = plain_table(
        "stage", "rows", "free", "iterations", "R2 uncentred", "", title=f"Stages of recipe {result.run.recipe}"
    )
    for s in result.stages:
        reason = "" if s.converged else s.reason
        table.add_row(s.name, f"{s.rows}", f"{s.free}", f"{s.iterations}", f"{s.r2_uncentred:.5f}", reason)
    return table


def _margins(result: Fitted, every: bool) -> Iterator[Table | str]:
    """Yield the constraints; without `every` those that are violated."""
    from ..evidence.residuals import condition_text
    from .report_text import constraint_rows

    table = plain_table(
        "constraint", "value", "margin", "at", "margin outside", "",
        title="Constraints, verified over the operating range (adapted-sae signs)",
    )  # fmt: skip
    rows = constraint_rows(result.margins)
    for c in rows:
        beyond = "" if c.beyond is None else f"{c.beyond.margin:.3g}"
        violated = any(m is not None and m.margin < 0 for m in (c.inside, c.beyond))
        if not (every or violated):
            continue
        table.add_row(
            c.constraint, f"{c.inside.worst:.4g}", f"{c.inside.margin:.3g}", condition_text(c.inside.at), beyond,
            "violated" if violated else "",
        )  # fmt: skip
    if table.row_count:
        yield table
    if not every and (satisfied := len(rows) - table.row_count):
        yield f"{satisfied} physical constraints are satisfied over the operating range"


def _differences(result: Fitted, every: bool) -> Iterator[Table | str]:
    """Yield the differences between data of equal conditions; without `every` the first ones, files before sweeps."""
    from ..evidence.residuals import condition_text
    from .report_text import significant_differences

    differences = significant_differences(result)
    if not differences:
        return
    table = plain_table(
        "first", "second", "channel", "difference", "sigmas", "largest", "unit", "mean difference at",
        title=f"Inconsistent data at equal operating conditions and slips ({result.signs} signs)",
    )  # fmt: skip
    shown = differences if every else differences[:FEW]
    for d in shown:
        table.add_row(
            d.first, d.second, d.channel, f"{d.mean:+.3g}", f"{abs(d.sigmas):.0f}", f"{d.most:+.3g}",
            d.unit, condition_text(d.at),
        )  # fmt: skip
    yield table
    if len(shown) < len(differences):
        yield f"and {len(differences) - len(shown)} more (--all lists them)"
