"""The result of a diagnosis: findings with intervals, confounded explanations, fit errors, and the verdict."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import Any

import numpy as np
import pandas as pd
from scipy.special import stdtrit

from ...measurements import Recording
from ...numerics.arrays import FloatArray
from ...numerics.noise_floor import ErrorSplit
from ...numerics.smoothing import HALF_WIDTHS
from ...numerics.ties import graded
from ...symbolic.channels import OUTPUTS
from ...tires.tire import Tire
from ..explanations.answer import OneOf
from ..explanations.effect_evidence import Evidence
from ..explanations.explanation import UNKNOWN
from ..explanations.final import Final
from ..explanations.form import FORM
from ..probing.candidates import Candidate
from ..probing.confounding import UNRECORDED_TEMPERATURE, alias_columns, correlations, separating_measurement
from ..probing.effect_probing import Screen, Tried, tried
from ..signals.disturbances import reported_disturbances
from ..signals.measurement_artefacts import quantisation, ripple
from ..signals.predicted_temperature import SURROUNDINGS, TEMPERATURE, predicting, source_of_temperature
from ..signals.signals import FORMULA_SIGNS, Signals
from ..thresholds import REPORTED
from ..unexplained.formula_proposal import Unknown
from .adequacy import Adequacy, adequacies
from .detectability import detectable_sizes
from .extrapolation import extrapolations
from .findings import CoefficientInterval, FormCorrection, FoundEffect, Size
from .fit_error import (
    DeliveredResiduals,
    FitErrors,
    computed_by,
    delivered_residuals,
    error_splits,
    fit_errors,
    fitted_residuals,
    reasons_against,
    residual_of,
    without_skew,
)
from .improved_tire import tire_of
from .parts import DiagnosisRun, Identifiability, Improvement, Misfit
from .residual_location import residual_maps, scale_errors, time_course
from .result import Diagnosis
from .verdict import CHANNEL_SHARE, verdict_sentences

#: Share of the evidence in the reported stretches of time. Convention.
REPORTED_EVIDENCE = 0.67

#: The reason why a formula that improves the hold-out set is not in the delivered tire.
NOT_DELIVERED = "the improved tire is not delivered"


@dataclass(frozen=True, eq=False)
class DiagnosisOutcome:
    """What a comparison of explanations found.

    - `candidates`: all that were compared.
    - `final`: the final fits.
    - `stopped`: why the comparison ended although explanations remained, or ''.
    """

    recording: Recording
    candidates: Mapping[str, Candidate]
    final: Final
    stopped: str = ""

    @property
    def signals(self) -> Signals:
        """The preprocessed recording."""
        return self.final.after.signals


@dataclass(frozen=True, eq=False)
class _Delivery:
    """Which tire is delivered, and its fit error.

    - `computed`: by both tires (`computed_by`).
    - `against`: reasons why it is not the improved tire.
    - `final`: the fit of the delivered tire.
    """

    base_tire: Tire
    tire: Tire
    computed: tuple[pd.DataFrame, pd.DataFrame]
    against: tuple[str, ...]
    final: Screen
    residuals: DeliveredResiduals
    errors: FitErrors
    splits: dict[str, ErrorSplit]


def composed(outcome: DiagnosisOutcome, began: float) -> Diagnosis:
    """Return the diagnosis, in the sign convention of the formula.

    `began`: start time of the diagnosis by `time.perf_counter`, s.
    """
    fits, signals, added = outcome.final, outcome.signals, _added(outcome.final)
    delivery = _delivery(outcome, added)
    against, final = delivery.against, delivery.final
    where_after = residual_maps(final)
    after = {name: errors["after"] for name, errors in delivery.errors["train"].items()}
    adequacy = adequacies(after, delivery.splits, where_after, scale_errors(final))
    unknown = _unknown(fits, adequacy, delivered=not against)
    lacking = {name: candidate for name, candidate in outcome.candidates.items() if name not in fits.effects}
    tested = tried(fits.after, lacking)
    findings = _in_order(outcome, unknown, adequacy)
    confounded = confounded_with(outcome, tested)
    refined = () if against else tuple(f"{name}: {', '.join(form.free)}" for name, form in fits.refinements)
    detectable, not_identifiable = detectable_sizes(fits.after, lacking, tested)
    of_recording = _recording_errors(outcome, delivery)
    read = {name: _inputs_of(outcome, name) for name in added}
    one_of = outcome.final.answer.one_of(finding.effect for finding in findings)
    sentences = verdict_sentences(
        findings, unknown, confounded, refined, adequacy, detectable, against, of_recording,
        one_of=one_of, stopped=bool(outcome.stopped),
    )  # fmt: skip
    errors_of_form = {} if fits.form is None else Size.by_channel(signals.channels, fits.form)
    form = FormCorrection(errors_of_form, fits.form is not None and not against)
    sentences += [form.sentence] * form.delivered
    stretches = np.flatnonzero(np.diff(signals.holdout, prepend=False, append=False)).reshape(-1, 2) - [0, 1]
    source = _source_of_temperature(outcome, findings)
    sentences += [source] * bool(source)
    if outcome.stopped:
        sentences[0] = f"Best explanation so far, {outcome.stopped}: {sentences[0]}"
    return Diagnosis(
        sentences=tuple(sentences),
        found=findings,
        answer=outcome.final.answer,
        confounded_with=confounded,
        unknown=unknown,
        evidence=fits.evidence,
        adequacy=adequacy,
        recording=of_recording,
        base_tire=delivery.base_tire,
        tire=delivery.tire,
        signs=FORMULA_SIGNS,
        identifiability=Identifiability(
            detectable, not_identifiable, _next_measurements(outcome, one_of, confounded, unknown)
        ),
        misfit=Misfit(delivery.errors, residual_maps(fits.before), where_after, time_course(fits.before, final)),
        improvement=Improvement(refined, form, extrapolations(fits.after, added, read), against),
        run=DiagnosisRun(
            outcome.recording.table,
            outcome.recording.signs,
            delivery.computed,
            signals.table_rows,
            fits.start.added,
            tuple(map(tuple, signals.table_rows[stretches].tolist())),
            round(time.perf_counter() - began, 2),
            outcome.stopped,
        ),
    )


def _added(fits: Final) -> dict[str, tuple[str, ...]]:
    """Return the effects of the improved tire that the baseline tire lacks, with their free coefficients."""
    formulas = [part.effect for part in fits.unknown if part.added and part.effect]
    return dict(fits.effects) | {
        formula.name: tuple(declaration.name for declaration in formula.declarations) for formula in formulas
    }


def _delivery(outcome: DiagnosisOutcome, added: Mapping[str, tuple[str, ...]]) -> _Delivery:
    """Return the improved tire with its fit error, or the baseline tire if there are reasons against it."""
    fits = outcome.final
    before, after = fits.before, fits.after
    base_tire = tire_of(before.problem, before.solution, ())
    tire = tire_of(after.problem, after.solution, (*added, *((FORM,) if fits.form is not None else ())))
    # The equations of all effects are compiled already; those of the delivered tires alone would take seconds.
    complete = tuple(replace(either, added=fits.start.added) for either in (base_tire, tire))
    recording = without_skew(outcome.recording, outcome.signals)
    computed = [computed_by(either, recording) for either in complete]
    of_base, of_improved = (
        residual_of(forces, fit, recording) for forces, fit in zip(computed, (before, after), strict=True)
    )
    residuals = delivered_residuals(of_base, of_improved, outcome.signals)
    more_states = bool(set(tire.states) - set(base_tire.states)) and outcome.signals.timed
    judged = fitted_residuals(before, after) if more_states else residuals
    against = reasons_against(judged) if after.solution.free != before.solution.free else ()
    if against:
        tire, after, of_improved, residuals = base_tire, before, of_base, replace(residuals, after=residuals.before)
        computed[1] = computed[0]
    elif TEMPERATURE in outcome.signals.origin.derived & set(outcome.recording.table):
        tire = predicting(tire, outcome.recording)
    splits = error_splits(of_improved, residuals, recording)
    errors = fit_errors(before, after, residuals, splits)
    return _Delivery(base_tire, tire, (computed[0], computed[1]), against, after, residuals, errors, splits)


def _next_measurements(
    outcome: DiagnosisOutcome, one_of: Sequence[OneOf], confounded: Mapping[str, Mapping[str, float]],
    unknown: tuple[Unknown, ...],
) -> tuple[str, ...]:  # fmt: skip
    """Return the measurements that separate confounded explanations, and that determine unexplained structure."""
    detections = outcome.final.start.symbolic_model.detections
    pairs = [pair for alternatives in one_of for pair in combinations(alternatives.effects, 2)]
    pairs += [(name, other) for name, others in confounded.items() for other in others]
    separating = [separating_measurement(*pair, detections) for pair in pairs]
    return tuple(dict.fromkeys([*separating, *(part.next_measurement for part in unknown if part.next_measurement)]))


def _recording_errors(outcome: DiagnosisOutcome, delivery: _Delivery) -> dict[str, Any]:
    """Return the errors of the recording as estimated with the delivered tire, and what the baseline tire removes."""
    table, before, final = outcome.recording.table, outcome.final.before, delivery.final
    signals, disturbances, values = final.signals, final.problem.disturbances, final.solution.disturbance
    start, origin = outcome.final.start, signals.origin
    used = {"t", "distance", *start.inputs, *OUTPUTS, *(SURROUNDINGS if TEMPERATURE in origin.derived else ())}
    waves = [i for i, name in enumerate(disturbances.names) if name.startswith("wave")]
    turning = final.solution.residual + disturbances.columns[:, :, waves] @ values[waves]
    outliers = delivery.residuals.outlier_rows()
    base = reported_disturbances(before.problem.disturbances, before.solution.disturbance, before.signals)
    return reported_disturbances(disturbances, values, signals) | {
        "ripple": ripple(signals, turning, start.values["UNLOADED_RADIUS"]),
        "quantisation": {name: quantisation(table[name].to_numpy(np.float64)) for name in signals.channels},
        "compared_every": int(np.diff(signals.table_rows).min()),
        "smoothing_windows": [2 * half + 1 for half in HALF_WIDTHS] if any(origin.noise.values()) else [],
        "left_aside": dict(signals.excluded_channels),
        "derived_columns": sorted(origin.derived & set(table)),
        "ignored_columns": [str(name) for name in table if name not in used],
        **{f"{key}_base": base[key] for key in ("removed", "cross_talk", "periodic")},
        "outlier_rows": outliers,
        "outliers": {name: len(rows) for name, rows in outliers.items()},
    }


def _source_of_temperature(outcome: DiagnosisOutcome, findings: Sequence[FoundEffect]) -> str:
    """Return which temperature the identified effects read, in a sentence, or ''."""
    start, candidates = outcome.final.start, outcome.candidates
    effects = [finding.effect for finding in findings if finding.effect in candidates]
    reading = [name for name in effects if TEMPERATURE in candidates[name].requires]
    recorded = TEMPERATURE in outcome.signals.origin.recorded and not start.values.get("THACT")
    return source_of_temperature(reading, effects, start, recorded)


def _unknown(fits: Final, adequacy: tuple[Adequacy, ...], *, delivered: bool) -> tuple[Unknown, ...]:
    """Return the unknown component, or that there is one if a channel is far above its noise floor."""
    if fits.unknown:
        withheld = [part for part in fits.unknown if part.added and not delivered]
        return tuple(replace(part, added=False, not_added_because=NOT_DELIVERED) for part in withheld) or fits.unknown
    worst = max(adequacy, key=lambda rated: graded(rated.ratio) if rated.rating == "red" else 0.0)
    if worst.rating != "red" or fits.effects:
        return ()
    depends_on = tuple(sorted({*worst.over, *(("memory",) if worst.memory else ())}))
    reason = "no effect and no formula explains it"
    return (Unknown(depends_on, "", False, None, reason, "hold or repeat the operating conditions of the residual"),)


def _inputs_of(outcome: DiagnosisOutcome, effect: str) -> tuple[str, ...]:
    """Return the inputs that an effect depends on."""
    added = [part for part in outcome.final.start.added if part.name == effect]
    read = frozenset[str]().union(*(act.reads for part in added for act in part.acts))
    required = outcome.candidates[effect].requires if effect in outcome.candidates else ()
    return tuple(name for name in outcome.signals.names if name in read or name in required)


def _in_order(
    outcome: DiagnosisOutcome, unknown: tuple[Unknown, ...], adequacy: tuple[Adequacy, ...]
) -> tuple[FoundEffect, ...]:
    """Return identified effects and unexplained structure in order of probability."""
    fits, probability = outcome.final, outcome.final.answer.probabilities[UNKNOWN]
    findings = [_finding(outcome, name, evidence) for name, evidence in fits.evidence.items()]
    if fits.unknown_evidence is not None:
        of_formula = fits.unknown_evidence
        channels = _shown(of_formula, fits.after)
        findings.append(
            FoundEffect(UNKNOWN, channels, {}, of_formula.p, of_formula.gain, of_formula.gain_error, probability)
        )
    elif unknown:  # a formula that is not added, or nothing but a residual far above the noise floor
        channels = tuple(rated.channel for rated in adequacy if rated.rating == "red")
        findings.append(FoundEffect(UNKNOWN, channels, {}, float("nan"), 0.0, float("nan"), probability))
    return tuple(sorted(findings, key=lambda finding: (-graded(finding.probability), -graded(finding.cv_gain))))


def _shown(evidence: Evidence, screen: Screen) -> tuple[str, ...]:
    """Return the channels with a significant share of an effect."""
    power = np.mean((screen.problem.inverse_noise * evidence.change) ** 2, axis=1)
    channels = zip(screen.signals.channels, power, strict=True)
    return tuple(name for name, size in channels if size > CHANNEL_SHARE * power.max())


def _finding(outcome: DiagnosisOutcome, name: str, evidence: Evidence) -> FoundEffect:
    fits = outcome.final
    problem, solution, names = fits.after.problem, fits.after.solution, fits.effects[name]
    quantile = float(stdtrit(fits.after.n_blocks - 1, 0.975))
    declarations, coefficients = fits.start.symbolic_model.coefficients, {}
    for coefficient, least, most in zip(names, *np.stack(problem.bounds(names)).tolist(), strict=True):
        value = float(solution.parameters[problem.simulator.index[coefficient]])
        error = float(fits.errors[solution.free.index(coefficient)]) * quantile
        coefficients[coefficient] = CoefficientInterval(value, max(value - error, least), min(value + error, most))
    return FoundEffect(
        name,
        _shown(evidence, fits.after),
        coefficients,
        evidence.p,
        evidence.gain,
        evidence.gain_error,
        outcome.final.answer.probabilities[name],
        _stretches(evidence, fits.after),
        Size.by_channel(outcome.signals.channels, evidence.change),
        frozenset(coefficient for coefficient in names if declarations[coefficient].flips),
        problem.at_bounds(solution.parameters, names),
    )


def _stretches(evidence: Evidence, screen: Screen) -> tuple[tuple[float, float], ...]:
    """Return the stretches of time with two thirds of the evidence."""
    order = np.argsort(-graded(evidence.gains), kind="stable")
    cumulative = np.cumsum(np.maximum(evidence.gains[order], 0.0))
    if cumulative[-1] <= 0.0:
        return ()
    most = order[: int(np.searchsorted(cumulative, REPORTED_EVIDENCE * cumulative[-1])) + 1]
    t, edges = screen.signals.t[screen.signals.rows], screen.edges
    ends = np.flatnonzero(np.diff(np.isin(np.arange(screen.n_blocks), most), prepend=False, append=False))
    return tuple((float(t[edges[first]]), float(t[edges[end] - 1])) for first, end in ends.reshape(-1, 2))


def confounded_with(outcome: DiagnosisOutcome, tested: Sequence[Tried]) -> dict[str, dict[str, float]]:
    """Return the confounded explanations of each identified effect, with their correlation."""
    fits, screen, confounded = outcome.final, outcome.final.after, dict[str, dict[str, float]]()
    others = [*_alternatives(tested), *alias_columns(screen).items()]
    for name, coefficients in fits.effects.items():
        identified = [
            (other, screen.tangent[:, :, [screen.solution.free.index(coefficient) for coefficient in owned]])
            for other, owned in fits.effects.items() if other != name
        ]  # fmt: skip
        size = correlations(screen, coefficients, [*others, *identified])
        contained = outcome.candidates[name].contains
        confounded[name] = {other: value for other, value in size.items() if value > REPORTED and other != contained}
        if "distance" in outcome.candidates[name].requires and "T" not in outcome.signals.origin.recorded:
            confounded[name][UNRECORDED_TEMPERATURE] = 1.0
    return {name: others for name, others in confounded.items() if others}


def _alternatives(tested: Sequence[Tried]) -> list[tuple[str, FloatArray]]:
    """Return effects that were not identified, with their weighted responses, those of each point of a grid alone."""
    grouped = dict[tuple[str, int], list[FloatArray]]()
    for i, effect in enumerate(tested):
        grouped.setdefault((effect.name, i if effect.form.grid else -1), []).append(effect.response.columns)
    return [(name, np.concatenate(columns, axis=-1)) for (name, _), columns in grouped.items()]
