"""A raw run as a bench logs it, with all transitions, and with the known phase of each row."""

from __future__ import annotations

from dataclasses import dataclass
from math import radians

import numpy as np
import pandas as pd
import pytest

from tirefmu.measurements import Recording
from tirefmu.measurements.files import native_reader

RATE = 100.0  # rows per second
RAMP = 1.0  # s from one condition to the next
SWEEP = 12.0  # s of 0, +12, -12, 0 deg at 4 deg/s


@dataclass(frozen=True, eq=False)
class RawRun:
    """A recording, and for each row whether it is in a transition to another operating condition."""

    recording: Recording
    between: np.ndarray


def raw_run(loads=(250.0, 700.0, 1100.0, 1550.0), cambers=(0.0, 2.0, 4.0), *, seed=0, first=60.0, noisy=True):
    """Return sweeps at every camber and load without pauses. The tread starts at ``first`` deg C."""
    sweep = np.interp(np.arange(int(SWEEP * RATE)) / RATE, [0.0, 3.0, 9.0, 12.0], [0.0, 12.0, -12.0, 0.0])
    still = np.zeros(int(RAMP * RATE))
    conditions = [(load, camber) for camber in cambers for load in loads]
    alpha, load, camber, between = [], [], [], []
    last = conditions[0]
    for condition in conditions:
        ramp = np.arange(len(still)) / len(still)
        alpha += [still, sweep]
        load += [last[0] + ramp * (condition[0] - last[0]), np.full(len(sweep), condition[0])]
        camber += [last[1] + ramp * (condition[1] - last[1]), np.full(len(sweep), condition[1])]
        between += [np.full(len(still), condition != last), np.zeros(len(sweep), dtype=bool)]
        last = condition
    rng = np.random.default_rng(seed)
    rows = sum(map(len, alpha))
    noise = lambda deviation: rng.normal(0.0, deviation, rows) if noisy else np.zeros(rows)  # noqa: E731
    time = np.arange(rows) / RATE
    angle = np.radians(np.concatenate(alpha))
    force = np.concatenate(load)
    table = pd.DataFrame(
        {
            "t": time,
            "alpha": angle + noise(radians(0.015)),
            "gamma": np.radians(np.concatenate(camber)) + noise(radians(0.008)),
            "Fz": force * (1.0 + noise(0.02)),
            "p": 83e3 + noise(300.0),
            "V": 11.2 + noise(0.01),
            "T": 60.0 - (60.0 - first) * np.exp(-time / 15.0) + noise(0.1),
            "Fy": -1.4 * force * np.tanh(12.0 * angle) + noise(12.0),
            "Mz": 0.02 * force * np.sin(12.0 * angle) * np.exp(-np.abs(12.0 * angle)) + noise(1.0),
        }
    )
    return RawRun(Recording(table, "iso", "raw.csv"), np.concatenate(between))


@pytest.fixture(scope="session")
def raw() -> RawRun:
    return raw_run()


@pytest.fixture(scope="session")
def make_raw():
    return raw_run


@pytest.fixture
def without_package(tmp_path_factory, monkeypatch):
    """Return a function that hides packages from the process that reads files."""

    def hide(*names):
        folder = tmp_path_factory.mktemp("missing")
        for name in names:
            (folder / f"{name}.py").write_text("raise ImportError\n", encoding="utf-8")
        monkeypatch.setenv("PYTHONPATH", str(folder))
        native_reader.close()

    yield hide
    native_reader.close()
