"""The missing-effect workflow: from a recording and a start model to a verdict and an improved tire."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt
from scipy import stats

from tirefmu.measurements import Recording, TableLike, recording_from
from tirefmu.symbolic import DEFAULT_MODEL
from tirefmu.symbolic import model as book_of
from tirefmu.symbolic.added import AddedEffect, library
from tirefmu.symbolic.errors import UnknownName
from tirefmu.tires import TireLike, tire_from
from tirefmu.tires.definition import RANGES
from tirefmu.tires.tire import Tire

from .base import fit_base
from .candidates import Candidate, candidates_for, varies
from .confounding import CONFOUNDED, TOLD, alias_columns, correlations, separating_measurement
from .disturbances import reported_disturbances
from .extrapolation import reaches
from .gap import gaps
from .least_squares import LeastSquares, Solution
from .linear import coloured_covariance
from .proposal import added_if_better, effect_of, unknown_of
from .ripple import quantisation, ripple
from .screening import Screen, Trace
from .search import LARGEST_P, Refit, Search
from .signals import FORMULA_SIGNS, Signals, signals_of
from .smoothing import HALF_WIDTHS
from .verdict import Diagnosis, Finding, Interval, Unknown
from .where import residual_maps, time_course

FloatArray = npt.NDArray[np.float64]

#: Options of --nominal and the coefficients that they set.
NOMINAL = {"Fz0": ("FNOMIN",), "p0": ("NOMPRES", "INFLPRES"), "R0": ("UNLOADED_RADIUS",), "V0": ("LONGVL",)}


def diagnose(
    table: TableLike,
    *,
    signs: str | None = None,
    model: str = DEFAULT_MODEL,
    effects: Collection[str] = (),
    nominal: Mapping[str, float] | None = None,
    tire: TireLike | None = None,
    candidates: Collection[AddedEffect | str] | None = None,
    progress: Callable[[str], None] | None = None,
) -> Diagnosis:
    """Find the effect that a start model lacks to explain a recording.

    Parameters
    ----------
    table : path, DataFrame or Recording
        SI: ``t`` and inputs, and at least one output.
    signs : {"iso", "sae", "adapted-sae"}, optional
        The table's convention, where it is not the default: that of the format of a file, "iso" for a DataFrame.
    model : str
        Of the start model, where no tire is given.
    effects : collection of str
        What the start model has on top of the core formula.
    nominal : mapping of str to float
        Fz0, R0, p0, V0 in SI; Fz0 and R0 are indispensable without a tire.
    tire : Tire, path of a .tir file, or name of a published tire, optional
        The start model, already fitted; `model`, `effects` and `nominal` are then left aside.
    candidates : collection of str or AddedEffect, optional
        Try only these effects; a user's own `AddedEffect` is tried beside the known ones where only such are given.
    progress : callable, optional
        Takes a sentence on what is being done.

    Returns
    -------
    Diagnosis
        Coefficients and offsets are in ISO-W, as in the tire file; `Diagnosis.in_signs` converts them.

    Raises
    ------
    DataError
        If the recording cannot be used.
    UnknownName
        If a model, an effect, a tire or a convention does not exist.
    WrongType
        If the table or the tire is of another type.
    """
    recording = recording_from(table, signs=signs)
    began = time.perf_counter()
    say = progress or (lambda sentence: None)
    own = tuple(one for one in candidates or () if isinstance(one, AddedEffect))
    named = tuple(one for one in candidates or () if isinstance(one, str))
    start = _start_model(model, effects, nominal, None if tire is None else tire_from(tire), own)
    tried = _chosen(candidates_for(start, own), named)
    signals = signals_of(recording.table, start, recording.signs)
    say("fitting the start model")
    problem, solution = fit_base(start, signals, known=tire is not None)
    before = Screen(problem, solution)
    search = Search(problem, solution, tried, say)
    search.run()
    unknown, start = _unknown(start, search, say)
    before = search.settle(before)
    say("weighing what else could explain it")
    return _composed(_Case(recording, start, tried, before, search, unknown), began).in_signs("iso")


@dataclass(frozen=True, eq=False)
class _Case:
    recording: Recording
    start: Tire
    tried: Mapping[str, Candidate]
    before: Screen
    search: Search
    unknown: tuple[Unknown, ...]

    @property
    def signals(self) -> Signals:
        return self.search.problem.simulator.signals


def _start_model(
    model: str, effects: Collection[str], nominal: Mapping[str, float] | None, tire: Tire | None,
    own: tuple[AddedEffect, ...],
) -> Tire:  # fmt: skip
    """Return the start model with every effect beyond the book in its lines, switched off."""
    if tire is None:
        values: dict[str, float] = {}
        for name, value in (nominal or {}).items():
            if name not in NOMINAL:
                raise UnknownName("nominal value", name, NOMINAL)
            values |= dict.fromkeys(set(NOMINAL[name]) & book_of(model).coefficients.keys(), value)
        tire = Tire(model, values, effects=tuple(effects), signs=FORMULA_SIGNS)
    known = [effect for effect in library().values() if tire.book.has_place_for(effect)]
    beyond = {effect.name: effect for effect in (*tire.added, *known, *own)}
    whole = replace(tire.in_signs(FORMULA_SIGNS), added=tuple(beyond.values()), effects=tire.has)
    return whole


def _unknown(start: Tire, search: Search, say: Callable[[str], None]) -> tuple[tuple[Unknown, ...], Tire]:
    """Return unknown structure, and the start model with its formula in it where the hold-out improves."""
    told = []
    for structure in search.structures:
        effect = effect_of(structure)
        added = None
        if effect:
            say("writing the proposed formula into the book")
            added = added_if_better(structure, effect, start, search.problem, search.solution)
        if added:
            start = added.tire
            search.problem, search.solution = added.problem, added.solution
            search.screen = Screen(search.problem, search.solution)
            search.last = search.probe()
        told.append(unknown_of(structure, effect, added))
    return tuple(told), start


def _chosen(known: dict[str, Candidate], named: tuple[str, ...]) -> dict[str, Candidate]:
    for name in named:
        if name not in known:
            raise UnknownName("effect that could be missing", name, known)
    return {name: known[name] for name in named} if named else known


def _composed(case: _Case, began: float) -> Diagnosis:
    """Put the answer together."""
    search, after = case.search, case.search.screen
    before = case.before
    covariance = _covariance(search.precise)
    findings = _in_order(case, covariance)
    confounded = _confounded(case)
    next_measurement = tuple(
        dict.fromkeys(
            [separating_measurement(name, other) for name, others in confounded.items() for other in others]
            + [one.next_measurement for one in case.unknown if one.next_measurement]
        )
    )
    gap = gaps(before, after)
    more = [refit.name for refit in search.found]
    more += [one.effect.name for one in case.unknown if one.added and one.effect]
    detectable, blind = _power(case)
    verdict = _verdict(findings, case.unknown, confounded, detectable, gap)
    return Diagnosis(
        verdict=verdict,
        found=findings,
        confounded_with=confounded,
        next_measurement=next_measurement,
        unknown=case.unknown,
        not_identifiable=blind,
        refined=tuple(f"{one.name.removeprefix('finer ')}: {', '.join(one.shape.free)}" for one in search.finer),
        gap=gap,
        detectable=detectable,
        where=residual_maps(before),
        where_after=residual_maps(after),
        time_course=time_course(before, after),
        recording=_of_the_recording(case),
        reach=reaches(search.problem, search.solution, {name: _inputs_of(case, name) for name in more}),
        untouched=_untouched(case.signals),
        base_tire=tire_of(case.start, search.problem, before.solution, ()),
        tire=tire_of(case.start, search.problem, search.solution, more),
        signs=FORMULA_SIGNS,
        recording_signs=case.recording.signs,
        seconds=time.perf_counter() - began,
        rows=case.recording.table,
    )


def _inputs_of(case: _Case, effect: str) -> tuple[str, ...]:
    """Return the inputs that an effect acts by."""
    read = {
        symbol.name
        for one in case.start.added if one.name == effect for act in one.acts for symbol in act.expression.free_symbols
    }  # fmt: skip
    known = case.tried[effect].varies if effect in case.tried else ()
    return tuple(name for name in case.signals.names if name in read or name in known)


def _of_the_recording(case: _Case) -> dict[str, Any]:
    """Return what belongs to the recording and not to its tire."""
    search, signals = case.search, case.signals
    told = reported_disturbances(search.problem.disturbances, search.solution.disturbance, signals)
    told["ripple"] = ripple(signals, search.solution.residual, case.start.values["UNLOADED_RADIUS"])
    told["quantisation"] = {
        name: quantisation(case.recording.table[name].to_numpy(np.float64)) for name in signals.channels
    }
    told["smoothing_windows"] = [2 * half + 1 for half in HALF_WIDTHS] if any(signals.input_noise.values()) else []
    told["left_aside"] = dict(signals.left_aside)
    return told


def _untouched(signals: Signals) -> tuple[tuple[int, int], ...]:
    """Return first and last row of each stretch of the hold-out."""
    edges = np.flatnonzero(np.diff(signals.holdout.astype(int), prepend=0, append=0))
    return tuple((int(signals.rows[first]), int(signals.rows[last - 1])) for first, last in edges.reshape(-1, 2))


def tire_of(start: Tire, problem: LeastSquares, solution: Solution, more: Collection[str]) -> Tire:
    """Return the tire that a solution is.

    Parameters
    ----------
    start : Tire
        The start model.
    problem : LeastSquares
    solution : Solution
    more : collection of str
        Names of the effects that were added to it.
    """
    present = set(start.has) | set(more)
    if "relax_load" in present:
        present.discard("relax_lat")
    reads = {s.name for e in start.added if e.name in present for act in e.acts for s in act.expression.free_symbols}
    nominal = {str(quantity.nominal) for quantity in start.book.inputs if quantity.name in reads}
    used = tuple(  # an effect that is off comes along where its card is an input's nominal value
        e for e in start.added if e.name in present or nominal & {card.name for card in e.cards}
    )
    bare = replace(start, effects=tuple(present), added=used, values={
        name: value for name, value in start.values.items() if name not in _beyond(start, used)})  # fmt: skip
    place, factors = problem.simulator.place, bare.rescaled
    values = {name: float(solution.parameters[place[name]]) / factors.get(name, 1.0) for name in bare.book.coefficients}
    inputs = problem.simulator.signals.named()
    seen = [name for name in RANGES if name in inputs and np.ptp(inputs[name]) > 0.0]
    ranges = {name: (float(inputs[name].min()), float(inputs[name].max())) for name in seen}
    return replace(bare, values=values, ranges=ranges)


def _beyond(start: Tire, used: Collection[AddedEffect]) -> set[str]:
    """Return the coefficients of added effects that a tire does not take along."""
    kept = {card.name for effect in used for card in effect.cards}
    return {card.name for effect in start.added for card in effect.cards} - kept


def _covariance(screen: Screen) -> FloatArray:
    """Return standard errors of a solution's coefficients: the coloured sandwich, or blocks left out where larger."""
    inverse = screen.base.inverse
    coloured = np.diag(inverse @ coloured_covariance(screen.tangent, screen.covariance) @ inverse)
    blocks = np.maximum(np.diag(screen.base.jackknife), 0.0)
    # A sandwich of few correlated rows can come out negative: it then says nothing.
    return np.asarray(np.sqrt(np.where(coloured > 0.0, np.maximum(coloured, 0.5 * (coloured + blocks)), blocks)))


