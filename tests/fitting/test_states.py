"""A fit of effects with states: they are simulated over the recording."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from tirefmu.fitting import fit
from tirefmu.symbolic.added import library
from tirefmu.tires import Tire

VALUES = {
    "FNOMIN": 4000.0, "UNLOADED_RADIUS": 0.3, "WIDTH": 0.2, "VERTICAL_STIFFNESS": 2e5, "CSLIP": 8e4, "CALPHA": 9e4,
    "UMIN": 1.0, "UMAX": 1.1, "HTAU": 5.0,
}  # fmt: skip
EFFECTS = ("heat_friction", "slip_history")
ADDED = tuple(library()[name] for name in EFFECTS)


@pytest.mark.slow
def test_coefficients_of_memory_are_found():
    """The start tire heats its tread otherwise: the fit simulates the states again with its own result."""
    t = np.linspace(0.0, 16.0, 900)
    table = pd.DataFrame({"t": t, "alpha": 0.16 * np.sin(1.6 * t), "Fz": 3000.0 + 80.0 * t, "V": 12.0})
    truth = Tire("fiala", {**VALUES, "HMU": 0.24, "SHMUX": 0.05, "SHMUY": 0.05}, effects=EFFECTS, added=ADDED)
    table["Fy"] = truth.evaluate(table)["Fy"]
    start = Tire("fiala", {**VALUES, "UMAX": 1.05, "UMIN": 0.9, "CALPHA": 7e4}, effects=EFFECTS, added=ADDED)
    result = fit(table, start=start, screening=False)
    for name, share in (("HMU", 0.05), ("SHMUY", 0.02), ("UMAX", 0.01)):
        assert abs(result.tire.values[name] / truth.values[name] - 1.0) < share, name
    assert result.tire.values["HTAU"] == 5.0  # in the equation of a state: not fitted
    error = result.tire.evaluate(table)["Fy"] - table["Fy"]
    without = fit(table, start=start, effects=(), screening=False).tire.evaluate(table)["Fy"] - table["Fy"]
    assert np.sqrt(np.mean(error**2)) < 0.02 * np.sqrt(np.mean(without**2))
