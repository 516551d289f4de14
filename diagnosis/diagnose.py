"""The diagnosis workflow: from a recording and a baseline model to a verdict and an improved tire."""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Mapping
from dataclasses import replace

from tirefmu.boundary.errors import UnknownName, no_single_text
from tirefmu.estimation.nominal_values import check_nominal
from tirefmu.estimation.one_thread import one_blas_thread
from tirefmu.estimation.turn_slip import with_turn_slip
from tirefmu.measurements import Recording, TableLike, check_columns, recording_from
from tirefmu.symbolic import DEFAULT_MODEL
from tirefmu.symbolic.added import AddedEffect
from tirefmu.symbolic.models import model_named, whole_library
from tirefmu.tires import TireLike, tire_from
from tirefmu.tires.tire import Tire

from .explanations.compare import compared
from .explanations.final import final_fits
from .probing.baseline_fit import fit_baseline, worse_by_smoothing
from .probing.candidates import Candidate, candidates_for
from .recording.signals import FORMULA_SIGNS, signals_of
from .verdict.composition import Outcome, composed
from .verdict.result import Diagnosis

#: Options of --nominal and the coefficients that they set.
NOMINAL_COEFFICIENTS = {
    "Fz0": ("FNOMIN",),
    "p0": ("NOMPRES", "INFLPRES"),
    "R0": ("UNLOADED_RADIUS",),
    "V0": ("LONGVL",),
}


#: The steps of a diagnosis, as reported to its progress callback, and their time relative to the first one. Comparisons
#: took 10 to 60 times as long in recordings of 5,000 rows: how many effects are missing is not known in advance.
STEPS = {"fitting the baseline model": 1.0, "comparing explanations": 30.0, "fitting the best explanation": 5.0}
BASELINE, COMPARING, FINAL = STEPS


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
        Fz0, R0, p0, V0 in SI units; Fz0 and R0 are required without a tire.
    tire : Tire, path of a .tir file, or name of a published tire, optional
        Fitted tire as the baseline model; `model`, `effects` and `nominal` are then ignored.
    candidates : collection of str or AddedEffect, optional
        Names: test only these effects. An `AddedEffect` is user-defined; without names it is tested with all others.
    progress : callable, optional
        Called with a sentence at each step.

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
    user_defined = tuple(one for one in candidates or () if isinstance(one, AddedEffect))
    selected = tuple(one for one in candidates or () if isinstance(one, str))
    start = _start_model(model, effects, nominal, None if tire is None else tire_from(tire), user_defined)
    candidates_tried = _chosen(candidates_for(start), selected)
    turning = _with_derived_turn_slip(recording, start, candidates_tried)
    derived = {"phit"} if turning is not recording else set()
    if derived:
        candidates_tried["turn_slip"] = replace(candidates_tried["turn_slip"], has_states=True)
    signals = signals_of(turning.table, start, recording.signs, derived=derived)
    with one_blas_thread():
        report(BASELINE)
        problem, solution = fit_baseline(start, signals, known=tire is not None)
        recorded = signals_of(turning.table, start, recording.signs, smooth=False, derived=derived)
        if worse_by_smoothing(problem, solution, recorded):
            problem, solution = fit_baseline(start, recorded, known=tire is not None)
        report(COMPARING)
        comparison = compared(problem, solution, candidates_tried, report)
        report(FINAL)
        if "turn_slip" in comparison.leader.explanation.effects:
            recording = turning

        def with_final_fits(*, no_formula: str = "") -> Diagnosis:
            fits = final_fits(comparison, problem, solution, start, report, no_formula=no_formula)
            return composed(Outcome(recording, candidates_tried, fits, comparison.answer), began)

        result = with_final_fits()
        if not result.delivered and any(part.effect for part in result.unknown):
            result = with_final_fits(no_formula=f"with it, {'; '.join(result.not_delivered_because)}")
        return result.in_signs("iso")


def _with_derived_turn_slip(recording: Recording, start: Tire, candidates: Mapping[str, Candidate]) -> Recording:
    """Return a recording with phit from the rate of alpha if it was not recorded and turn slip may be missing."""
    absent = "phit" not in recording.table and {"t", "alpha", "V"} <= set(recording.table)
    if absent and "turn_slip" in candidates and "phit" in start.inputs:
        return with_turn_slip(recording)
    return recording


def _start_model(
    model: str, effects: Collection[str], nominal: Mapping[str, float] | None, tire: Tire | None,
    user_defined: tuple[AddedEffect, ...],
) -> Tire:  # fmt: skip
    """Return the baseline model with all added effects in its equations, switched off."""
    if tire is None:
        values: dict[str, float] = {}
        for name, value in (nominal or {}).items():
            values |= dict.fromkeys(set(NOMINAL_COEFFICIENTS[name]) & model_named(model).coefficients.keys(), value)
        no_single_text("effects", effects)
        tire = Tire(model, values, effects=tuple(effects), signs=FORMULA_SIGNS)
    return with_library(tire, user_defined)


def with_library(tire: Tire, user_defined: tuple[AddedEffect, ...] = ()) -> Tire:
    """Return a tire, in the signs of the formula, with all effects of a diagnosis in its equations, switched off.

    Parameters
    ----------
    tire : Tire
    user_defined : tuple of AddedEffect
        In addition to those of the library.

    Returns
    -------
    Tire
    """
    # The library first and in its order: the model with it alone is printed with the package.
    added = {effect.name: effect for effect in (*whole_library(tire.symbolic_model), *tire.added, *user_defined)}
    return replace(tire.in_signs(FORMULA_SIGNS), added=tuple(added.values()), effects=tire.has)


def _chosen(known: dict[str, Candidate], selected: tuple[str, ...]) -> dict[str, Candidate]:
    for name in selected:
        if name not in known:
            raise UnknownName("effect that the model can lack", name, known)
    return {name: known[name] for name in selected} if selected else known
