"""A fit of measured recordings, which are not part of the project."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest
from scipy.ndimage import uniform_filter1d

from tirefmu.fitting import fit
from tirefmu.fitting.constraints.physical import chosen_constraints
from tirefmu.fitting.reporting.report_text import significant_differences
from tirefmu.measurements import read_recording
from tirefmu.tires.code import fastest_code

FILES = ("cornering.mat", "drivebrake.mat")
#: Upper limits of the root mean square error of one MF6.1 tire over all rows.
MOST = {
    ("cornering.mat", "Fy"): 70.0, ("cornering.mat", "Mz"): 5.0, ("drivebrake.mat", "Fx"): 112.0,
    ("drivebrake.mat", "Fy"): 75.0,
}  # fmt: skip


@pytest.fixture(scope="module")
def recordings(data_folder):
    return [read_recording(data_folder / name) for name in FILES]


@pytest.fixture(scope="module")
def measured(recordings):
    """Return the fit of both together from generic values: about 30 s."""
    return fit(recordings, "mf61")


def computed(tire, recording):
    return tire.evaluate(recording.table, signs=recording.signs, code="batch")


@pytest.mark.parametrize(("recording", "channel"), MOST)
def test_one_tire_fits_every_channel(measured, recording, channel):
    channel_fit = measured.channel(recording, channel)
    assert channel_fit.rmse <= MOST[recording, channel]
    assert channel_fit.rows in (59_965, 76_484)  # all of them
    assert channel_fit.noise_floor < channel_fit.rmse
    assert 100 < channel_fit.effective_rows < 0.1 * channel_fit.rows


def test_the_aligning_moment_of_drive_and_brake_is_fitted_except_for_ripple(measured, recordings):
    recording = recordings[1]
    residual = computed(measured.tire, recording)["Mz"].to_numpy() - recording.table["Mz"].to_numpy()
    smooth = [uniform_filter1d(residual[rows], 25, mode="nearest") for rows in recording.segments()]
    assert np.sqrt(np.mean(np.concatenate(smooth) ** 2)) <= 16.0


def test_cornering_stiffness_is_that_of_the_sweeps(measured, recordings):
    """Slope of a cubic within 2 deg of zero slip, averaged over inclination and pressure, for each load."""
    recording, slopes = recordings[0], []
    force = computed(measured.tire, recording)["Fy"]
    for rows in recording.segments():
        table = recording.table.iloc[rows].assign(fitted=force.iloc[rows])
        near = table[np.abs(table["alpha"]) < np.radians(2.0)]
        if np.ptp(table["alpha"]) > 0.2:
            pair = (np.polyfit(near["alpha"], near[name], 3)[2] for name in ("Fy", "fitted"))
            slopes.append((round(float(np.abs(table["Fz"]).median()) / 550), *pair))
    mean = pd.DataFrame(slopes, columns=["load", "measured", "fitted"]).groupby("load").mean()
    assert list(mean.index) == [1, 2, 3, 4, 5]
    ratio = (mean["fitted"] / mean["measured"])[mean.index >= 2]  # 1,100 N and more
    np.testing.assert_allclose(ratio, 1.0, atol=0.03)


def test_every_constraint_is_satisfied_over_the_operating_range(measured):
    assert measured.status == "converged"
    names = [each.name for own in chosen_constraints("mf61").values() for each in own]
    assert [margin.name for margin in measured.margins] == names
    for margin in measured.margins:
        assert margin.margin >= -1e-6, margin


def scanned(tire, recordings):
    """Return the largest value of each curvature factor at 400,000 random points within the range of the data."""
    tables = [recording.with_signs("adapted-sae").table for recording in recordings]
    tire, rng = tire.in_signs("adapted-sae"), np.random.default_rng(5)
    inputs = np.stack(
        [
            rng.uniform(min(t[name].min() for t in present), max(t[name].max() for t in present), 400_000)
            if (present := [t for t in tables if name in t])
            else np.full(400_000, tire.nominal(name))
            for name in tire.inputs
        ]
    )
    code = fastest_code(tire.book)
    quantities = code.quantities(inputs, tire.parameters())
    return {name: q.max() for name, q in zip(code.quantities_names, quantities, strict=True) if name.startswith("E_")}


@pytest.mark.parametrize("model", ["mf61", "mf52", "mf96"])
def test_no_curvature_factor_exceeds_1_anywhere_in_the_range(measured, recordings, model):
    """An independent scan. The lines of E in MF6.2 are those of MF6.1."""
    result = measured if model == "mf61" else fit(recordings, model)
    largest = scanned(result.tire, recordings)
    assert {"E_x", "E_y", "E_t"} <= set(largest)
    for name, value in largest.items():
        assert value <= 1.0 + 1e-6, name
    assert result.status == "converged"


def test_coefficients_that_are_not_identifiable_are_reported(measured):
    channel_fit = {coefficient.name: coefficient for coefficient in measured.coefficients}
    assert any({"PKX2", "PKX3"} <= set(direction.coefficients) for direction in measured.directions)
    assert np.isinf(channel_fit["PKX2"].interval)
    assert channel_fit["PDY1"].interval < 0.1 * channel_fit["PDY1"].value


def test_the_findings_agree_with_the_recordings(measured):
    found = measured.findings
    stiff = {round(each.load / 550): each for each in found.stiffnesses if each.channel == "Fy"}
    assert all(abs(stiff[load].off) < 0.03 for load in (2, 3, 4, 5))
    turning = {each.recording: each for each in found.ripples if each.stands_out}
    assert set(turning) == set(FILES)
    for each in turning.values():
        assert 0.18 < each.radius < 0.25  # a tire of 0.2 m; the radius was not given to the fit
    assert {"Fy", "Mz"} <= {each.channel for each in significant_differences(measured) if each.first in FILES}
    conditions = [each for each in found.conditions if (each.recording, each.channel) == ("cornering.mat", "Fy")]
    assert len(conditions) == 45  # five loads, three inclinations, three pressures


def test_the_tire_and_its_bounds_are_in_iso(measured):
    assert measured.tire.signs == "iso"
    assert measured.signs == "iso"
    coefficients = {coefficient.name: coefficient for coefficient in measured.coefficients}
    assert coefficients["PKY1"].value == measured.tire.values["PKY1"] < 0
    for coefficient in coefficients.values():
        assert coefficient.lower <= coefficient.value <= coefficient.upper, coefficient
