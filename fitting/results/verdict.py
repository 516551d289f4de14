"""Verdict on a fit: good, usable with limits, or not usable, with the reasons in order of weight.

The numbers are in docs/is_my_fit_good.md.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np

from ...measurements.checks.recordings.coverage import coverage_texts
from ...numerics.ties import graded
from ...tires.property_file.names import not_given
from ..checks.characteristics import Characteristic
from ..checks.clipping import Clipped
from ..checks.continuity import Discontinuity
from ..checks.diagnostics import Findings
from ..checks.residuals import Residuals, condition_text
from ..checks.slip_stiffness import SlipStiffness
from ..constraints.physical import chosen_constraints
from ..data.fit_data import EXCITED_BY
from ..uncertainty.discrepancy import Discrepancy
from .fitted import Fitted
from .records import ChannelFit

GOOD, LIMITED, UNUSABLE = "good", "usable with limits", "not usable"
#: The forces, without which a tire is not usable.
FORCES = ("Fx", "Fy")
#: R2 below which a channel is described poorly: 70 % of its variation remain, which may be noise; below 0 its mean is a
#: better description.
POOR_R2 = 0.5
#: Relative errors of the slip stiffness: above the first, in one condition and beyond two standard errors of the data,
#: the handling of a vehicle changes noticeably; above the second, over all conditions, it is that of another tire.
#: Judgement.
STIFFNESS_LIMIT, WRONG_STIFFNESS = 0.1, 0.5
#: RMSE over noise floor above which a channel lacks something, if the error beyond the floor is not negligible: above
#: this share of the standard deviation of the channel. Above the last share, what depends on time or differs between
#: repeats is too large for any tire. Judgement.
ABOVE_FLOOR, NEGLIGIBLE, WRONG_DATA = 2.0, 0.01, 0.1
#: Change of the forces over time above which a recording is not of one tire, as that of the stiffness; and the range of
#: a steady change in its standard deviations.
UNSTEADY, RANGE = 0.1, 12.0**0.5
#: Chance under noise alone below which an error of the form is reported, over all channels; its least size, as a share
#: of a force (repeated measurements differ by 1 to 2 %) and of a moment, and relative to the noise floor. Judgement.
CHANCE, FORM_OF_FORCE, FORM_OF_MOMENT, ABOVE_NOISE = 0.02, 0.02, 0.1, 0.5
#: Relative errors beyond two standard errors of the data that are reported, by quantity. Judgement.
CHARACTERISTIC_LIMITS = {"peak friction": 0.05, "peak slip": 0.25, "trail": 0.2}
#: Fitted rows for each coefficient below which a fit is limited; below one it is not usable.
ROWS_PER_COEFFICIENT = 3
#: Share of the rows of a recording whose exclusion is reported. Judgement.
MANY_EXCLUDED = 0.1
#: A channel is extrapolated if an input was measured beyond the range of the channel by this share of the whole range.
#: Judgement.
MISSING_RANGE = 0.1
#: Largest number of names that a reason lists.
MAX_NAMES = 8


@dataclass(frozen=True)
class Verdict:
    """Whether a fitted tire can be used, and why not or with which limits."""

    word: Annotated[str, "good, usable with limits, or not usable"]
    reasons: Annotated[tuple[str, ...], "of the verdict, in order of weight"] = ()

    @property
    def usable(self) -> bool:
        """Whether the tire is usable, possibly with limits."""
        return self.word != UNUSABLE


def verdict_of(result: Fitted) -> Verdict:
    """Return the verdict on a fit."""
    wrong = [] if result.ok else [result.status]
    poor = [c for c in result.channels if c.channel in FORCES and c.fitted_r2 < POOR_R2]
    wrong += [_quality_reason(c) for c in poor if c.fitted_r2 < 0.0 or lacks_something(c)]
    wrong += [_clipped_reason(c) for c in result.findings.clipped if c.channel in FORCES]
    wrong += _wrong_data(result.channels)
    wrong += _unsteady(result)
    wrong += _wrong_between_loads(result.findings)
    wrong += _wrong_stiffness(result.findings)
    wrong += _few_rows(result, 1)
    limits = [
        *_missing_forces(result),
        *_unknown_radius(result),
        *coverage_texts(c for c in result.findings.coverage if c.characteristic or c.channel == "Mz"),
        *(_quality_reason(c) for c in poor),
        *(floor_reason(c) for c in result.channels if lacks_something(c)),
        *_stiffness_reasons(result.findings),
        *_characteristic_reasons(result.findings),
        *(_discontinuity_reason(d) for d in result.findings.discontinuities),
        *(_clipped_reason(c) for c in result.findings.clipped if c.channel not in FORCES),
        *(_quality_reason(c) for c in result.channels if c.channel not in FORCES and c.fitted_r2 < 0.0),
        *_structure(result),
        *_few_rows(result, ROWS_PER_COEFFICIENT),
        *_not_imposed(result),
        *_second_solution(result),
        *_at_bounds(result),
        *_excluded(result),
        *([] if result.residuals is None else _ranges(result.residuals)),
    ]
    reasons = tuple(dict.fromkeys((*wrong, *limits)))
    return Verdict(UNUSABLE if wrong else LIMITED if limits else GOOD, reasons)


def lacks_something(c: ChannelFit) -> bool:
    """Return whether the error of a channel is far above its noise floor and not negligible: a diagnosis finds why."""
    return c.above_floor > ABOVE_FLOOR and c.model_error > NEGLIGIBLE


def _wrong_data(channels: Sequence[ChannelFit]) -> Iterator[str]:
    """Yield the forces with a large part that depends on time or differs between repeats, in any recording."""
    for c in channels:
        largest = max(other.spread for other in channels if other.channel == c.channel)
        unsteady = float(np.hypot(c.explained_by_time, c.between_repeats))
        if c.channel in FORCES and lacks_something(c) and unsteady > WRONG_DATA * largest:
            yield floor_reason(c)


def _unsteady(result: Fitted) -> Iterator[str]:
    """Yield the forces that change over time by more than those of a tire; coefficients of the fit absorb a part of it.

    The residual must confirm it: a large error of the form over the inputs also causes an error over time.
    """
    discrepancies = result.uncertainty.discrepancies
    over_time = {c.channel for c in result.channels if c.explained_by_time > c.explained_by_inputs}
    for d in discrepancies:
        large = d.channel in over_time.intersection(FORCES) and RANGE * d.state > UNSTEADY
        if large and d.final and _chance(d.state_chance, discrepancies):
            yield (
                f"{d.channel} changes by about {RANGE * d.state:.0%} over time, or with an input that the table "
                "lacks: diagnose"
            )


def _wrong_between_loads(findings: Findings) -> Iterator[str]:
    """Yield loads with wrong peak friction between loads with right peak friction: no range of loads is usable.

    Peak friction is wrong at a load if it is wrong in half of its operating conditions.
    """
    friction = [c for c in findings.characteristics if c.quantity == "peak friction" and c.shown]
    for recording, channel in dict.fromkeys((c.recording, c.channel) for c in friction):
        by_load: dict[float, list[Characteristic]] = {}
        for c in friction:
            if (c.recording, c.channel) == (recording, channel):
                by_load.setdefault(c.at.get("Fz", c.load), []).append(c)
        error = {
            load: float(np.median([c.reliable_error for c in characteristics]))
            for load, characteristics in by_load.items()
        }
        right = [load for load, size in error.items() if abs(size) <= CHARACTERISTIC_LIMITS["peak friction"]]
        for load in sorted(error.keys() - right):
            if right and min(right) < load < max(right):
                off = float(np.median([c.off for c in by_load[load]]))
                yield (
                    f"{recording}: the peak friction of {channel} differs from the data by {off:+.0%} at {load:.0f} N, "
                    "between loads at which it is right: diagnose"
                )


def _chance(chance: float, discrepancies: Sequence[Discrepancy]) -> bool:
    """Return whether an error of the form is significant, corrected for the number of channels."""
    return chance < CHANCE / (2 * len(discrepancies))


def floor_reason(c: ChannelFit) -> str:
    """Return how far the error of a channel is above its noise floor, and what it depends on."""
    parts = (
        (c.explained_by_inputs, "depends on the inputs"),
        (c.explained_by_time, "changes slowly with time, the past or finer detail"),
        (c.between_repeats, "differs between repeats"),
    )
    texts = [
        f"{size:.3g} {c.unit} {text}"
        for size, text in sorted(parts, key=lambda part: -graded(part[0]))
        if size > c.noise_floor
    ]
    because = f" ({', '.join(texts)})" if texts else ""
    return (
        f"{c.recording}: {c.channel}: RMSE {c.fitted_rmse:.3g} {c.unit} is {c.above_floor:.1f} times the noise floor"
        f"{because}: diagnose"
    )


def _structure(result: Fitted) -> Iterator[str]:
    """Yield the errors of the form that are significant in channels whose error is near the noise floor."""
    discrepancies = result.uncertainty.discrepancies
    far = {c.channel for c in result.channels if lacks_something(c)}
    least = {c.channel: FORM_OF_FORCE if c.channel in FORCES else FORM_OF_MOMENT for c in result.channels}
    for c in (c for c in result.channels if c.spread > 0.0 and c.noise_floor >= 0.0):
        least[c.channel] = max(least[c.channel], ABOVE_NOISE * c.noise_floor / c.spread)
    texts = [
        f"{d.channel} {size:.1%} over {cause}"
        for d in discrepancies
        if d.channel not in far and d.final
        for size, chance, cause in (
            (d.form, d.form_chance, "the inputs"), (d.state, d.state_chance, "time")
        )
        if _chance(chance, discrepancies) and size > least.get(d.channel, FORM_OF_FORCE)
    ]  # fmt: skip
    if texts:
        yield f"the form of the model has errors above the noise: about {', '.join(texts)}: diagnose"


def _clipped_reason(c: Clipped) -> str:
    ends = [f"{value:.4g}" for value in (c.lower, c.upper) if np.isfinite(value)]
    return f"{c.recording}: {c.channel} is cut off at {' and '.join(ends)} {c.unit} in {c.share:.0%} of the rows"


def _characteristic_reasons(findings: Findings) -> Iterator[str]:
    """Yield the largest error of each quantity of a recording and channel beyond its limit."""
    shown = [c for c in findings.characteristics if c.shown]
    wrong = [c for c in shown if abs(c.reliable_error) > CHARACTERISTIC_LIMITS[c.quantity]]
    worst: dict[tuple[str, str, str], Characteristic] = {}
    for c in sorted(wrong, key=lambda c: -graded(abs(c.reliable_error))):
        worst.setdefault((c.recording, c.channel, c.quantity), c)
    for (recording, channel, quantity), c in worst.items():
        yield f"{recording}: the {quantity} of {channel} differs from the data by {c.off:+.0%} at {_place(c)}"


def _discontinuity_reason(d: Discontinuity) -> str:
    where = condition_text({d.slip: d.position, **d.at})
    size = f"jumps by {abs(d.size):.3g} {d.unit}" if d.kind == "jump" else "has a kink"
    return f"{d.channel} of the tire {size} at {where}"


def _few_rows(result: Fitted, rows_per_coefficient: int) -> Iterator[str]:
    """Yield a reason if there are fewer rows than a multiple of the coefficients."""
    residuals, count = result.residuals, sum(c.determined for c in result.coefficients)
    if residuals is not None and len(residuals.table) < rows_per_coefficient * count:
        yield f"only {len(residuals.table)} rows for {count} coefficients: the tire follows their noise"


def _quality_reason(c: ChannelFit) -> str:
    described = "not described" if c.fitted_r2 < 0.0 else "described poorly"
    return f"{c.recording}: {c.channel} is {described} (R2 {c.fitted_r2:.2f} over the fitted rows)"


def _stiffnesses(findings: Findings) -> Iterator[tuple[str, list[SlipStiffness]]]:
    """Yield the slip stiffnesses of each force of a recording, with a text that names them."""
    for recording, channel in dict.fromkeys((s.recording, s.channel) for s in findings.stiffnesses):
        stiffnesses = [s for s in findings.stiffnesses if (s.recording, s.channel) == (recording, channel)]
        yield f"{recording}: the slip stiffness of {channel} differs from the data by", stiffnesses


def _wrong_stiffness(findings: Findings) -> Iterator[str]:
    for text, stiffnesses in _stiffnesses(findings):
        off = [s.fitted - s.read for s in stiffnesses]
        error = float(np.sign(sum(off)) * np.abs(off).sum() / sum(s.read for s in stiffnesses))
        if abs(error) > WRONG_STIFFNESS:
            yield f"{text} {error:+.0%} over all conditions"


def _stiffness_reasons(findings: Findings) -> list[str]:
    """Return the largest error in one condition for each force of a recording, the largest first."""
    worst = [
        (text, max(stiffnesses, key=lambda s: graded(abs(s.reliable_error))))
        for text, stiffnesses in _stiffnesses(findings)
    ]
    worst = sorted(worst, key=lambda pair: -graded(abs(pair[1].reliable_error)))
    return [f"{text} {s.off:+.0%} at {_place(s)}" for text, s in worst if abs(s.reliable_error) > STIFFNESS_LIMIT]


def _place(read: Characteristic | SlipStiffness) -> str:
    return condition_text(read.at) if read.at else f"{read.load:.0f} N"


def _missing_forces(result: Fitted) -> Iterator[str]:
    fitted = {c.channel for c in result.channels}
    for force in (name for name in FORCES if name in result.tire.outputs and name not in fitted):
        yield f"{force} is not fitted: it was not measured over a varying {EXCITED_BY[force][0]}"


def _unknown_radius(result: Fitted) -> Iterator[str]:
    """Yield a reason if moments were fitted with an assumed radius, by which their coefficients are divided."""
    moments = [c.channel for c in result.channels if c.channel not in FORCES]
    if moments and "UNLOADED_RADIUS" in not_given(result.tire):
        names = ", ".join(dict.fromkeys(moments))
        radius = result.tire.values["UNLOADED_RADIUS"]
        yield (
            f"the radius of the tire is unknown: {radius:g} m is assumed, and the coefficients of {names} depend on it "
            "(--size or --nominal R0=...)"
        )


def _not_imposed(result: Fitted) -> Iterator[str]:
    """Yield the default constraints on fitted channels that the fit did not enforce."""
    fitted, imposed = {c.channel for c in result.channels}, {margin.name for margin in result.margins}
    declared = chosen_constraints(result.tire.model)
    expected = [constraint for output in fitted for constraint in declared.get(output, ())]
    missing = sorted(
        constraint.name for constraint in expected
        if constraint.name not in imposed and (not constraint.effect or constraint.effect in result.tire.has)
    )  # fmt: skip
    if missing:
        yield f"physical constraints not enforced: {_listed(missing)}"


def _second_solution(result: Fitted) -> Iterator[str]:
    values = [f"{c.name} {c.value:.3g} or {c.other:.3g}" for c in result.coefficients if c.other is not None]
    if values:
        yield f"two solutions fit equally well: {_listed(values)}"


def _at_bounds(result: Fitted) -> Iterator[str]:
    names = [c.name for c in result.coefficients if c.at_bound]
    harmless = {bound.name for bound in result.bounds if bound.matters is False}
    bounds = {bound.name: bound for bound in result.bounds}
    for name in (name for name in names if name in bounds and name not in harmless):
        yield f"{name} at a bound: {bounds[name].text()}"
    unknown = [name for name in names if name not in bounds]
    if unknown:
        yield f"{len(unknown)} of {len(result.coefficients)} coefficients at bounds: {_listed(unknown)}"


def _excluded(result: Fitted) -> Iterator[str]:
    for recording in dict.fromkeys(rows.recording for rows in result.excluded_rows):
        excluded = [rows for rows in result.excluded_rows if rows.recording == recording]
        share = sum(rows.rows for rows in excluded) / excluded[0].of
        if share > MANY_EXCLUDED:
            yield f"{recording}: {share:.0%} of the rows excluded ({', '.join(rows.reason for rows in excluded)})"


def _ranges(residuals: Residuals) -> Iterator[str]:
    """Yield the inputs whose range is smaller for a force than for the other channels."""
    for channel in (name for name in FORCES if name in residuals.channels):
        for name, held in residuals.levels.items():
            low, high = residuals.range_of(name, channel)
            gap = MISSING_RANGE * (held[-1] - held[0])
            beyond = [level for level in (held[0], held[-1]) if level < low - gap or level > high + gap]
            if beyond:
                measured = " to ".join(condition_text({name: level}) for level in (low, high))
                yield f"{channel} is extrapolated to {condition_text({name: beyond[-1]})}, measured at {measured}"


def _listed(names: Sequence[str]) -> str:
    more = f" and {len(names) - MAX_NAMES} more" if len(names) > MAX_NAMES else ""
    return ", ".join(names[:MAX_NAMES]) + more
