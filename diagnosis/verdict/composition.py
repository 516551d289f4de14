"""The result of a diagnosis: findings with intervals, confounded explanations, fit errors, and the verdict."""

from __future__ import annotations

import time
from collections.abc import Collection, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy.special import stdtrit

from tirefmu.estimation.noise_floor import NoiseFloor
from tirefmu.measurements import Recording
from tirefmu.tires.tire import Tire

from ..explanations.answer import Answer
from ..explanations.explanation import UNKNOWN
from ..probing.candidates import Candidate
from ..probing.confounding import UNRECORDED_TEMPERATURE, alias_columns, correlations, separating_measurement
from ..probing.effect_probing import Response, Screen
from ..recording.disturbances import reported_disturbances
from ..recording.measurement_artefacts import recording_errors
from ..recording.signals import FORMULA_SIGNS, Signals
from ..search.effect_search import Search
from ..search.proposals import FormCorrection
from ..search.refits import REFINEMENT, Refit
from ..search.settling import Settled
from ..thresholds import CHANNEL_SHARE, REPORTED, REPORTED_EVIDENCE
from ..unexplained.formula_proposal import Unknown
from .adequacy import Adequacy, adequacies
from .delivery import reasons_against
from .detectability import detectable_sizes
from .extrapolation import extrapolations
from .findings import Finding, Interval
from .fit_error import FitErrors, Residuals, delivered_residuals, fit_errors, floors_of, preprocessed, without_skew
from .improved_tire import tire_of
from .operating_range import undetermined_change
from .residual_location import residual_maps, time_course
from .result import Diagnosis
from .verdict import verdict_text

FloatArray = npt.NDArray[np.float64]

#: The reason why a formula that improves the hold-out set is not in the delivered tire.
NOT_DELIVERED = "the improved tire is not delivered"


@dataclass(frozen=True, eq=False)
class SearchOutcome:
    """The outcome of a search for missing effects.

    Attributes
    ----------
    recording : Recording
    start : Tire
        The baseline model, with the proposed formulas that were added to it.
    tried : mapping of str to Candidate
    settled : Settled
        The final fits.
    search : Search
        Completed, after `settle`.
    unknown : tuple of Unknown
    answer : Answer
        How probable the identified effects and their rivals are.
    correction : FormCorrection, optional
        Of the functional form, in `start`.
    """

    recording: Recording
    start: Tire
    tried: Mapping[str, Candidate]
    settled: Settled
    search: Search
    unknown: tuple[Unknown, ...]
    answer: Answer
    correction: FormCorrection | None = None

    @property
    def signals(self) -> Signals:
        """The preprocessed recording."""
        return self.search.problem.simulator.signals


@dataclass(frozen=True, eq=False)
class _Delivery:
    """Which tire is delivered, and its fit error.

    - `against`: reasons why it is not the improved tire.
    - `final`: the solution of the delivered tire.
    """

    base_tire: Tire
    tire: Tire
    against: tuple[str, ...]
    final: Screen
    residuals: Residuals
    errors: FitErrors
    floors: dict[str, NoiseFloor]


def composed(outcome: SearchOutcome, began: float) -> Diagnosis:
    """Return the diagnosis, in the sign convention of the formula.

    Parameters
    ----------
    outcome : SearchOutcome
    began : float
        Start time of the diagnosis by `time.perf_counter`, s.
    """
    search, settled, signals = outcome.search, outcome.settled, outcome.signals
    added = _added(outcome)
    delivery = _delivery(outcome, added)
    against, final = delivery.against, delivery.final
    where_after = residual_maps(final)
    after = {name: one["after"] for name, one in delivery.errors["train"].items()}
    adequacy = adequacies(after, delivery.floors, where_after)
    unknown = outcome.unknown or _unidentified(adequacy, search)
    if against:
        unknown = tuple(
            replace(one, added=False, not_added_because=NOT_DELIVERED) if one.added else one for one in unknown
        )
    findings = _in_order(outcome, unknown, adequacy, settled.whitened.standard_errors())
    confounded = confounded_with(outcome)
    correction = None if against else outcome.correction
    refined = tuple(f"{one.name.removeprefix(REFINEMENT)}: {', '.join(one.form.free)}" for one in search.refinements)
    refined += correction.formulas if correction else ()
    tested = {name: one for name, one in outcome.tried.items() if name in search.candidates}
    detectable, not_identifiable = detectable_sizes(search, tested, outcome.start)
    outliers = delivery.residuals.outlier_rows(signals.channels)
    found_errors = _recording_errors(outcome, final) | {
        "outlier_rows": outliers, "outliers": {name: len(rows) for name, rows in outliers.items()},
    }  # fmt: skip
    return Diagnosis(
        verdict=verdict_text(
            findings, unknown, confounded, refined, adequacy, detectable, against, found_errors, stopped=search.stopped
        ),
        found=findings,
        answer=outcome.answer,
        confounded_with=confounded,
        next_measurement=_next_measurements(outcome, confounded, unknown),
        unknown=unknown,
        not_identifiable=not_identifiable,
        refined=refined,
        correction=correction,
        gap=delivery.errors,
        adequacy=adequacy,
        delivered=not against,
        not_delivered_because=against,
        confirmed=settled.confirmed,
        rejected=settled.rejected,
        detectable=detectable,
        where=residual_maps(settled.before),
        where_after=where_after,
        time_course=time_course(settled.before, final),
        recording=found_errors,
        extrapolation=extrapolations(
            search.problem, search.solution, added, {name: _inputs_of(outcome, name) for name in added}
        ),
        holdout_rows=tuple(
            (int(signals.table_rows[first]), int(signals.table_rows[last]))
            for first, last in signals.holdout_stretches()
        ),
        base_tire=delivery.base_tire,
        tire=delivery.tire,
        signs=FORMULA_SIGNS,
        recording_signs=outcome.recording.signs,
        seconds=time.perf_counter() - began,
        rows=outcome.recording.table,
    )


