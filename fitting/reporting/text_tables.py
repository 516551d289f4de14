"""Terminal report of a fit: tables and lines of text."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import accumulate
from math import isfinite
from typing import TYPE_CHECKING

from rich.table import Table

from ...boundary.escaping import shortened
from ...boundary.terminal_table import plain_table
from ...numerics.ties import graded

if TYPE_CHECKING:
    from ..results.fitted import Fitted
    from ..results.verdict import Verdict

#: Reasons, warnings and channels that are printed without --all.
FEW, MOST_CHANNELS = 3, 8
#: What notes on arguments of the user contain: these are printed without --all.
ON_ARGUMENTS = ("does nothing", "nominal R0 = ")
#: Characters of a word in a reason: of the name of a file. The sentence remains whole.
LONGEST_WORD = 40
#: Characters of all reasons, and of all warnings, that are printed without --all: five lines of the terminal.
MOST_TEXT = 510


def verdict_lines(verdict: Verdict) -> Iterator[str]:
    """Yield the verdict of a fit and its reasons, a line each."""
    yield f"verdict: {verdict.word}"
    for reason in verdict.reasons:
        yield f"  - {reason}"


def short_fit_lines(result: Fitted, verdict: Verdict) -> Iterator[Table | str]:
    """Yield the first screen of a fit: verdict, most important reasons and warnings, goodness of fit, the rest."""
    from .report_text import bootstrap_summary

    reasons, findings = [_with_short_names(reason) for reason in verdict.reasons], result.data_findings
    first = sorted((f for f in findings if f.serious or f.effects), key=lambda finding: not finding.serious)
    texts = [_with_short_names(finding.text) for finding in first]
    shown_reasons, shown = _first_that_fit(reasons), first[: len(_first_that_fit(texts))]
    yield f"verdict: {verdict.word}"
    yield from (f"  - {reason}" for reason in shown_reasons)
    for finding, text in zip(shown, texts, strict=False):
        yield f"{'warning' if finding.serious else 'note'}: {replace(finding, text=text)}"
    requested = [note for note in result.notes if any(part in str(note) for part in ON_ARGUMENTS)][:FEW]
    yield from (f"note: {note}" for note in requested)
    yield _short_channels(result)
    determined = sum(c.identified for c in result.coefficients)
    yield f"{determined} of {len(result.coefficients)} coefficients are determined and not at a bound"
    if result.bootstrap:
        yield bootstrap_summary(result.bootstrap)
        yield f"  widest intervals: {_widest(result)}"
    if result.temperature:
        yield result.temperature.text()
    yield f"fit {result.status} ({result.run.method}), {result.run.seconds:.1f} s"
    left_out = [finding.serious for finding in findings if finding not in shown]
    notes = left_out.count(False) + len(result.excluded_rows) + len(result.notes) - len(requested)
    counts = {
        "reasons": len(reasons) - len(shown_reasons), "warnings": left_out.count(True),
        "channels": len(result.channels[MOST_CHANNELS:]), "notes": notes,
    }  # fmt: skip
    further = "".join(f"; further {what}: {count}" for what, count in counts.items() if count)
    yield f"--all lists every coefficient, constraint and stage{further}"


def _with_short_names(text: str) -> str:
    """Return a sentence whose long words, which are names of files, lack their middle.

    >>> _with_short_names(f"corner{'_cold' * 20}.csv: the rows repeat")
    'corner_cold_cold_co...old_cold_cold.csv: the rows repeat'
    """
    return " ".join(shortened(word, LONGEST_WORD) for word in text.split(" "))


def _first_that_fit(texts: Sequence[str]) -> Sequence[str]:
    """Return the first few texts that are short enough together; at least one if there is any.

    >>> [len(_first_that_fit(texts)) for texts in ([], ["a"] * 9, ["a" * 250] * 3, ["a" * 900] * 3)]
    [0, 3, 2, 1]
    """
    lengths = accumulate(map(len, texts[:FEW]))
    return texts[: max(sum(length <= MOST_TEXT for length in lengths), 1)]


def _widest(result: Fitted) -> str:
    """Return the percentile intervals that are widest relative to their coefficients."""
    from .report_text import bootstrap_text

    intervals = [(c, result.bootstrap.interval(c.name)) for c in result.coefficients] if result.bootstrap else []
    width = {c.name: (i.upper - i.lower) / abs(c.value) for c, i in intervals if i and isfinite(i.lower) and c.value}
    widest = sorted(width, key=lambda name: -graded(width[name]))[:FEW]
    return ", ".join(f"{name} {bootstrap_text(result, name)}" for name in widest)


def _short_channels(result: Fitted) -> Table:
    """Return the goodness of fit over the fitted rows."""
    from .report_text import interval_text

    held_out = {(c.recording, c.channel): f"{c.held_out:.4g}" for c in result.held_out}
    table = plain_table(
        "recording", "channel", "rows", "RMSE", *["out of sample"] * bool(held_out), "unit", "noise floor", "R2",
        title="Goodness of fit, over the fitted rows" + "; cross-validation over conditions" * bool(held_out),
    )  # fmt: skip
    for c in result.channels[:MOST_CHANNELS]:
        beyond = [held_out.get((c.recording, c.channel), "")] * bool(held_out)
        table.add_row(
            c.recording, c.channel, f"{c.fitted_rows}", f"{c.fitted_rmse:.4g}",
            *beyond, c.unit, interval_text(c.noise_floor), f"{c.fitted_r2:.4f}",
        )  # fmt: skip
    return table


def fit_lines(result: Fitted) -> Iterator[Table | str]:
    """Yield all tables and lines of a fit after its verdict, in order."""
    from .report_text import bootstrap_summary, extrapolation_text, ripple_texts

    yield _channels(result)
    yield from _largest_errors(result)
    yield from _coefficients(result)
    if result.bootstrap:
        yield bootstrap_summary(result.bootstrap)
    if result.held_out:
        yield _held_out(result)
    if result.temperature:
        yield result.temperature.text()
    if result.findings.stiffnesses:
        yield _stiffnesses(result)
    yield _stages(result)
    if result.margins:
        yield _margins(result)
        yield extrapolation_text(result)
    yield from _differences(result)
    yield from ripple_texts(result.findings.ripples)
    for direction in result.findings.undetermined:
        yield f"not identifiable: {', '.join(direction.coefficients)}: {direction.reason}"
    for rows in result.excluded_rows:
        yield f"note: {rows}"
    for note in result.notes:
        yield f"note: {note}"
    yield f"fit {result.status} ({result.run.method}), {result.run.seconds:.1f} s"


def _coefficients(result: Fitted) -> Iterator[Table]:
    """Yield the table of the coefficients, if there are any."""
    from .report_text import bootstrap_text, interval_text

    further = ["bootstrap (95 %)"] * bool(result.bootstrap)
    table = plain_table(
        "coefficient", "initial", "lower", "upper", "value", "+- (95 %)", *further, "unit", "",
        title=f"Coefficients ({result.signs} signs)",
    )  # fmt: skip
    consequences = {consequence.name: consequence.text() for consequence in result.bounds}
    for c in result.coefficients:
        remark = (
            f"at bound: {consequences.get(c.name, '')}".rstrip(": ")
            if c.at_bound
            else f"or {c.other:.5g}"
            if c.other is not None
            else "from the family"
            if c.from_family
            else ""
        )
        remark = remark if c.determined or c.at_bound else "no influence on the data"
        numbers = (f"{v:.5g}" for v in (c.guess, c.lower, c.upper, c.value))
        resampled = [bootstrap_text(result, c.name)] * bool(result.bootstrap)
        table.add_row(c.name, *numbers, interval_text(c.interval), *resampled, c.unit, remark)
    if table.row_count:
        yield table


def _channels(result: Fitted) -> Table:
    from .report_text import interval_text

    table = plain_table(
        "recording", "channel", "fitted rows", "RMSE", "R2", "all rows", "RMSE", "R2", "unit", "noise floor",
        title="Goodness of fit, over the fitted rows and over all rows",
    )  # fmt: skip
    for c in result.channels:
        table.add_row(
            c.recording, c.channel, f"{c.fitted_rows}", f"{c.fitted_rmse:.4g}", f"{c.fitted_r2:.5f}", f"{c.rows}",
            f"{c.rmse:.4g}", f"{c.r2:.5f}", c.unit, interval_text(c.noise_floor),
        )  # fmt: skip
    return table


def _largest_errors(result: Fitted) -> Iterator[str]:
    """Yield the operating condition with the largest error of each channel, where there are several."""
    from .report_text import worst_text

    for c in result.channels:
        if largest := worst_text(result, c.recording, c.channel):
            yield f"largest error: {c.recording} {c.channel}: RMSE {largest}"


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


def _margins(result: Fitted) -> Table:
    """Return the constraints."""
    from ..checks.residuals import condition_text
    from .report_text import CONSTRAINT_SIGNS, constraint_rows

    table = plain_table(
        "constraint", "value", "margin", "at", "margin outside", "",
        title="Constraints, verified over the operating range", caption=CONSTRAINT_SIGNS,
    )  # fmt: skip
    for c in constraint_rows(result.margins):
        beyond = "" if c.beyond is None else f"{c.beyond.margin:.3g}"
        violated = any(m is not None and m.margin < 0 for m in (c.inside, c.beyond))
        table.add_row(
            c.constraint, f"{c.inside.worst:.4g}", f"{c.inside.margin:.3g}", condition_text(c.inside.at), beyond,
            "violated" if violated else "",
        )  # fmt: skip
    return table


def _differences(result: Fitted) -> Iterator[Table]:
    """Yield the table of differences between data of equal conditions, files before sweeps, if there are any."""
    from ..checks.residuals import condition_text
    from .report_text import significant_differences

    differences = significant_differences(result)
    if not differences:
        return
    table = plain_table(
        "first", "second", "channel", "difference", "sigmas", "largest", "unit", "mean difference at",
        title=f"Inconsistent data at equal operating conditions and slips ({result.signs} signs)",
    )  # fmt: skip
    for d in differences:
        table.add_row(
            d.first, d.second, d.channel, f"{d.mean:+.3g}", f"{abs(d.sigmas):.0f}", f"{d.most:+.3g}",
            d.unit, condition_text(d.at),
        )  # fmt: skip
    yield table
