"""Printed derivatives of states: against NumPy, and integrated against the evaluation of a recording."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from .conftest import command_of
from .test_gradients import module_of

#: The effects of tests/fmu/test_memory.py: their code is printed once for both.
EFFECTS = ("heat_friction", "slip_history", "break_in", "load_lag", "relax_lat", "relax_lon")
STATES = {"HTAU": 0.5, "HMU": 0.016, "SHLEN": 0.3, "SHWID": 0.02, "SHMUX": 0.05, "SHMUY": 0.05,
          "BIMU": 0.1, "BIWORK": 5.0, "SIGX": 0.2, "SIGY": 0.4}  # fmt: skip


@pytest.fixture(scope="module")
def late(mf61):
    """Return a tire in which both slips lag and sliding heats the tread."""
    return replace(mf61, values={**mf61.values, **STATES}, effects={*mf61.has, *EFFECTS})


@pytest.fixture(scope="module")
def folder(late, printout):
    return printout(late, "numpy", "late", functions=["forces", "states"])


def test_states_at_lagged_slips(folder, assert_agrees):
    """Forces at the lagged slips drive the heat, the wheel's slips drive the lags."""
    assert_agrees(command_of("numpy", folder), folder, ["forces", "states"])


def after_step(x, derivative, decay, h):
    """Return a state after a step with constant inputs, as the head of the printout describes."""
    return x - np.expm1(-decay * h) / decay * derivative if decay else x + derivative * h


def test_steps_of_the_printed_states_are_the_recording(late, folder):
    """Lags are exact in any step; the heat, which forces drive, approaches the recording with the step."""
    tire = module_of(folder, "mf61")
    t = np.linspace(0.0, 0.4, 21)
    inputs = {"kappa": np.where(t < 0.2, 0.05, -0.02), "alpha": np.where(t < 0.1, 0.0, 0.1), "V": 10.0 + 5.0 * t}
    course = late.evaluate(pd.DataFrame({"t": t, **inputs, "Fz": 4000.0}), hold=True)
    start = course.assign(tan_alpha_lagged=np.tan(course["alpha_lagged"]))
    errors = []
    for parts in (1, 2):
        x = start[["kappa_lagged", "tan_alpha_lagged", *late.states]].iloc[0].to_dict()
        for i in range(len(t) - 1):
            row = {name: values[i] for name, values in inputs.items()}
            h = (t[i + 1] - t[i]) / parts
            for _ in range(parts):
                rates = tire.states(**row, Fz=4000.0, **x)
                x = {name: after_step(x[name], rates[f"{name}_dot"], rates[f"{name}_decay"], h) for name in x}
        last = course.iloc[-1]
        assert x["kappa_lagged"] == pytest.approx(last["kappa_lagged"], rel=1e-12)
        assert np.arctan(x["tan_alpha_lagged"]) == pytest.approx(last["alpha_lagged"], rel=1e-12)
        assert x["contact_slip_y"] == pytest.approx(last["contact_slip_y"], rel=1e-12)
        errors.append(x["tread_heat"] - last["tread_heat"])
    assert abs(errors[0]) < 0.05 * last["tread_heat"]
    assert abs(errors[1]) < 0.6 * abs(errors[0])
