"""Residual maps: zero for the true tire; shape, sign and size of a missing effect."""

from dataclasses import replace
from math import radians

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tirefmu.boundary.errors import DataError
from tirefmu.diagnosis import ResidualMap, draw_residual_maps, residual_map
from tirefmu.measurements import Noise, Recording, VirtualBench, alpha_sweeps, trento_program
from tirefmu.tires import SIGNS, Tire, published

TIRE = published("trento_hoosier")
BLIND = Tire(TIRE.model, TIRE.values, effects=TIRE.has - {"camber_thrust"}, signs=TIRE.signs)
CAMBERS = [radians(angle) for angle in (-4.0, -2.0, 0.0, 2.0, 4.0)]
PROGRAM = alpha_sweeps([700.0], CAMBERS, sample_rate=50.0)
TRUTH = VirtualBench(TIRE, Noise.none()).run(PROGRAM)


@pytest.mark.parametrize("channel", ["Fx", "Fy", "Mz"])
def test_the_true_tire_has_no_residual(channel):
    recording = VirtualBench(TIRE, Noise.none()).run(trento_program())
    for over in (("alpha", "gamma"), ("kappa", "Fz"), ("t", "p")):
        flat = residual_map(TIRE, recording, channel, over)
        assert flat.largest_mean <= 1e-9
        assert flat.total_rms <= 1e-9
        assert flat.counts.sum() == len(recording)


def test_a_stepped_channel_has_a_bin_for_each_level():
    found = residual_map(TIRE, TRUTH, "Fy", bins=7)
    assert found.counts.shape == (7, 5)
    assert found.steps[1] == pytest.approx(CAMBERS)
    assert len(found.steps[0]) == 0
    assert (found.counts.sum(axis=0) == len(TRUTH) // 5).all()


def test_the_residual_of_missing_camber_thrust():
    """The residual equals the effect: zero without camber, odd in camber, as large as the vertical shift."""
    found = residual_map(BLIND, TRUTH, "Fy")
    seen, known = (tire.evaluate(TRUTH.table, signs=TRUTH.signs)["Fy"] for tire in (TIRE, BLIND))
    effect = (seen - known).to_numpy()
    by_camber = found.mean.mean(axis=0)
    assert np.abs(found.mean[:, 2]).max() <= 1e-9
    assert np.sign(by_camber[:2]).tolist() == (-np.sign(by_camber[:-3:-1])).tolist()
    assert by_camber[0] == pytest.approx(-by_camber[4], rel=0.01)
    assert by_camber[1] == pytest.approx(-by_camber[3], rel=0.01)
    assert by_camber[4] == pytest.approx(2.0 * by_camber[3], rel=0.05)
    assert np.abs(effect).max() * 0.9 <= found.largest_mean <= np.abs(effect).max()
    assert abs(found.worst.at["gamma"]) == pytest.approx(radians(4.0))


def test_with_noise_the_effect_is_significant():
    recording = VirtualBench(TIRE, replace_offsets(Noise()), seed=3).run(PROGRAM)
    flat, missing = (residual_map(tire, recording, "Fy") for tire in (TIRE, BLIND))
    assert missing.largest_mean > 3.0 * flat.largest_mean
    significant = np.abs(missing.mean) > 4.0 * missing.standard_error
    assert significant[:, [0, 4]].all()


def replace_offsets(noise):
    """Return the noise without offsets and drift, which are confounded with effects in a map."""
    still = {name: replace(one, offset=0.0, drift=0.0) for name, one in noise.channels.items()}
    return replace(noise, channels=still)


@given(st.integers(1, 40), st.sampled_from(["alpha", "gamma", "Fz", "kappa", "t", "p"]))
def test_every_row_is_counted_and_the_means_add_up(number, second):
    over = ("Fy", second)  # a measured output may be an axis as well
    found = residual_map(BLIND, TRUTH, "Fy", over, bins=number)
    residual = TRUTH.table["Fy"] - BLIND.evaluate(TRUTH.table, signs=TRUTH.signs)["Fy"]
    assert found.counts.sum() == len(TRUTH)
    assert np.nansum(found.mean * found.counts) == pytest.approx(residual.sum(), rel=1e-9)
    assert found.total_rms == pytest.approx(np.sqrt((residual**2).mean()), rel=1e-9)
    assert (np.isnan(found.mean) == (found.counts == 0)).all()
    some = found.counts > 0
    assert (found.rms[some] >= np.abs(found.mean[some]) * (1.0 - 1e-9)).all()


@pytest.mark.parametrize("signs", SIGNS)
def test_another_sign_convention_mirrors_the_map(signs):
    native = residual_map(BLIND, TRUTH, "Fy", ("t", "gamma"))
    other = residual_map(BLIND, TRUTH.with_signs(signs), "Fy", ("t", "gamma"))
    turn = -1.0 if (signs == "iso") != (TRUTH.signs == "iso") else 1.0
    assert (other.counts == native.counts).all()
    assert other.mean == pytest.approx(turn * native.mean, nan_ok=True)


def test_rows_outside_given_edges_are_excluded():
    edges = {"alpha": np.radians([-2.0, 0.0, 2.0]), "gamma": [radians(1.0), radians(5.0)]}
    found = residual_map(BLIND, TRUTH, "Fy", bins=edges)
    table = TRUTH.table
    inside = (table["alpha"].abs() <= radians(2.0)) & (table["gamma"] >= radians(1.0))
    assert found.counts.shape == (2, 1)
    assert found.counts.sum() == inside.sum()


def test_the_worst_bin_is_not_one_of_a_handful_of_rows():
    mean, counts = np.array([[9.0, -2.0], [np.nan, 1.0]]), np.array([[3, 50], [0, 80]])
    edges = (np.array([0.0, 1.0, 2.0]), np.array([0.0, 0.5, 1.0]))
    empty = (np.empty(0), np.empty(0))
    found = ResidualMap("Fy", "iso", ("alpha", "gamma"), edges, empty, mean, np.abs(mean), mean / 10.0, counts)
    assert (found.worst.mean, found.worst.count, found.largest_mean) == (-2.0, 50, 2.0)
    assert found.worst.at == {"alpha": 0.5, "gamma": 0.75}


def test_rows_without_measurement_are_excluded():
    table = TRUTH.table.copy()
    table.loc[table.index[:100], "Fy"] = np.nan
    assert residual_map(TIRE, replace(TRUTH, table=table), "Fy").counts.sum() == len(TRUTH) - 100


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"channel": "Mx"}, "does not compute 'Mx': .* Known are Fx, Fy, Mz"),
        ({"over": ("alpha", "gama")}, "no column 'gama' for the residual map: did you mean gamma"),
        ({"over": ("alpha", "alpha")}, "two different channels"),
        ({"bins": 0}, "0 bins for alpha"),
        ({"bins": {"alpha": [0.1, 0.0]}}, "edges for alpha must be at least two ascending numbers"),
        ({"bins": {"alpha": [1.0, 1.1]}}, "no row is within the bins"),
    ],
)
def test_invalid_arguments(arguments, message):
    with pytest.raises(DataError, match=message):
        residual_map(TIRE, TRUTH, **{"channel": "Fy", **arguments})


