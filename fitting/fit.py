"""From recordings to a tire: the data made ready, the recipe's stages solved one after another, the result told."""

from __future__ import annotations

import time
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd

from tirefmu.measurements import INPUTS, OUTPUTS, Recording, check_plausible, read_recording
from tirefmu.symbolic import model as book_of
from tirefmu.symbolic.errors import DataError, FitError, UnknownName
from tirefmu.symbolic.model import Model
from tirefmu.tires.tire import Tire

from .method import solver_for
from .recipe import load_recipe
from .result import FitResult
from .session import Progress, Session

#: What --nominal may name, and the coefficient that it sets.
NOMINAL = {"Fz0": "FNOMIN", "R0": "UNLOADED_RADIUS", "p0": "NOMPRES", "V0": "LONGVL"}
#: The inputs of which one has to vary by 0.01 for a channel to tell something of the tire; none for My.
EXCITED_BY = {"Fx": ("kappa",), "Fy": ("alpha",), "Mz": ("alpha",), "Mx": ("alpha", "gamma"), "My": ()}
LEAST_VARIATION = 0.01


def fit(
    tables: Sequence[str | Path | Recording],
    model: str = "mf96",
    *,
    start: Tire | None = None,
    effects: Collection[str] | None = None,
    without: Collection[str] = (),
    recipe: str = "progressive",
    method: str = "ipopt",
    iterations: int | None = None,
    seed: int = 0,
    nominal: Mapping[str, float] | None = None,
    signs: str | None = None,
    progress: Progress | None = None,
) -> FitResult:
    """Fit a tire to recordings of a test bench.

    Parameters
    ----------
    tables : sequence of path or Recording
        Together they are the data; each may have its own signs.
    model : str
    start : Tire, optional
        Values to start from; generic ones where None.
    effects : collection of str, optional
        Exactly these effects on top of the model's core; all of the model where None.
    without : collection of str
        Effects to leave out.
    recipe : str
        "progressive", "joint", "trento", "scaling" (of the start tire) or the path of a TOML file.
    method : {"ipopt", "ioa"}
        IPOPT with exact derivatives, or the UNICAMP paper's evolutionary algorithm (`tirefmu.fitting.evolution`).
    iterations : int, optional
        The most that a stage may take; the method's own limit (300, 10,000) where None.
    seed : int
        Of a method that draws at random.
    nominal : mapping of str to float, optional
        Fz0 (N), R0 (m), p0 (Pa), V0 (m/s), as far as the model has them; the medians of the data and 0.3 m where
        not given.
    signs : str, optional
        Convention of the files, where it is not the format's default.
    progress : callable, optional
        Called with stage, iteration and cost.

    Returns
    -------
    FitResult
        Also where the solver did not converge: `FitResult.ok` says so.

    Raises
    ------
    UnknownName, DataError, FitError
        If something that was asked for does not exist or does not fit together.
    """
    began = time.perf_counter()
    book = book_of(model)
    plan = load_recipe(recipe, model)
    solver = solver_for(method, iterations, seed)
    if plan.scales and start is None:
        raise FitError(f"recipe {plan.name} scales a given tire: say which to start from (--start)")
    recordings = [_ready(table, signs) for table in tables]
    if not recordings:
        raise FitError("no table to fit")
    present = _effects(book, start, effects, without)
    data, notes = _together(recordings, book)
    tire = _starting_tire(book, present, start, data, nominal or {}, notes)
    session = Session(book, tire, data, plan, progress, notes, solver=solver, given=start is not None)
    for stage in plan.stages:
        session.run(stage)
    told = "iso" if all(recording.signs == "iso" for recording in recordings) else "adapted-sae"
    return replace(session.result(recordings, told, time.perf_counter() - began), method=method)


def _ready(table: str | Path | Recording, signs: str | None) -> Recording:
    recording = table if isinstance(table, Recording) else read_recording(table, signs=signs)
    _check_numbers(recording)
    check_plausible(recording)
    recording.measured()  # says which column a misnamed channel may be
    return recording


