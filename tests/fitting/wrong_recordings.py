"""Recordings with an error that no table shows: late channels, two tires, drift, clipped forces, few rows.

Each one is made from a recording of the virtual bench with a known tire. `test_wrong_recordings.py` fits them:
none may give a good tire, and the noise floor may not contain the error.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import radians

import numpy as np
import pandas as pd

from tirefmu.measurements import Recording, VirtualBench, alpha_sweeps, concatenate, kappa_sweeps
from tirefmu.tires import Tire, published

#: Loads, N, of the program, and the delays of the wrong recordings, s.
LOADS = (220.0, 440.0, 700.0, 900.0, 1120.0)
DELAY, LOW_PASS = 0.4, 3.0
SAMPLE_RATE = 20.0


def right(seed: int = 1, tire: Tire | None = None) -> Recording:
    """Return the recording without the error: sweeps of both slips at five loads and three camber angles."""
    cambers = [radians(angle) for angle in (0, 2, 4)]
    lateral = alpha_sweeps(LOADS, cambers, sample_rate=SAMPLE_RATE)
    driven = kappa_sweeps(LOADS, [radians(angle) for angle in (0, 3, 6)], cambers[::2], sample_rate=SAMPLE_RATE)
    program = concatenate([lateral, driven], signs="iso")
    return VirtualBench(tire or published("trento_hoosier"), seed=seed).run(program)


def _changed(recording: Recording, **columns: object) -> Recording:
    return replace(recording, table=recording.table.assign(**columns))


def _late(recording: Recording, *names: str) -> Recording:
    table = recording.table
    return _changed(recording, **{n: np.interp(table["t"] - DELAY, table["t"], table[n]) for n in names})


def _low_passed(recording: Recording, name: str) -> Recording:
    t, values = (recording.table[n].to_numpy(dtype=float) for n in ("t", name))
    filtered = values.copy()
    for row, decay in enumerate(np.exp(-np.diff(t) / LOW_PASS), 1):
        filtered[row] = decay * filtered[row - 1] + (1.0 - decay) * values[row]
    return _changed(recording, **{name: filtered})


def _interleaved(recording: Recording) -> Recording:
    tire = published("trento_hoosier")
    other = right(1, tire.with_values(PDY1=1.3 * tire.values["PDY1"], PDX1=0.8 * tire.values["PDX1"]))
    rows = np.arange(len(recording)) % 2 == 1
    both = np.where(rows[:, None], other.table, recording.table)
    return replace(recording, table=pd.DataFrame(both, columns=recording.table.columns))


def _drifting(recording: Recording) -> Recording:
    share = np.linspace(1.0, 0.75, len(recording))
    return _changed(recording, **{name: share * recording.table[name] for name in ("Fx", "Fy", "Mz")})


def _clipped(recording: Recording) -> Recording:
    limit = 0.68 * float(recording.table["Fy"].abs().quantile(0.999))
    return _changed(recording, Fy=recording.table["Fy"].clip(-limit, limit))


def _bump(recording: Recording) -> Recording:
    factor = np.where((recording.table["Fz"] - LOADS[2]).abs() < 80.0, 1.15, 1.0)
    return _changed(recording, **{name: factor * recording.table[name] for name in ("Fx", "Fy")})


def _few(recording: Recording) -> Recording:
    rows = np.linspace(0, len(recording) - 1, 60).astype(int)
    return replace(recording, table=recording.table.iloc[rows].reset_index(drop=True))


#: The wrong recordings by name: from the right recording.
WRONG: dict[str, Callable[[Recording], Recording]] = {
    "alpha late": lambda recording: _late(recording, "alpha"),
    "forces late": lambda recording: _late(recording, "Fx", "Fy", "Mz"),
    "Fy low-passed": lambda recording: _low_passed(recording, "Fy"),
    "two tires interleaved": _interleaved,
    "friction drifts": _drifting,
    "Fy clipped": _clipped,
    "Fz rounded to kN": lambda recording: _changed(recording, Fz=(recording.table["Fz"] / 1e3).round() * 1e3),
    "camber is zero": lambda recording: _changed(recording, gamma=0.0),
    "60 rows": _few,
    "friction bump at one load": _bump,
}


def noise_of(recording: Recording) -> dict[str, float]:
    """Return the noise of a right recording by channel: the error of the true tire at the recorded inputs."""
    table = recording.table
    true = published("trento_hoosier").evaluate(table.drop(columns=["Fx", "Fy", "Mz"]), signs=recording.signs)
    return {name: float(np.sqrt(np.mean((table[name] - true[name]) ** 2))) for name in ("Fx", "Fy", "Mz")}