def _in_order(case: _Case, errors: FloatArray) -> tuple[Finding, ...]:
    """Return findings and unknown structure in order of evidence."""
    named = [_finding(case, refit, errors) for refit in case.search.found]
    unknown = [
        Finding("UNKNOWN", _shown(one.trace, case.signals), {}, one.p, one.gain, one.gain_error)
        for one in case.search.structures
    ]
    return tuple(sorted([*named, *unknown], key=lambda finding: -finding.cv_gain))


def _shown(trace: Trace, signals: Signals) -> tuple[str, ...]:
    """Return the channels in which a trace shows."""
    power = np.mean((trace.columns @ trace.estimate) ** 2, axis=1)
    return tuple(name for name, size in zip(signals.channels, power, strict=True) if size > 0.02 * power.max())


def _finding(case: _Case, refit: Refit, errors: FloatArray) -> Finding:
    solution = case.search.solution
    wide = float(stats.t.ppf(0.975, case.search.screen.n_blocks - 1))
    coefficients = {}
    for name in refit.shape.free:
        i = solution.free.index(name)
        value, error = float(solution.parameters[case.search.problem.simulator.place[name]]), float(errors[i]) * wide
        coefficients[name] = Interval(value, value - error, value + error)
    return Finding(
        refit.name,
        _shown(refit.trace, case.signals),
        coefficients,
        refit.p,
        refit.gain,
        refit.gain_error,
        _stretches(refit, case.signals),
    )


