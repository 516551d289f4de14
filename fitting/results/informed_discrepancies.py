"""Errors of the form of the model, with what the characteristics of the data say of them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd

from ...numerics.arrays import FloatArray
from ...numerics.ties import graded
from ...tires.code import fastest_code
from ...tires.tire import Tire
from ..checks.characteristics import Characteristic
from ..checks.diagnostics import Findings
from ..checks.read_errors import READING_ERROR
from ..checks.residuals import Residuals
from ..checks.slip_stiffness import SlipStiffness
from ..problem.rows import inputs_of
from ..uncertainty.discrepancy import Discrepancy
from ..uncertainty.sensitivities import sensitivities

#: The forces over their own slip.
OVER_SLIP = {"Fx": "kappa", "Fy": "alpha"}
#: Slips among which the peak of a force is found, for the error of the form at the peak.
PEAK_SLIPS = tuple(np.linspace(0.02, 0.3, 15).tolist())


def informed_discrepancies(
    tire: Tire, residuals: Residuals | None, discrepancies: Sequence[Discrepancy], findings: Findings
) -> tuple[Discrepancy, ...]:
    """Return the errors of the form with what slip stiffnesses and peaks that are read from the data say of them."""
    return tuple(
        _informed(tire.in_signs("adapted-sae"), residuals, findings, discrepancy)
        if discrepancy.final and discrepancy.channel in OVER_SLIP
        else discrepancy
        for discrepancy in discrepancies
    )


def _informed(tire: Tire, residuals: Residuals | None, findings: Findings, discrepancy: Discrepancy) -> Discrepancy:
    channel = discrepancy.channel
    if residuals is None:
        return discrepancy
    for kind in ("stiffness", "friction"):
        quantity = tire.symbolic_model.quantity(f"{kind}_{channel[-1]}")
        read = readings(findings, kind, channel)
        if not read or not quantity:
            continue
        table = pd.DataFrame([{**medians(residuals.table, tire), **reading.at, "Fz": reading.load} for reading in read])
        inputs = inputs_of(table, tire)
        value, slopes, names = sensitivities(tire, quantity, inputs)
        at = place(tire, quantity, channel, inputs)
        if at is None:
            continue
        by_name = pd.DataFrame(slopes.T, columns=names).reindex(columns=list(discrepancy.names), fill_value=0.0)
        off = np.array([reading.off for reading in read])
        deviation = np.hypot([reading.error / reading.read for reading in read], READING_ERROR)
        rows = [tire.inputs.index(name) for name in discrepancy.features.names]
        discrepancy = discrepancy.informed(by_name.to_numpy().T / value, np.ones(len(read)), at[rows], off, deviation)
    return discrepancy


def readings(findings: Findings, kind: str, channel: str) -> list[Characteristic] | list[SlipStiffness]:
    """Return the slip stiffnesses or peak frictions of a channel that are read from the data."""
    if kind == "stiffness":
        return [s for s in findings.stiffnesses if s.channel == channel and np.isfinite(s.error)]
    frictions = (c for c in findings.characteristics if c.quantity == "peak friction" and c.shown)
    return [c for c in frictions if c.channel == channel and np.isfinite(c.error)]


def medians(table: pd.DataFrame, tire: Tire) -> dict[str, float]:
    """Return the medians of the held inputs."""
    return {n: float(table[n].median()) for n in tire.inputs if n in table and n not in ("kappa", "alpha", "Fz")}


def place(tire: Tire, quantity: str, channel: str, inputs: FloatArray) -> FloatArray | None:
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