def _added(outcome: SearchOutcome) -> dict[str, tuple[str, ...]]:
    """Return the effects of the improved tire that the baseline tire lacks, with their free coefficients."""
    effects = [one.effect for one in outcome.unknown if one.added and one.effect]
    effects += [outcome.correction.effect] if outcome.correction else []
    return {refit.name: refit.form.free for refit in outcome.search.found} | {
        effect.name: tuple(declaration.name for declaration in effect.declarations) for effect in effects
    }


def _delivery(outcome: SearchOutcome, added: Mapping[str, tuple[str, ...]]) -> _Delivery:
    """Return the improved tire with its fit error, or the baseline tire if there are reasons against it."""
    search, settled = outcome.search, outcome.settled
    before, after = settled.before, settled.after
    base_tire = tire_of(before.problem.simulator.tire, before.problem, before.solution, ())
    tire = tire_of(outcome.start, search.problem, search.solution, added)
    # The equations of all effects are compiled already; those of the delivered tires alone would take seconds.
    complete = tuple(replace(one, added=outcome.start.added) for one in (base_tire, tire))
    screens, rows = (before, after), outcome.signals.table_rows
    recording = without_skew(outcome.recording, outcome.signals)
    residuals = judged = delivered_residuals(complete, recording, screens, rows)
    floors = floors_of(recording, residuals, outcome.signals.channels)
    errors = compared = fit_errors(before, after, residuals, floors)
    if set(tire.states) - set(base_tire.states) and outcome.signals.timed:
        without_noise = preprocessed(outcome.recording, outcome.signals)
        judged = delivered_residuals(complete, without_noise, screens, rows)
        compared = fit_errors(*screens, judged, floors)
    if not added and not search.refinements:
        return _Delivery(base_tire, tire, (), after, residuals, errors, floors)
    against = reasons_against(compared, judged, undetermined_change(settled.whitened, added))
    if not against:
        return _Delivery(base_tire, tire, (), after, residuals, errors, floors)
    errors = fit_errors(before, before, replace(residuals, after=residuals.before), floors)
    return _Delivery(base_tire, base_tire, against, before, residuals, errors, floors)


def _next_measurements(
    outcome: SearchOutcome, confounded: Mapping[str, Mapping[str, float]], unknown: tuple[Unknown, ...]
) -> tuple[str, ...]:
    """Return the measurements that separate confounded explanations, and that determine unexplained structure."""
    detections = outcome.start.symbolic_model.detections
    separating = [
        separating_measurement(name, one, detections) for name, others in confounded.items() for one in others
    ]
    return tuple(dict.fromkeys([*separating, *(one.next_measurement for one in unknown if one.next_measurement)]))


def _recording_errors(outcome: SearchOutcome, final: Screen) -> dict[str, Any]:
    """Return the errors of the recording as estimated with the delivered tire, and what the baseline tire removes."""
    before = outcome.settled.before
    problem, solution = final.problem, final.solution
    errors = recording_errors(
        outcome.recording, final.signals, problem.disturbances, solution.disturbance, solution.residual, outcome.start
    )
    base = reported_disturbances(before.problem.disturbances, before.solution.disturbance, before.signals)
    return errors | {f"{key}_base": base[key] for key in ("removed", "cross_talk", "periodic")}


def _unidentified(adequacy: tuple[Adequacy, ...], search: Search) -> tuple[Unknown, ...]:
    """Return the structure in channels far above their noise floor, if no effect was identified."""
    worst = max(adequacy, key=lambda one: one.ratio if one.rating == "red" else 0.0)
    if worst.rating != "red" or search.found:
        return ()
    depends_on = tuple(sorted({*worst.over, *(("memory",) if worst.memory else ())}))
    reason = "no effect and no formula explains it"
    return (Unknown(depends_on, "", False, None, reason, "hold or repeat the operating conditions of the residual"),)


