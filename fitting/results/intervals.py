"""Confidence intervals of what a tire is used for: forces, slip stiffnesses and friction over load and slip."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TypedDict

import numpy as np
import pandas as pd
from scipy.special import ndtri

from ...boundary.errors import FitError
from ...measurements import TableLike, recording_from
from ...numerics.arrays import FloatArray
from ...tires.signs import convert_signs
from ...tires.tire import Tire
from ..checks.read_errors import ReadErrors
from ..problem.rows import inputs_of
from ..uncertainty.sensitivities import sensitivities
from .fitted import Fitted
from .informed_discrepancies import OVER_SLIP, medians, place, readings

#: Roles of the quantities over load.
OVER_LOAD = ("stiffness_x", "stiffness_y", "friction_x", "friction_y")
#: Number of loads, if they have no levels, and of slips of the listed intervals.
LOADS, SLIPS = 5, 9


class ListedInterval(TypedDict):
    """The 95 % interval of a quantity; `at`: the inputs that differ from the medians of the data."""

    quantity: str
    at: dict[str, float]
    value: float
    lower: float
    upper: float


def interval(
    result: Fitted, quantity: str, table: TableLike, *, signs: str | None = None, level: float = 0.95
) -> pd.DataFrame:
    """Return a force or a named quantity at the rows of a table with its confidence interval.

    `quantity`: "Fy", "K_yalpha", "mu_x", ... `table`: inputs; an absent input has its nominal value. `signs`:
    convention of the table and of the result; by default that of the format, and "iso" for a DataFrame. `level`:
    confidence level, between 0 and 1. Returns: ``value``, ``error`` (standard error), ``lower`` and ``upper`` by row.
    Raises `FitError` if the level is not between 0 and 1, or the result has no covariance. Raises `UnknownName` if the
    model has no such output or quantity. Raises `DataError`, `WrongType`: see `tirefmu.measurements.recording_from`.
    """
    if not 0.0 < level < 1.0:
        raise FitError(f"confidence level {level:g} is not between 0 and 1")
    if not len(result.uncertainty.complete):
        raise FitError("the fit has no covariance: none of its stages used all rows of its channels")
    recording = recording_from(table, signs=signs)
    return band(result, quantity, recording.table, recording.signs, level)


def band(result: Fitted, quantity: str, table: pd.DataFrame, signs: str, level: float = 0.95) -> pd.DataFrame:
    """Return the same as `interval` for a table of the program itself, without checks.

    `signs`: convention of the table.
    """
    formula = "iso" if signs == "iso" else "adapted-sae"
    tire = result.tire.in_signs(formula)
    rows = convert_signs(table, signs, formula)
    declarations = tire.symbolic_model.coefficients
    covariance = result.uncertainty.complete
    flips = np.array([-1.0 if formula != result.signs and declarations[n].flips else 1.0 for n in covariance.index])
    inputs = inputs_of(rows, tire)
    value, slopes, names = sensitivities(tire, quantity, inputs)
    by_name = pd.DataFrame(slopes.T, columns=names).reindex(columns=covariance.index, fill_value=0.0)
    variance = np.einsum("ni,ij,nj->n", by_name, covariance * np.outer(flips, flips), by_name)
    in_adapted = by_name * [-1.0 if formula == "iso" and declarations[n].flips else 1.0 for n in covariance.index]
    variance += _form_variance(result, tire, quantity, inputs, value, in_adapted)
    error = np.sqrt(np.maximum(variance, 0.0))
    written = convert_signs(pd.DataFrame({quantity: value}), formula, signs)[quantity].to_numpy()
    half = float(ndtri(0.5 + 0.5 * level)) * error
    columns = {"value": written, "error": error, "lower": written - half, "upper": written + half}
    return pd.DataFrame(columns, rows.index)


def _form_variance(
    result: Fitted, tire: Tire, quantity: str, inputs: FloatArray, value: FloatArray, slopes: pd.DataFrame
) -> FloatArray:
    """Return what errors of the form add to the variance, which has what they do to the coefficients.

    `slopes`: derivatives by the coefficients in adapted SAE, by row. Where stiffness and friction are read from the
    data, these readings say what the error is, in place of the residual of all rows.
    """
    added = np.zeros(len(value))
    read = _read_errors(result, quantity) if result.uncertainty.discrepancies else None
    for discrepancy, informed in zip(result.uncertainty.discrepancies, result.discrepancies, strict=True):
        by_name = slopes[list(discrepancy.names)].to_numpy()
        at = place(tire, quantity, discrepancy.channel, inputs) if discrepancy.final else None
        if read is not None:
            added -= np.einsum("ni,ij,nj->n", by_name, discrepancy.covariance, by_name)
        elif at is not None:
            at = at[[tire.inputs.index(name) for name in discrepancy.features.names]]  # without those of later effects
            added += informed.variance(by_name.T, value, at) - discrepancy.variance(by_name.T, 0.0 * value, at)
    if read is not None:
        added += value**2 * read.squares(pd.DataFrame(dict(zip(tire.inputs, inputs, strict=True))))
    return added


def _read_errors(result: Fitted, quantity: str) -> ReadErrors | None:
    """Return the errors of a stiffness or friction in the conditions in which it was read; None for others."""
    model = result.tire.symbolic_model
    roles = {model.quantity(role): role for role in OVER_LOAD if role in model.roles}
    if quantity not in roles:
        return None
    kind, channel = roles[quantity].split("_")[0], f"F{roles[quantity][-1]}"
    shown = readings(result.findings, kind, channel)
    conditions = pd.DataFrame([{**reading.at, "Fz": reading.load} for reading in shown])
    deviations = [reading.error / reading.read for reading in shown]
    return ReadErrors.of(conditions, [reading.off for reading in shown], deviations)


def listed_intervals(result: Fitted) -> Iterator[ListedInterval]:
    """Yield the 95 % intervals over the measured range: by load, and of the forces by load and slip, in ISO.

    Yields: none without fitted rows or covariance.
    """
    residuals, model = result.residuals, result.tire.symbolic_model
    if residuals is None or not len(result.uncertainty.complete):
        return
    table = convert_signs(residuals.table, "adapted-sae", "iso")
    tested = residuals.levels.get("Fz", ())
    loads = np.array(tested) if tested else np.linspace(table["Fz"].min(), table["Fz"].max(), LOADS)
    held = medians(table, result.tire)
    for role in OVER_LOAD:
        if role in model.roles and f"F{role[-1]}" in residuals.channels:
            rows = pd.DataFrame({"Fz": loads}).assign(**held)
            yield from _records(result, model.quantity(role), rows, ("Fz",))
    for force, slip in OVER_SLIP.items():
        if force in residuals.channels:
            slips = np.linspace(table[slip].min(), table[slip].max(), SLIPS)
            rows = pd.DataFrame({"Fz": np.repeat(loads, SLIPS), slip: np.tile(slips, len(loads))}).assign(**held)
            yield from _records(result, force, rows, ("Fz", slip))


def _records(result: Fitted, quantity: str, rows: pd.DataFrame, varied: tuple[str, ...]) -> Iterator[ListedInterval]:
    intervals = band(result, quantity, rows, "iso")
    for (_, at), (_, row) in zip(rows.iterrows(), intervals.iterrows(), strict=True):
        yield {
            "quantity": quantity, "at": {name: float(at[name]) for name in varied}, "value": float(row["value"]),
            "lower": float(row["lower"]), "upper": float(row["upper"]),
        }  # fmt: skip
