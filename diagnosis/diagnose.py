"""The diagnosis workflow: from a recording and a baseline model to a verdict and an improved tire."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Mapping
from dataclasses import replace

from ..boundary.errors import UnknownName, no_single_text
from ..boundary.named_options import named
from ..measurements import Recording, TableLike, check_columns, recording_from
from ..measurements.nominal_values import NOMINAL, check_nominal
from ..measurements.turn_slip import with_turn_slip
from ..numerics.one_thread import one_blas_thread
from ..symbolic import DEFAULT_MODEL
from ..symbolic.added import AddedEffect
from ..symbolic.models import model_named, whole_library
from ..tires import TireLike, tire_from
from ..tires.property_file.names import in_written_order, not_measured_lines
from ..tires.tire import Tire
from .explanations.budget import Budget
from .explanations.compare import compared
from .explanations.explanation import Explanation
from .explanations.final import final_fits
from .probing.baseline_fit import fit_baseline, worse_by_smoothing
from .probing.candidates import Candidate, candidates_for
from .signals.predicted_temperature import (
    TEMPERATURE,
    with_predicted_temperature,
)
from .signals.signals import FORMULA_SIGNS, signals_of
from .verdict.composition import DiagnosisOutcome, composed
from .verdict.improved_tire import tire_of
from .verdict.result import Diagnosis

#: The steps of a diagnosis, as reported to its progress callback.
STEPS = ("fitting the baseline model", "comparing explanations", "fitting the best explanation")
BASELINE, COMPARING, FINAL = STEPS


@named()
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
    time_limit: float | None = None,
    form: bool = True,
) -> Diagnosis:
    """Identify the effects that a baseline model lacks to explain a recording.

    Parameters
    ----------
    table : path, DataFrame or Recording
        SI units: ``t``, the inputs and at least one output.
    signs : {"iso", "sae", "adapted-sae"}, optional
        Sign convention of the table. Default: that of the file format, "iso" for a DataFrame.
    model : str
        Model of the baseline if no tire is given.
    effects : collection of str
        Effects of the baseline model in addition to the core formula.
    nominal : mapping of str to float
        Fz0, R0, p0, V0 in SI units. Without a tire, those that are not given are taken from the recording, as by a fit.
    tire : Tire, path of a .tir file, or name of a published tire, optional
        Fitted tire as the baseline model; `model`, `effects` and `nominal` are then ignored.
    candidates : collection of str or AddedEffect, optional
        Names: test only these effects. An `AddedEffect` is user-defined; without names it is tested with all others.
    progress : callable, optional
        Called with a sentence at each step, and with what leads. If it raises `KeyboardInterrupt` while explanations
        are compared, or Ctrl-C is pressed then, the result is the best explanation so far (`Diagnosis.stopped`).
    time_limit : float, optional
        Seconds. Explanations that are not compared within 60 % of it are not; the result is marked in the same way.
        The final fits end after 85 % of it.
    form : bool
        Whether the improved tire may have a correction of the formula's own form, effect "form".

    Returns
    -------
    Diagnosis
        Coefficients and offsets are in ISO-W signs, as in the tire file; `Diagnosis.in_signs` converts them.

    Raises
    ------
    DataError
        If the recording cannot be used, or contradicts its sign convention.
    UnknownName
        If a model, an effect, a tire or a convention does not exist.
    WrongType
        If the table or the tire is of another type.
    """
    recording = recording_from(table, signs=signs)
    check_columns(recording)
    if tire is None:
        check_nominal(nominal or {}, model_named(model), [recording.table])
    began = time.perf_counter()
    report = progress or (lambda sentence: None)
    no_single_text("candidates", candidates)
    user_defined = tuple(candidate for candidate in candidates or () if isinstance(candidate, AddedEffect))
    selected = tuple(candidate for candidate in candidates or () if isinstance(candidate, str))
    start = tire_from(tire) if tire is not None else _start_model(recording, model, effects, nominal)
    start = with_library(start, user_defined)
    candidates_tried = _chosen(candidates_for(start), selected)
    turning = _with_derived_turn_slip(recording, start, candidates_tried)
    derived = {"phit"} if turning is not recording else set()
    if derived:
        candidates_tried["turn_slip"] = replace(candidates_tried["turn_slip"], has_states=True)
    signals = signals_of(turning.table, start, recording.signs, derived=derived)
    with one_blas_thread(), Budget(report, time_limit) as budget:
        report(BASELINE)
        problem, solution = fit_baseline(start, signals, fitted=tire is not None)
        recorded = signals_of(turning.table, start, recording.signs, smooth=False, derived=derived)
        if not (smooth := not worse_by_smoothing(problem, solution, recorded)):
            problem, solution = fit_baseline(start, recorded, fitted=tire is not None)
        complete = with_predicted_temperature(turning, tire_of(problem, solution, ()))
        if complete is not turning:
            derived = {*derived, TEMPERATURE}
            signals = signals_of(complete.table, start, recording.signs, smooth=smooth, derived=derived)
            problem = problem.over(problem.simulator.with_signals(signals))
            reading = {name: tried for name, tried in candidates_tried.items() if TEMPERATURE in tried.requires}
            candidates_tried |= {name: replace(tried, has_states=True) for name, tried in reading.items()}
        report(COMPARING)
        comparison = compared(problem, solution, candidates_tried, budget)
        report(FINAL)
        read = _read(comparison.leader.explanation, candidates_tried)
        derived_table = complete.table[[name for name in complete.table if name in recording.table or name in read]]
        recorded_or_read = replace(complete, table=derived_table)

        def with_final_fits(*, no_formula: str = "", correct_form: bool = form) -> Diagnosis:
            fits = final_fits(comparison, problem, solution, budget, no_formula=no_formula, correct_form=correct_form)
            outcome = DiagnosisOutcome(recorded_or_read, candidates_tried, fits, comparison.stopped)
            return composed(outcome, began)

        result = with_final_fits()
        if not result.delivered and result.form.channels and not budget.late:
            result = with_final_fits(correct_form=False)
        if not result.delivered and any(part.effect for part in result.unknown) and not budget.late:
            result = with_final_fits(no_formula=f"with it, {'; '.join(result.not_delivered_because)}")
        return result.in_signs("iso")


def _read(explanation: Explanation, candidates: Mapping[str, Candidate]) -> set[str]:
    """Return the inputs that the parts of an explanation read."""
    of_terms = (term.depends_on for term in explanation.terms)
    return set().union(*of_terms, *(candidates[name].requires for name in explanation.effects))


def _with_derived_turn_slip(recording: Recording, start: Tire, candidates: Mapping[str, Candidate]) -> Recording:
    """Return a recording with phit from the rate of alpha if it was not recorded and turn slip may be missing."""
    absent = "phit" not in recording.table and {"t", "alpha", "V"} <= set(recording.table)
    if absent and "turn_slip" in candidates and "phit" in start.inputs:
        return with_turn_slip(recording)
    return recording


def _start_model(
    recording: Recording, model: str, effects: Collection[str], nominal: Mapping[str, float] | None
) -> Tire:
    """Return the baseline model for a recording."""
    from ..fitting.data.dimensions import dimensions
    from ..fitting.setup import nominal_values

    no_single_text("effects", effects)
    declared = model_named(model)
    named = {NOMINAL[name]: value for name, value in (nominal or {}).items()}
    given, sizes = (
        {name: value for name, value in values.items() if name in declared.coefficients}
        for values in (named, dimensions([recording], None)[0])
    )
    values = nominal_values(declared, recording.with_signs(FORMULA_SIGNS).table, given, sizes, [])
    start = Tire(model, values, effects=tuple(effects), signs=FORMULA_SIGNS)
    return replace(start, other_entries=_not_measured(start, recording))


def _not_measured(start: Tire, recording: Recording) -> tuple[tuple[str, str, str], ...]:
    """Return the entries of the tire file on outputs that were not measured, with their coefficients."""
    measured = set(recording.measured())
    absent = [output for output in start.outputs if output not in measured]
    sentence = f"{', '.join(absent)} {'is' if len(absent) == 1 else 'are'} not determined: not measured"
    declared = start.symbolic_model.coefficients.items()
    names = [name for name, entry in declared if entry.fitted and measured.isdisjoint(entry.channels)]
    return in_written_order(not_measured_lines([sentence], names), start.symbolic_model) if absent else ()


def with_library(tire: Tire, user_defined: tuple[AddedEffect, ...] = ()) -> Tire:
    """Return a tire, in the signs of the formula, with all effects of a diagnosis in its equations, switched off.

    `user_defined`: in addition to those of the library.
    """
    # The library first and in its order: the model with it alone is printed with the package.
    added = {effect.name: effect for effect in (*whole_library(tire.symbolic_model), *tire.added, *user_defined)}
    return replace(tire.in_signs(FORMULA_SIGNS), added=tuple(added.values()), effects=tire.has)


def _chosen(candidates: dict[str, Candidate], selected: tuple[str, ...]) -> dict[str, Candidate]:
    for name in selected:
        if name not in candidates:
            raise UnknownName("effect that the model can lack", name, candidates)
    return {name: candidates[name] for name in selected} if selected else candidates
