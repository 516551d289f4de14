"""The result of a diagnosis: findings with intervals, confounded explanations, fit errors, and the verdict."""

from __future__ import annotations

import time
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy import stats

from tirefmu.estimation.block_regression import coloured_covariance
from tirefmu.estimation.smoothing import HALF_WIDTHS
from tirefmu.measurements import Recording
from tirefmu.tires.tire import Tire

from ..probing.candidates import Candidate
from ..probing.confounding import alias_columns, correlations, separating_measurement
from ..probing.effect_probing import Response, Screen
from ..recording.disturbances import reported_disturbances
from ..recording.measurement_artefacts import quantisation, ripple
from ..recording.signals import FORMULA_SIGNS, Signals
from ..search.effect_search import Search
from ..search.refits import REFINEMENT, Refit
from ..thresholds import CHANNEL_SHARE, CONFOUNDED, REPORTED, REPORTED_EVIDENCE
from ..unexplained.formula_proposal import Unknown
from .detectability import detectable_sizes
from .extrapolation import extrapolations
from .findings import Finding, Interval
from .fit_error import fit_errors
from .improved_tire import tire_of
from .residual_location import residual_maps, time_course
from .result import Diagnosis

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class SearchOutcome:
    """The outcome of a search for missing effects.

    Attributes
    ----------
    recording : Recording
    start : Tire
        The baseline model, with the proposed formulas that were added to it.
    tried : mapping of str to Candidate
    before : Screen
        Of the baseline solution.
    search : Search
        Completed, after `Search.refit_whitened`.
    unknown : tuple of Unknown
    """

    recording: Recording
    start: Tire
    tried: Mapping[str, Candidate]
    before: Screen
    search: Search
    unknown: tuple[Unknown, ...]

    @property
    def signals(self) -> Signals:
        """The preprocessed recording."""
        return self.search.problem.simulator.signals


def composed(outcome: SearchOutcome, began: float) -> Diagnosis:
    """Return the diagnosis, in the sign convention of the formula.

    Parameters
    ----------
    outcome : SearchOutcome
    began : float
        Start time of the diagnosis by `time.perf_counter`, s.
    """
    search, after = outcome.search, outcome.search.screen
    before = outcome.before
    findings = _in_order(outcome, _standard_errors(search.whitened))
    confounded = confounded_with(outcome)
    next_measurement = tuple(
        dict.fromkeys(
            [
                separating_measurement(name, other, outcome.start.book.detections)
                for name, others in confounded.items()
                for other in others
            ]
            + [one.next_measurement for one in outcome.unknown if one.next_measurement]
        )
    )
    errors = fit_errors(before, after)
    added = [refit.name for refit in search.found]
    added += [one.effect.name for one in outcome.unknown if one.added and one.effect]
    detectable, not_identifiable = detectable_sizes(search, outcome.tried, outcome.start)
    verdict = _verdict(findings, outcome.unknown, confounded, detectable, errors)
    return Diagnosis(
        verdict=verdict,
        found=findings,
        confounded_with=confounded,
        next_measurement=next_measurement,
        unknown=outcome.unknown,
        not_identifiable=not_identifiable,
        refined=tuple(f"{one.name.removeprefix(REFINEMENT)}: {', '.join(one.form.free)}" for one in search.refinements),
        gap=errors,
        detectable=detectable,
        where=residual_maps(before),
        where_after=residual_maps(after),
        time_course=time_course(before, after),
        recording=_of_the_recording(outcome),
        extrapolation=extrapolations(
            search.problem, search.solution, {name: _inputs_of(outcome, name) for name in added}
        ),
        holdout_rows=_holdout_rows(outcome.signals),
        base_tire=tire_of(outcome.start, search.problem, before.solution, ()),
        tire=tire_of(outcome.start, search.problem, search.solution, added),
        signs=FORMULA_SIGNS,
        recording_signs=outcome.recording.signs,
        seconds=time.perf_counter() - began,
        rows=outcome.recording.table,
    )


def _inputs_of(outcome: SearchOutcome, effect: str) -> tuple[str, ...]:
    """Return the inputs that an effect depends on."""
    added = [one for one in outcome.start.added if one.name == effect]
    read = {symbol.name for one in added for act in one.acts for symbol in act.expression.free_symbols}
    known = outcome.tried[effect].requires if effect in outcome.tried else ()
    return tuple(name for name in outcome.signals.names if name in read or name in known)


def _of_the_recording(outcome: SearchOutcome) -> dict[str, Any]:
    """Return the disturbances and measurement artefacts of the recording."""
    search, signals = outcome.search, outcome.signals
    summary = reported_disturbances(search.problem.disturbances, search.solution.disturbance, signals)
    summary["ripple"] = ripple(signals, search.solution.residual, outcome.start.values["UNLOADED_RADIUS"])
    summary["quantisation"] = {
        name: quantisation(outcome.recording.table[name].to_numpy(np.float64)) for name in signals.channels
    }
    summary["smoothing_windows"] = [2 * half + 1 for half in HALF_WIDTHS] if any(signals.input_noise.values()) else []
    summary["left_aside"] = dict(signals.excluded_channels)
    return summary


def _holdout_rows(signals: Signals) -> tuple[tuple[int, int], ...]:
    """Return first and last row of each stretch of the hold-out set."""
    edges = np.flatnonzero(np.diff(signals.holdout.astype(int), prepend=0, append=0))
    return tuple((int(signals.rows[first]), int(signals.rows[last - 1])) for first, last in edges.reshape(-1, 2))


