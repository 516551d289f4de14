"""Turn slip from the rate of the slip angle: the yaw rate of the wheel kinematics over the speed."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from tirefmu.boundary.errors import DataError
from tirefmu.measurements import Recording, with_turn_slip
from tirefmu.tires.hub import wheel_motion


def bench(n=401):
    """Return a recording of a wheel whose plane turns while the carrier moves straight ahead, and the yaw rate."""
    t = np.linspace(0.0, 4.0, n)
    yaw, rate, speed = 0.1 * np.sin(2.0 * t), 0.2 * np.cos(2.0 * t), 12.0 + t
    cos, sin = np.cos(yaw), np.sin(yaw)
    motion = wheel_motion(r_z=0.3, R_11=cos, R_12=-sin, R_21=sin, R_22=cos, v_x=speed, w_z=rate)
    table = pd.DataFrame({"t": t, "alpha": np.arctan2(motion["V_y"], motion["V_x"]), "V": speed, "Fy": 0.0})
    return Recording(table, "iso", "bench"), motion["psi_dot"]


@pytest.mark.parametrize("signs", ["iso", "adapted-sae", "sae"])
def test_it_is_the_yaw_rate_over_the_speed(signs):
    recording, yaw_rate = bench()
    found = with_turn_slip(recording.with_signs(signs)).with_signs("iso").table
    np.testing.assert_allclose(found["phit"][5:-5], (yaw_rate / found["V"])[5:-5], atol=2e-5)


def test_a_gap_a_new_recording_and_standstill_turn_nothing():
    recording, _ = bench(101)
    table = pd.concat([recording.table, recording.table.iloc[60:].assign(t=lambda one: one["t"] + 30.0)])
    table = pd.concat([table, recording.table], ignore_index=True)
    table.loc[table.index[-20:], "V"] = 0.0
    phit = with_turn_slip(Recording(table, "iso", "bench")).table["phit"]
    assert phit.abs().max() < 1.05 * 0.2 / 12.0
    assert (phit.iloc[-20:] == 0.0).all()


def test_noise_of_the_slip_angle_is_smoothed():
    recording, yaw_rate = bench(2001)
    noisy = recording.table["alpha"] + 2e-4 * np.random.default_rng(2).standard_normal(2001)
    found = with_turn_slip(Recording(recording.table.assign(alpha=noisy), "iso", "bench")).table
    raw = np.gradient(noisy, found["t"]) / found["V"]
    error, plain = found["phit"] - yaw_rate / found["V"], raw + yaw_rate / found["V"]
    assert error.std() < 0.35 * plain.std()


def test_a_recorded_turn_slip_is_unchanged_and_a_missing_column_is_named():
    recording, _ = bench(20)
    recorded = Recording(recording.table.assign(phit=0.5), "iso", "bench")
    assert with_turn_slip(recorded) is recorded
    with pytest.raises(DataError, match="bench: turn slip from the rate of the slip angle: column V is missing"):
        with_turn_slip(Recording(recording.table.drop(columns="V"), "iso", "bench"))