def _stretches(refit: Refit, signals: Signals) -> tuple[tuple[float, float], ...]:
    """Return the stretches of time that carry two thirds of the evidence."""
    order = np.argsort(-refit.gains)
    carried = np.cumsum(np.maximum(refit.gains[order], 0.0))
    if carried[-1] <= 0.0:
        return ()
    chosen = sorted(order[: int(np.searchsorted(carried, 0.67 * carried[-1])) + 1].tolist())
    t, edges = signals.t[signals.rows], refit.screen.edges
    spans: list[tuple[float, float]] = []
    for g in chosen:
        first, last = float(t[edges[g]]), float(t[min(edges[g + 1], len(t)) - 1])
        if spans and first - spans[-1][1] < 0.5:
            spans[-1] = (spans[-1][0], last)
        else:
            spans.append((first, last))
    return tuple(spans)


def _confounded(case: _Case) -> dict[str, dict[str, float]]:
    """Return, by finding, the other explanations that the data cannot tell from it."""
    search, screen = case.search, case.search.screen
    names = {refit.name for refit in search.found}
    others = {
        name: np.concatenate([tried.trace.columns for tried in search.last if tried.name == name], axis=-1)
        for name in case.tried if name not in names and any(tried.name == name for tried in search.last)
    }  # fmt: skip
    told = {}
    for refit in search.found:
        found = {
            other.name: screen.tangent[:, :, [search.solution.free.index(name) for name in other.shape.free]]
            for other in search.found if other is not refit
        }  # fmt: skip
        size = correlations(screen, refit.shape.free, {**others, **alias_columns(screen)}, found)
        told[refit.name] = {
            name: value for name, value in size.items() if value > TOLD and name != case.tried[refit.name].part_of
        }
    return {name: others for name, others in told.items() if others}


