"""The tables of an inspection in the units of a test bench, the same for terminal and page."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby

import numpy as np

from ...drawing.labels import drawn_unit, drawn_value, per_si
from ...symbolic.channels import CHANNELS, CONTROLLED_INPUTS
from ..checks.columns.meanings import ASSUMPTIONS
from ..checks.rows.coverage import steps_backwards
from ..checks.rows.row_exclusion import EXCLUSION_REASONS
from .inspection import Inspection, SweepSummary

Table = tuple[list[str], list[list[str]]]
#: Columns of texts; the others contain numbers.
TEXTS = {
    "channel", "unit", "unit from", "held at", "swept", "input", "speed in", "numbers", "reason", "taken for",
    "evidence", "why",
}  # fmt: skip
#: Ranges of numbers of sweeps in one cell; more are counted.
MAX_RUNS = 6


def title(inspection: Inspection) -> str:
    """Return rows, duration, rate and segments of a recording in one line."""
    recording = inspection.recording
    parts = [f"{len(recording)} rows", f"{recording.signs} signs"]
    if steps_backwards(recording):
        parts.append("not in the order of time")
    elif "t" in recording.table:
        parts.append(f"{inspection.duration:.4g} s at {1.0 / inspection.interval:.4g} Hz")
        gap = f", longest gap {inspection.longest_gap:.3g} s" if inspection.segments > 1 else ""
        parts.append(f"{inspection.segments} segment{'s' if inspection.segments > 1 else ''}{gap}")
    else:
        parts.append("no time")
    about = recording.about
    parts += [about[key] for key in ("tireid", "selected") if about.get(key)]
    return ", ".join(parts)


def all_tables(inspection: Inspection) -> list[tuple[str, str, Table]]:
    """Return title, explanation and content of each table; empty ones are omitted."""
    tables = [
        ("Channels", "", channel_table(inspection)),
        ("Columns", f"Assumed, as no table shows it: {'; '.join(ASSUMPTIONS)}.", meaning_table(inspection)),
        ("Sweeps", "", sweep_table(inspection)),
        (
            "Operating conditions",
            "Levels of the held inputs. Drift: change from the first to the last tenth of the rows.",
            condition_table(inspection),
        ),
        ("Excluded from a fit", "", excluded_table(inspection)),
    ]
    return [table for table in tables if table[2][1]]


def channel_table(inspection: Inspection) -> Table:
    """Return the channels: units, rows, ranges, levels."""
    header = ["channel", "unit", "rows", "missing", "lowest", "median", "highest", "held at"]
    rows = []
    for channel in inspection.channels:
        name = channel.name
        values = [_number(name, value) for value in (channel.lowest, channel.median, channel.highest)]
        levels = ", ".join(_number(name, level) for level in channel.levels)
        swept = "swept" if name in CONTROLLED_INPUTS else ""
        counts = [str(channel.rows), str(channel.missing)]
        rows.append([name, drawn_unit(name), *counts, *values, levels or swept])
    return header, rows


def meaning_table(inspection: Inspection) -> Table:
    """Return what each column was taken for, and why."""
    sources = {channel.name: channel.unit_from for channel in inspection.channels}
    rows = [
        [meaning.channel, meaning.taken_for, sources.get(meaning.channel, "-"), meaning.evidence or "-"]
        for meaning in inspection.meanings
    ]
    return ["channel", "taken for", "unit from", "evidence"], rows


def sweep_table(inspection: Inspection) -> Table:
    """Return the kinds of sweeps: swept inputs, number, range, speed."""
    rows = []
    ordered = sorted(inspection.sweeps, key=lambda sweep: sweep.moving)
    for moving, group in groupby(ordered, key=lambda sweep: sweep.moving):
        sweeps = list(group)
        for index, name in enumerate(moving):
            low, high = min(s.lowest[index] for s in sweeps), max(s.highest[index] for s in sweeps)
            rates = sorted(s.rate[index] for s in sweeps)
            rows.append(
                [" and ".join(moving), str(len(sweeps)), name, _number(name, low), _number(name, high),
                 _number(name, rates[len(rates) // 2]), f"{drawn_unit(name)}/s".replace("-/s", "1/s"), _numbers(sweeps)]
            )  # fmt: skip
    return ["swept", "sweeps", "input", "lowest", "highest", "speed", "speed in", "numbers"], rows


def condition_table(inspection: Inspection) -> Table:
    """Return the operating conditions: levels, rows, drifts."""
    held = [name for name in CHANNELS if any(name in condition.held for condition in inspection.conditions)]
    drifting = [name for name in CHANNELS if any(name in condition.drift for condition in inspection.conditions)]
    header = ["swept", *(f"{name} ({drawn_unit(name)})" for name in held), "rows", "parts", "s"]
    rows = []
    for condition in inspection.conditions:
        levels = [_number(name, condition.held[name]) if name in condition.held else "" for name in held]
        drifts = [_number(name, condition.drift[name], sign=True) for name in drifting]
        extent = [str(condition.rows), str(condition.sweeps), f"{condition.seconds:.1f}"]
        rows.append([" and ".join(condition.moving) or "-", *levels, *extent, *drifts])
    return [*header, *(f"drift of {name} ({drawn_unit(name)})" for name in drifting)], rows


def excluded_table(inspection: Inspection) -> Table:
    """Return the rows that a fit excludes, by reason, and how many of them are at held conditions."""
    reasons, held = inspection.exclusion.reasons, inspection.held
    rows = []
    for reason, count in inspection.exclusion.counts.items():
        lost = int(np.count_nonzero((reasons == reason) & held))
        share = f"{100.0 * lost / max(1, int(np.count_nonzero(held))):.2g}"
        rows.append([reason, EXCLUSION_REASONS[reason], str(count), str(lost), share])
    return ["reason", "why", "rows", "at held conditions", "% of these"], rows


def _number(name: str, value: float, *, sign: bool = False) -> str:
    """Return a value, or with a sign a change, in the drawn unit; 0 where it is far below the tolerance."""
    drawn = value * per_si(name) if sign else drawn_value(name, value)
    least = 1e-4 if CHANNELS[name].unit == "1" else 5e-3
    drawn = 0.0 if abs(drawn) < least else drawn
    return f"{drawn:+.3g}" if sign else f"{drawn:.4g}"


def _numbers(sweeps: Sequence[SweepSummary]) -> str:
    """Return the numbers of sweeps as ranges, as ``--where "sweep in (...)"`` takes them."""
    runs: list[list[int]] = []
    for number in sorted(sweep.number for sweep in sweeps):
        if runs and number == runs[-1][1] + 1:
            runs[-1][1] = number
        else:
            runs.append([number, number])
    texts = [f"{first}..{last}" if last > first else f"{first}" for first, last in runs]
    more = f" and {len(texts) - MAX_RUNS} more" if len(texts) > MAX_RUNS else ""
    return ", ".join(texts[:MAX_RUNS]) + more