def _check_numbers(recording: Recording) -> None:
    """Refuse what only a table made in memory can have; files are checked when they are read."""
    if not len(recording):
        raise DataError(f"{recording.source}: no rows")
    for name in (*INPUTS, *OUTPUTS):
        values = recording.table[name].to_numpy(dtype=float) if name in recording.table else np.zeros(0)
        bad = np.flatnonzero(np.isinf(values) if name in OUTPUTS else ~np.isfinite(values))
        if bad.size:
            raise DataError(f"{recording.source}: row {bad[0] + 1}: {name} is {values[bad[0]]}")


def _effects(
    book: Model, start: Tire | None, effects: Collection[str] | None, without: Collection[str]
) -> frozenset[str]:
    given = start.has if effects is None and start is not None else effects
    return (book.usual_effects if given is None else book.known_effects(given)) - book.known_effects(without)


def _together(recordings: Sequence[Recording], book: Model) -> tuple[pd.DataFrame, list[str]]:
    """Put the recordings into one table in adapted SAE; take out channels whose slip a recording does not vary."""
    tables, notes, segments = [], [], 0
    outputs = [quantity.name for quantity in book.outputs]
    for number, recording in enumerate(recordings):
        table = recording.with_signs("adapted-sae").table
        for channel in (name for name in outputs if name in table):
            by = EXCITED_BY[channel]
            if by and not any(slip in table and np.ptp(table[slip].to_numpy()) >= LEAST_VARIATION for slip in by):
                table = table.assign(**{channel: np.nan})
                notes.append(f"{recording.source}: {channel} is not fitted, {' or '.join(by)} does not vary there")
        pieces = recording.segments()
        segment = np.repeat(np.arange(segments, segments + len(pieces)), [piece.stop - piece.start for piece in pieces])
        segments += len(pieces)
        tables.append(table.assign(recording=number, segment=segment))
    data = pd.concat(tables, ignore_index=True)
    if not any(name in data and data[name].notna().any() for name in outputs):
        raise FitError(f"none of {', '.join(outputs)} is measured over a varying slip: nothing to fit")
    return data, notes


def _starting_tire(
    book: Model,
    present: frozenset[str],
    start: Tire | None,
    data: pd.DataFrame,
    nominal: Mapping[str, float],
    notes: list[str],
) -> Tire:
    for name in nominal:
        if name not in NOMINAL:
            raise UnknownName("nominal value", name, NOMINAL)
        if not nominal[name] > 0:
            raise FitError(f"nominal {name} = {nominal[name]:g} is not positive")
        if NOMINAL[name] not in book.coefficients:
            notes.append(f"nominal {name} has no place in {book.name}")
    given = {NOMINAL[name]: value for name, value in nominal.items() if NOMINAL[name] in book.coefficients}
    if start is not None:
        if start.model != book.name:
            raise FitError(f"the start tire is {start.model}, not {book.name}")
        values = {**start.in_signs("adapted-sae").values, **given}
        return Tire(book.name, values, effects=present, signs="adapted-sae", name=start.name, about=start.about)
    values = {"UNLOADED_RADIUS": 0.3, **_medians(book, data, given, notes), **given}
    if "UNLOADED_RADIUS" not in given:
        notes.append("radius R0 not given: 0.3 m (it only scales the moment coefficients)")
    if "FNOMIN" not in values:
        raise FitError("no load Fz in the data: say --nominal Fz0=...")
    return Tire(book.name, values, effects=present, signs="adapted-sae")


def _medians(book: Model, data: pd.DataFrame, given: Mapping[str, float], notes: list[str]) -> dict[str, float]:
    """Return the nominal values that nobody gave, from the data: medians of two digits, noted."""
    values = {}
    for name, coefficient, text, unit in (
        ("Fz", "FNOMIN", "load", "N"),
        ("p", "NOMPRES", "pressure p0", "Pa"),
        ("V", "LONGVL", "speed V0", "m/s"),
    ):
        if coefficient not in book.coefficients or coefficient in given or name not in data:
            continue
        median = float(f"{data[name].median():.2g}")
        if median > 0:
            values[coefficient] = median
            notes.append(f"nominal {text} not given: the median, {median:g} {unit}")
    if "INFLPRES" in book.coefficients and {"NOMPRES"} & {*values, *given.keys()}:
        # Where a user of the tire says nothing of pressure, it has the nominal one.
        values["INFLPRES"] = given.get("NOMPRES", values.get("NOMPRES", 0.0))
    return values
