"""Confidence intervals of what a tire is used for: forces, slip stiffnesses and friction over load and slip."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, TypedDict

import numpy as np
import pandas as pd
from scipy.special import ndtri

from ...boundary.errors import FitError
from ...measurements import TableLike, recording_from
from ...numerics.arrays import FloatArray
from ...numerics.ties import graded
from ...tires.code import fastest_code
from ...tires.signs import convert_signs
from ...tires.tire import Tire
from ..problem.rows import inputs_of
from ..uncertainty.sensitivities import sensitivities

if TYPE_CHECKING:
    from .fit_result import FitResult


#: Roles of the quantities over load, and the forces over their own slip.
OVER_LOAD = ("stiffness_x", "stiffness_y", "friction_x", "friction_y")
OVER_SLIP = {"Fx": "kappa", "Fy": "alpha"}
#: Number of loads and slips of the listed intervals.
LOADS, SLIPS = 5, 9
#: Slips among which the peak of a force is found, for the error of the form at the peak.
PEAK_SLIPS = tuple(np.linspace(0.02, 0.3, 15).tolist())


class ListedInterval(TypedDict):
    """The 95 % interval of a quantity; `at`: the inputs that differ from the medians of the data."""

    quantity: str
    at: dict[str, float]
    value: float
    lower: float
    upper: float


def interval(
    result: FitResult, quantity: str, table: TableLike, *, signs: str | None = None, level: float = 0.95
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
    if not len(result.solution.covariance):
        raise FitError("the fit has no covariance: none of its stages used all rows of its channels")
    recording = recording_from(table, signs=signs)
    return band(result, quantity, recording.table, recording.signs, level)


def band(result: FitResult, quantity: str, table: pd.DataFrame, signs: str, level: float = 0.95) -> pd.DataFrame:
    """Return the same as `interval` for a table of the program itself, without checks.

    `signs`: convention of the table.
    """
    formula = "iso" if signs == "iso" else "adapted-sae"
    tire = result.tire.in_signs(formula)
    rows = convert_signs(table, signs, formula)
    declarations = tire.symbolic_model.coefficients
    covariance = result.solution.covariance
    flips = np.array([-1.0 if formula != result.signs and declarations[n].flips else 1.0 for n in covariance.index])
    inputs = inputs_of(rows, tire)
    value, slopes, names = sensitivities(tire, quantity, inputs)
    by_name = pd.DataFrame(slopes.T, columns=names).reindex(columns=covariance.index, fill_value=0.0)
    variance = np.einsum("ni,ij,nj->n", by_name, covariance * np.outer(flips, flips), by_name)
    in_adapted = by_name * [-1.0 if formula == "iso" and declarations[n].flips else 1.0 for n in covariance.index]
    for discrepancy in result.solution.discrepancies:  # the covariance has what they do to the coefficients
        at = _place(tire, quantity, discrepancy.channel, inputs) if discrepancy.final else None
        if at is not None:
            slopes_of_channel = in_adapted[list(discrepancy.names)].to_numpy().T
            at = at[
                [tire.inputs.index(name) for name in discrepancy.features.names]
            ]  # effects added later have further ones
            variance += discrepancy.variance(slopes_of_channel, value, at) - discrepancy.variance(
                slopes_of_channel, 0.0 * value, at
            )
    error = np.sqrt(np.maximum(variance, 0.0))
    written = convert_signs(pd.DataFrame({quantity: value}), formula, signs)[quantity].to_numpy()
    half = float(ndtri(0.5 + 0.5 * level)) * error
    columns = {"value": written, "error": error, "lower": written - half, "upper": written + half}
    return pd.DataFrame(columns, rows.index)


def _place(tire: Tire, quantity: str, channel: str, inputs: FloatArray) -> FloatArray | None:
    """Return the inputs at which a channel determines a quantity that is proportional to it; None for others."""
    if quantity == channel:
        return inputs
    model, slip, axis = tire.symbolic_model, {"Fx": "kappa", "Fy": "alpha"}.get(channel), channel[-1:]
    roles = {model.quantity(f"{kind}_{axis}"): kind for kind in ("stiffness", "friction") if slip}
    if slip is None or quantity not in roles:
        return None
    at, slip_row = inputs.copy(), tire.inputs.index(slip)
    at[[tire.inputs.index("kappa"), tire.inputs.index("alpha")]] = 0.0
    if roles[quantity] == "friction":
        forces = []
        for value in PEAK_SLIPS:
            at[slip_row] = value
            computed = fastest_code(model).forces(tire.effective_inputs(at), tire.parameters())
            forces.append(np.abs(computed[tire.outputs.index(channel)]))
        at[slip_row] = np.array(PEAK_SLIPS)[np.argmax(graded(forces), axis=0)]
    return at


def listed_intervals(result: FitResult) -> Iterator[ListedInterval]:
    """Yield the 95 % intervals over the measured range: by load, and of the forces by load and slip, in ISO.

    Yields: none without fitted rows or covariance.
    """
    evidence, model = result.solution.residuals, result.tire.symbolic_model
    if evidence is None or not len(result.solution.covariance):
        return
    table = convert_signs(evidence.table, "adapted-sae", "iso")
    loads = np.linspace(table["Fz"].min(), table["Fz"].max(), LOADS)
    held = {n: float(table[n].median()) for n in result.tire.inputs if n in table and n not in ("kappa", "alpha", "Fz")}
    for role in OVER_LOAD:
        if role in model.roles and f"F{role[-1]}" in evidence.channels:
            rows = pd.DataFrame({"Fz": loads}).assign(**held)
            yield from _records(result, model.quantity(role), rows, ("Fz",))
    for force, slip in OVER_SLIP.items():
        if force in evidence.channels:
            slips = np.linspace(table[slip].min(), table[slip].max(), SLIPS)
            rows = pd.DataFrame({"Fz": np.repeat(loads, SLIPS), slip: np.tile(slips, LOADS)}).assign(**held)
            yield from _records(result, force, rows, ("Fz", slip))


def _records(result: FitResult, quantity: str, rows: pd.DataFrame, varied: tuple[str, ...]) -> Iterator[ListedInterval]:
    intervals = band(result, quantity, rows, "iso")
    for (_, at), (_, row) in zip(rows.iterrows(), intervals.iterrows(), strict=True):
        yield {
            "quantity": quantity, "at": {name: float(at[name]) for name in varied}, "value": float(row["value"]),
            "lower": float(row["lower"]), "upper": float(row["upper"]),
        }  # fmt: skip