def _inputs_of(outcome: SearchOutcome, effect: str) -> tuple[str, ...]:
    """Return the inputs that an effect depends on."""
    added = [one for one in outcome.start.added if one.name == effect]
    read = {symbol.name for one in added for act in one.acts for symbol in act.expression.free_symbols}
    known = outcome.tried[effect].requires if effect in outcome.tried else ()
    return tuple(name for name in outcome.signals.names if name in read or name in known)


def _in_order(
    outcome: SearchOutcome, unknown: tuple[Unknown, ...], adequacy: tuple[Adequacy, ...], errors: FloatArray
) -> tuple[Finding, ...]:
    """Return identified effects and unexplained structure in order of probability."""
    probabilities = outcome.answer.probabilities
    identified = [_finding(outcome, refit, errors) for refit in outcome.search.found]
    structures = [
        Finding(
            UNKNOWN, _shown(one.response, outcome.signals), {}, one.p, one.gain, one.gain_error, probabilities[UNKNOWN]
        )
        for one in outcome.search.structures
    ]
    if unknown and not structures:  # nothing but a residual far above the noise floor
        channels = tuple(one.channel for one in adequacy if one.rating == "red")
        structures = [Finding(UNKNOWN, channels, {}, float("nan"), 0.0, float("nan"), probabilities[UNKNOWN])]
    return tuple(sorted([*identified, *structures], key=lambda finding: (-finding.probability, -finding.cv_gain)))


def _shown(response: Response, signals: Signals) -> tuple[str, ...]:
    """Return the channels with a significant share of a response."""
    power = np.mean((response.columns @ response.estimate) ** 2, axis=1)
    return tuple(name for name, size in zip(signals.channels, power, strict=True) if size > CHANNEL_SHARE * power.max())


def _finding(outcome: SearchOutcome, refit: Refit, errors: FloatArray) -> Finding:
    solution = outcome.search.solution
    quantile = float(stdtrit(outcome.search.screen.n_blocks - 1, 0.975))
    declarations, coefficients = outcome.start.symbolic_model.coefficients, {}
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
        outcome.answer.probabilities[refit.name],
        _stretches(refit, outcome.signals),
        _size(outcome, refit),
        frozenset(name for name in refit.form.free if declarations[name].flips),
        outcome.search.problem.at_bounds(solution.parameters, refit.form.free),
    )


def _size(outcome: SearchOutcome, refit: Refit) -> dict[str, tuple[float, float]]:
    """Return root mean square and largest change of each force by an effect."""
    simulator, solution = outcome.search.problem.simulator, outcome.search.solution
    absent, parameters = simulator.tire.parameters(), solution.parameters.copy()
    indices = [simulator.index[name] for name in refit.form.free]
    parameters[indices] = absent[indices]
    change = np.nan_to_num(simulator.forces(solution.parameters) - simulator.forces(parameters))
    return {
        name: (float(np.sqrt(np.mean(row**2))), float(np.abs(row).max()))
        for name, row in zip(outcome.signals.channels, change, strict=True)
        if np.any(row)
    }


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
    others = _alternatives(search, outcome.tried.keys() - names)
    confounded = {}
    for refit in search.found:
        found = {
            other.name: screen.tangent[:, :, [search.solution.free.index(name) for name in other.form.free]]
            for other in search.found if other is not refit
        }  # fmt: skip
        correlated = correlations(screen, refit.form.free, {**others, **alias_columns(screen)}, found)
        size: dict[str, float] = {}
        for key, value in correlated.items():
            name = key.partition(" ")[0]
            size[name] = max(value, size.get(name, 0.0))
        confounded[refit.name] = {
            name: value
            for name, value in size.items()
            if value > REPORTED and name != outcome.tried[refit.name].contains
        }
        if "distance" in outcome.tried[refit.name].requires and "T" not in outcome.signals.recorded:
            confounded[refit.name][UNRECORDED_TEMPERATURE] = 1.0
    return {name: others for name, others in confounded.items() if others}


def _alternatives(search: Search, names: Collection[str]) -> dict[str, FloatArray]:
    """Return the weighted responses of effects that were not identified, by name.

    Each point of a grid is an explanation of its own, since only one value of a time constant is right: its key is the
    name, a space and a number.
    """
    columns: dict[str, FloatArray] = {}
    for i, tried in enumerate(search.last):
        if tried.name in names:
            key = f"{tried.name} {i}" if tried.form.grid else tried.name
            parts = [columns[key]] if key in columns else []
            columns[key] = np.concatenate([*parts, tried.response.columns], axis=-1)
    return columns