def _standard_errors(screen: Screen) -> FloatArray:
    """Return standard errors of all coefficients: sandwich estimator for coloured noise, or jackknife if larger."""
    inverse = screen.baseline.inverse
    coloured = np.diag(inverse @ coloured_covariance(screen.tangent, screen.covariance) @ inverse)
    blocks = np.maximum(np.diag(screen.baseline.jackknife), 0.0)
    # With few correlated rows the sandwich estimate can be negative. It is then ignored.
    return np.asarray(np.sqrt(np.where(coloured > 0.0, np.maximum(coloured, 0.5 * (coloured + blocks)), blocks)))


def _in_order(outcome: SearchOutcome, errors: FloatArray) -> tuple[Finding, ...]:
    """Return identified effects and unexplained structure in order of evidence."""
    identified = [_finding(outcome, refit, errors) for refit in outcome.search.found]
    unknown = [
        Finding("UNKNOWN", _shown(one.response, outcome.signals), {}, one.p, one.gain, one.gain_error)
        for one in outcome.search.structures
    ]
    return tuple(sorted([*identified, *unknown], key=lambda finding: -finding.cv_gain))


def _shown(response: Response, signals: Signals) -> tuple[str, ...]:
    """Return the channels with a significant share of a response."""
    power = np.mean((response.columns @ response.estimate) ** 2, axis=1)
    return tuple(name for name, size in zip(signals.channels, power, strict=True) if size > CHANNEL_SHARE * power.max())


def _finding(outcome: SearchOutcome, refit: Refit, errors: FloatArray) -> Finding:
    solution = outcome.search.solution
    quantile = float(stats.t.ppf(0.975, outcome.search.screen.n_blocks - 1))
    coefficients = {}
    for name in refit.form.free:
        i = solution.free.index(name)
        value = float(solution.parameters[outcome.search.problem.simulator.index[name]])
        error = float(errors[i]) * quantile
        coefficients[name] = Interval(value, value - error, value + error)
    return Finding(
        refit.name,
        _shown(refit.response, outcome.signals),
        coefficients,
        refit.p,
        refit.gain,
        refit.gain_error,
        _stretches(refit, outcome.signals),
    )


def _stretches(refit: Refit, signals: Signals) -> tuple[tuple[float, float], ...]:
    """Return the stretches of time with two thirds of the evidence."""
    order = np.argsort(-refit.gains)
    cumulative = np.cumsum(np.maximum(refit.gains[order], 0.0))
    if cumulative[-1] <= 0.0:
        return ()
    chosen = sorted(order[: int(np.searchsorted(cumulative, REPORTED_EVIDENCE * cumulative[-1])) + 1].tolist())
    t, edges = signals.t[signals.rows], refit.screen.edges
    spans: list[tuple[float, float]] = []
    for g in chosen:
        first, last = float(t[edges[g]]), float(t[min(edges[g + 1], len(t)) - 1])
        if spans and first - spans[-1][1] < 0.5:
            spans[-1] = (spans[-1][0], last)
        else:
            spans.append((first, last))
    return tuple(spans)


def confounded_with(outcome: SearchOutcome) -> dict[str, dict[str, float]]:
    """Return the confounded explanations of each identified effect, with their correlation."""
    search, screen = outcome.search, outcome.search.screen
    names = {refit.name for refit in search.found}
    others = {
        name: np.concatenate([tried.response.columns for tried in search.last if tried.name == name], axis=-1)
        for name in outcome.tried if name not in names and any(tried.name == name for tried in search.last)
    }  # fmt: skip
    confounded = {}
    for refit in search.found:
        found = {
            other.name: screen.tangent[:, :, [search.solution.free.index(name) for name in other.form.free]]
            for other in search.found if other is not refit
        }  # fmt: skip
        size = correlations(screen, refit.form.free, {**others, **alias_columns(screen)}, found)
        confounded[refit.name] = {
            name: value
            for name, value in size.items()
            if value > REPORTED and name != outcome.tried[refit.name].contains
        }
    return {name: others for name, others in confounded.items() if others}


def _verdict(
    findings: tuple[Finding, ...], unknown: tuple[Unknown, ...], confounded: Mapping[str, Mapping[str, float]],
    detectable: Mapping[str, Mapping[str, float]], errors: Mapping[str, Mapping[str, Mapping[str, float]]],
) -> str:  # fmt: skip
    """Return the verdict in one line."""
    if findings:
        missing = []
        for one in findings:
            if one.effect == "UNKNOWN":
                missing.append(f"an unexplained effect that depends on {', '.join(unknown[0].depends_on)}")
                continue
            size = confounded.get(one.effect, {})
            others = ", ".join(sorted((name for name in size if size[name] > CONFOUNDED), key=lambda x: -size[x]))
            missing.append(one.effect + (f" (confounded with {others})" if others else ""))
        return f"Missing: {'; '.join(missing)}"
    channels = errors["train"]
    sizes = {channel: sorted(one[channel] for one in detectable.values() if channel in one) for channel in channels}
    units = {"Fx": "N", "Fy": "N"}
    text = ", ".join(
        f"{size[len(size) // 2]:.2g} {units.get(channel, 'N m')} in {channel}"
        for channel, size in sizes.items()
        if size
    )
    return f"Nothing material is missing (smallest detectable effect, median: {text})"