def _power(case: _Case) -> tuple[dict[str, dict[str, float]], dict[str, str]]:
    """Return the smallest traces that would have been named, and the effects that could not have been seen."""
    search = case.search
    found = {refit.name for refit in search.found}
    root = search.screen.problem.root
    away = float(np.sqrt(stats.chi2.isf(LARGEST_P / max(search.tests, 1), 1)))
    detectable: dict[str, dict[str, float]] = {}
    blind: dict[str, str] = {}
    for name, candidate in case.tried.items():
        if name in found:
            continue
        still = [needed for needed in candidate.varies if not varies(case.signals, case.start, needed)]
        traces = [tried.trace for tried in search.last if tried.name == name]
        if still:
            blind[name] = f"{' and '.join(still)} does not vary, or was not recorded"
        elif not traces or not set(candidate.channels) & set(case.signals.channels):
            blind[name] = f"it shows in {', '.join(candidate.channels)}, not recorded here"
        elif traces[0].kept < 0.05:
            blind[name] = "the start model's own coefficients can imitate it here"
        else:
            trace = traces[0]
            k = int(np.argmin(trace.error))
            least = away * float(trace.error[k])
            if least > 5.0:
                blind[name] = "it would have to be five times as large as usual to be seen here"
                continue
            moved = np.where(root > 0.0, trace.columns[:, :, k] / np.where(root > 0.0, root, 1.0), 0.0)
            rms = least * np.sqrt(np.sum(moved**2, axis=1) / np.maximum(np.sum(root > 0.0, axis=1), 1))
            detectable[name] = {
                channel: float(size) for channel, size in zip(case.signals.channels, rms, strict=True) if size > 0.0
            }
    return detectable, blind


def _verdict(
    findings: tuple[Finding, ...], unknown: tuple[Unknown, ...], confounded: Mapping[str, Mapping[str, float]],
    detectable: Mapping[str, Mapping[str, float]], gap: Mapping[str, Mapping[str, Mapping[str, float]]],
) -> str:  # fmt: skip
    """Return the verdict in one line."""
    if findings:
        told = []
        for one in findings:
            if one.effect == "UNKNOWN":
                told.append(f"an unknown effect that depends on {', '.join(unknown[0].depends_on)}")
                continue
            size = confounded.get(one.effect, {})
            others = ", ".join(sorted((name for name in size if size[name] > CONFOUNDED), key=lambda x: -size[x]))
            told.append(one.effect + (f" (the data cannot tell it from {others})" if others else ""))
        return f"Missing: {'; '.join(told)}"
    sizes = {channel: sorted(one[channel] for one in detectable.values() if channel in one) for channel in gap["train"]}
    units = {"Fx": "N", "Fy": "N"}
    text = ", ".join(
        f"{size[len(size) // 2]:.2g} {units.get(channel, 'N m')} in {channel}"
        for channel, size in sizes.items()
        if size
    )
    return f"Nothing material is missing (smallest detectable gap, median over effects: {text})"
