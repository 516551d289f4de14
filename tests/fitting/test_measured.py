"""A fit of measured recordings, which are not part of the project.

Quick tests have each of its laws on recordings of known tires: recovery, constraints, slope targets, signs.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from scipy.ndimage import uniform_filter1d

from tirefmu.fitting import fit
from tirefmu.fitting.constraints import chosen_constraints
from tirefmu.fitting.reporting import significant_differences, stiffness_by_load
from tirefmu.measurements import read_recording
from tirefmu.tires.code import fastest_code

pytestmark = pytest.mark.slow

FILES = ("cornering.mat", "drivebrake.mat")
#: Upper limits of the root mean square error of one MF6.1 tire over all rows.
MAX_RMSE = {
    ("cornering.mat", "Fy"): 68.0, ("cornering.mat", "Mz"): 4.9, ("drivebrake.mat", "Fx"): 109.0,
    ("drivebrake.mat", "Fy"): 73.0, ("drivebrake.mat", "Mz"): 33.0,
}  # fmt: skip


def every_eighth(recordings):
    return [replace(each, table=each.table.iloc[::8].reset_index(drop=True)) for each in recordings]


@pytest.fixture(scope="module")
def recordings(data_folder):
    return [read_recording(data_folder / name) for name in FILES]


@pytest.fixture(scope="module")
def measured(recordings):
    """Return the fit of both together from generic values."""
    return fit(recordings, "mf61")


def computed(tire, recording):
    return tire.evaluate(recording.table, signs=recording.signs, code="batch")


@pytest.mark.parametrize(("recording", "channel"), MAX_RMSE)
def test_one_tire_fits_every_channel(measured, recordings, recording, channel):
    channel_fit = measured.channel(recording, channel)
    assert channel_fit.rmse <= MAX_RMSE[recording, channel]
    assert channel_fit.rows in [len(each.table) for each in recordings]  # all of them
    assert channel_fit.noise_floor < channel_fit.rmse
    assert 100 < channel_fit.effective_rows < 0.1 * channel_fit.rows


def test_the_aligning_moment_of_drive_and_brake_is_fitted_except_for_ripple(measured, recordings):
    recording = recordings[1]
    residual = computed(measured.tire, recording)["Mz"].to_numpy() - recording.table["Mz"].to_numpy()
    smooth = [uniform_filter1d(residual[rows], 25, mode="nearest") for rows in recording.segments()]
    assert np.sqrt(np.mean(np.concatenate(smooth) ** 2)) <= 16.0


def cubic_errors(tire, recording):
    """Return the relative error of K_yalpha by load: the mean of unweighted cubics within 2 deg of each segment."""
    slopes = []
    table = recording.table.assign(computed=computed(tire, recording)["Fy"])
    for rows in recording.segments():
        own = table.iloc[rows]
        near = own[np.abs(own["alpha"]) < np.radians(2.0)]
        if np.ptp(own["alpha"]) > 0.2:
            pair = (np.polyfit(near["alpha"], near[name], 3)[2] for name in ("Fy", "computed"))
            slopes.append((round(float(np.abs(own["Fz"]).median()) / 550), *pair))
    mean = pd.DataFrame(slopes, columns=["load", "measured", "computed"]).groupby("load").mean()
    return dict(mean["computed"] / mean["measured"] - 1.0)


@pytest.fixture(scope="module")
def cornering_errors(measured, recordings):
    """Return the relative error of K_yalpha by reading and load, in multiples of 550 N."""
    found = [entry for entry in stiffness_by_load(measured.findings) if entry[0] == FILES[0]]
    slope = {round(load / 550): mean.fitted / mean.read - 1.0 for *_, load, mean in found}
    return {"slope": slope, "cubic": cubic_errors(measured.tire, recordings[0])}


@pytest.mark.parametrize(("reading", "limit"), [("slope", 0.045), ("cubic", 0.055)])
def test_cornering_stiffness_is_that_of_the_sweeps(cornering_errors, reading, limit):
    """8 % at every load is required; from 1,100 N the limits are those of the present version, not the required 3 %."""
    errors = cornering_errors[reading]
    assert set(errors) == {1, 2, 3, 4, 5}
    assert abs(errors[1]) <= 0.08
    assert max(abs(errors[load]) for load in (2, 3, 4, 5)) <= limit


@pytest.mark.xfail(
    strict=True,
    reason="8 % at every load and 3 % from 1,100 N are not reached together: K_yalpha of the formula is proportional "
    "to the load at low loads, the measured one is not (docs/stiffness.md)",
)
@pytest.mark.parametrize("reading", ["slope", "cubic"])
def test_cornering_stiffness_is_within_3_percent_from_1100_newtons(cornering_errors, reading):
    """The default has +3.7 % (slope) and +5.2 % (cubic) at 1,100 N. Without stiffness targets 3 % holds, not 8 %."""
    assert max(abs(cornering_errors[reading][load]) for load in (2, 3, 4, 5)) <= 0.03


def test_longitudinal_slip_stiffness_is_that_of_the_sweeps(measured):
    means = [entry[-1] for entry in stiffness_by_load(measured.findings) if entry[0] == FILES[1]]
    errors = [mean.fitted / mean.read - 1.0 for mean in means]
    assert len(errors) == 4
    assert max(map(abs, errors)) <= 0.10


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
    code = fastest_code(tire.symbolic_model)
    quantities = code.quantities(inputs, tire.parameters())
    return {name: q.max() for name, q in zip(code.quantities_names, quantities, strict=True) if name.startswith("E_")}


@pytest.mark.parametrize("model", ["mf61", "mf52", "mf96"])
def test_no_curvature_factor_exceeds_1_anywhere_in_the_range(measured, recordings, model):
    """An independent scan. MF6.2 has the lines of E of MF6.1; the other models are fitted to every eighth row."""
    result = measured if model == "mf61" else fit(every_eighth(recordings), model)
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