def test_nothing_measured():
    table = TRUTH.table.assign(Fy=np.nan)
    with pytest.raises(DataError, match="no row contains Fy, alpha and gamma"):
        residual_map(TIRE, Recording(table, TRUTH.signs, "a.csv"), "Fy")


def test_figures_are_written_completely_or_not_at_all(tmp_path):
    two = [(name, residual_map(tire, TRUTH, "Fy")) for name, tire in (("without", BLIND), ("with", TIRE))]
    path = draw_residual_maps(two, tmp_path / "map.png")
    assert path.read_bytes().endswith(b"IEND\xaeB`\x82")
    with pytest.raises(DataError, match="one channel and one sign convention"):
        draw_residual_maps([*two, ("Mz", residual_map(TIRE, TRUTH, "Mz"))], tmp_path / "other.png")
    with pytest.raises(DataError, match="one channel and one sign convention"):
        draw_residual_maps([], tmp_path / "other.png")
    with pytest.raises(DataError, match="cannot be written"):
        draw_residual_maps(two, tmp_path / "absent" / "map.png")
    assert [file.name for file in tmp_path.iterdir()] == ["map.png"]


def test_a_map_with_empty_cells_and_without_numbers_is_drawn(tmp_path):
    fine = residual_map(BLIND, TRUTH, "Fy", ("Fy", "alpha"), bins=40)
    assert (fine.counts == 0).any()
    assert draw_residual_maps([("fine", fine)], tmp_path / "fine.png").exists()
