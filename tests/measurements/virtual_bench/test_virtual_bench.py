"""The virtual bench records the truth with exactly the noise that was declared, the same every time."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import degrees, radians

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tirefmu.boundary.errors import DataError, UnknownName
from tirefmu.measurements import (
    ChannelNoise,
    Noise,
    Program,
    VirtualBench,
    alpha_sweeps,
    check_plausible,
    column_notes,
    concatenate,
    correlated,
    kappa_sweeps,
    levels,
    small_tire_program,
    steady_points,
    trento_program,
)
from tirefmu.measurements import TestedTire as AnyTire  # pytest takes a Test... for a class of tests
from tirefmu.tires import SIGNS, convert_signs


@dataclass(frozen=True)
class BrushedTire:
    """A tire of tanh curves with the same physics in every convention."""

    signs: str = "iso"
    inputs: tuple[str, ...] = ("kappa", "alpha", "gamma", "Fz")

    def forces(self, *, kappa, alpha, gamma, Fz) -> Mapping[str, np.ndarray]:
        inputs = pd.DataFrame({"kappa": kappa, "alpha": alpha, "gamma": gamma, "Fz": Fz})
        iso = convert_signs(inputs, self.signs, "iso")
        side = -1.4 * iso["Fz"] * np.tanh(12.0 * (iso["alpha"] + 0.05 * iso["gamma"]))
        outputs = pd.DataFrame({"Fx": 1.5 * iso["Fz"] * np.tanh(15.0 * iso["kappa"]), "Fy": side, "Mz": -0.02 * side})
        turned = convert_signs(outputs, "iso", self.signs)
        return {name: turned[name].to_numpy() for name in turned}


def test_without_noise_the_record_is_the_truth():
    program = trento_program()
    tire: AnyTire = BrushedTire()
    recording = VirtualBench(tire, Noise.none()).run(program)
    pd.testing.assert_frame_equal(recording.table[list(program.table)], program.table)
    forces = tire.forces(**{name: program.table[name].to_numpy() for name in tire.inputs})
    for name in ("Fx", "Fy", "Mz"):
        assert np.array_equal(recording.table[name], forces[name])


@pytest.mark.parametrize("tire_signs", SIGNS)
@pytest.mark.parametrize("signs", SIGNS)
def test_the_same_physics_in_every_convention(tire_signs, signs):
    program = concatenate([alpha_sweeps([900.0]), kappa_sweeps([900.0], [0.05])], signs=signs)
    recording = VirtualBench(BrushedTire(tire_signs), seed=3).run(program)
    reference = VirtualBench(BrushedTire("iso"), seed=3).run(replace(program, signs="iso"))
    assert recording.signs == signs
    pd.testing.assert_frame_equal(recording.with_signs("iso").table, reference.table)
    check_plausible(recording)
    assert column_notes(recording) == []


@pytest.mark.parametrize("signs", SIGNS)
def test_signs_are_the_tires_where_the_program_names_none(signs):
    assert VirtualBench(BrushedTire(signs)).run(alpha_sweeps([900.0])).signs == signs


def test_seeded():
    program = alpha_sweeps([900.0])
    first = VirtualBench(BrushedTire(), seed=1).run(program).table
    pd.testing.assert_frame_equal(first, VirtualBench(BrushedTire(), seed=1).run(program).table)
    other = VirtualBench(BrushedTire(), seed=2).run(program).table
    assert all((first[name] != other[name]).any() for name in first if name != "t")
    assert first["t"].equals(other["t"])


def test_a_new_channel_leaves_the_recording_of_a_seed():
    """The streams of the channels that existed first, by their number then."""
    program = alpha_sweeps([900.0])
    bench = VirtualBench(BrushedTire(), seed=3)
    recording, truth = bench.run(program).table, bench.truth(program)
    for name, stream in {"alpha": 2, "Fz": 4, "Fx": 9, "Fy": 10, "Mz": 11}.items():
        rng = np.random.default_rng([3, stream])
        expected = bench.noise.record(name, truth[name].to_numpy(), truth["t"].to_numpy(), rng)
        assert np.array_equal(recording[name], expected), name


def test_channel_errors_are_independent():
    program = alpha_sweeps([900.0] * 20)
    bench = VirtualBench(BrushedTire(), Noise(correlation_time=0.0))
    errors = (bench.run(program).table - bench.truth(program)).drop(columns=["t", "kappa"])
    correlation = errors.corr().to_numpy() - np.eye(errors.shape[1])
    assert np.abs(correlation).max() < 0.08


@pytest.mark.parametrize("correlation_time", [0.0, 0.01, 0.05])
def test_noise_has_the_declared_size_and_correlation(correlation_time):
    t = np.arange(200_000) / 100.0
    true = np.full(len(t), 1000.0)
    noise = Noise({"Fy": ChannelNoise(constant=3.0, proportional=0.004)}, correlation_time=correlation_time)
    error = noise.record("Fy", true, t, np.random.default_rng(7)) - true
    assert error.std() == pytest.approx(5.0, rel=0.03)
    for lag in (1, 2, 5):
        expected = np.exp(-lag * 0.01 / correlation_time) if correlation_time else 0.0
        assert np.corrcoef(error[:-lag], error[lag:])[0, 1] == pytest.approx(expected, abs=0.03)


def test_noise_is_stationary_and_uncorrelated_across_a_pause():
    t = np.array([0.0, 0.001, 10.0])
    draws = np.array([correlated(t, 0.05, np.random.default_rng(seed)) for seed in range(4000)])
    assert draws.std(axis=0) == pytest.approx([1.0, 1.0, 1.0], rel=0.04)
    assert np.corrcoef(draws[:, 0], draws[:, 1])[0, 1] == pytest.approx(np.exp(-0.02), abs=0.01)
    assert abs(np.corrcoef(draws[:, 1], draws[:, 2])[0, 1]) < 0.05


def test_offset_and_drift_over_many_recordings():
    t = np.linspace(0.0, 900.0, 400)
    noise = Noise({"Mz": ChannelNoise(offset=2.0, drift=0.5)}, drift_period=900.0)
    errors = np.array([noise.record("Mz", 0.0 * t, t, np.random.default_rng(seed)) for seed in range(3000)])
    assert errors.mean(axis=1).std() == pytest.approx(2.0, rel=0.05)  # the mean of a sweep is zero over its period
    swings = errors - errors.mean(axis=1, keepdims=True)
    assert np.sqrt((swings**2).mean()) == pytest.approx(0.5, rel=0.05)


@given(step=st.sampled_from([0.05, 0.5, 25.0]), seed=st.integers(0, 50))
def test_record_is_quantized(step, seed):
    true = np.random.default_rng(seed).uniform(-1e3, 1e3, 50)
    noise = Noise({"Fy": ChannelNoise(step=step)})
    recorded = noise.record("Fy", true, np.arange(50.0), np.random.default_rng(0))
    assert np.abs(recorded - true).max() <= step / 2 * (1 + 1e-9)
    assert recorded / step == pytest.approx(np.round(recorded / step), abs=1e-6)


def test_scaled_noise_does_not_change_the_slips():
    scaled = Noise().scaled(0.05)
    assert scaled.channels["alpha"] == Noise().channels["alpha"]
    assert scaled.channels["Mz"].constant == pytest.approx(0.05 * Noise().channels["Mz"].constant)
    assert scaled.channels["Fz"].proportional == Noise().channels["Fz"].proportional


def test_bad_noise_and_tires():
    with pytest.raises(UnknownName, match="unknown channel 'Fq'"):
        Noise({"Fq": ChannelNoise()})
    with pytest.raises(DataError, match="drift is -1"):
        ChannelNoise(drift=-1.0)
    with pytest.raises(DataError, match="correlation_time"):
        Noise(correlation_time=-1.0)

    @dataclass(frozen=True)
    class Silent(BrushedTire):
        def forces(self, **inputs) -> Mapping[str, np.ndarray]:
            return {"trail": inputs["Fz"]}

    with pytest.raises(DataError, match="has none of the outputs Fx"):
        VirtualBench(Silent()).run(alpha_sweeps([900.0]))


def test_trento_program_is_the_reports_and_its_levels_are_found_in_noise():
    table = VirtualBench(BrushedTire()).run(trento_program()).table
    assert levels(table["Fz"]) == pytest.approx([220, 440, 700, 900, 1120], rel=0.03)
    assert np.degrees(levels(table["gamma"], tolerance=radians(0.2))) == pytest.approx([0, 1, 2, 3, 4], abs=0.1)
    braking = table[table["kappa"].abs() > 0.05]
    assert np.degrees(levels(braking["alpha"])) == pytest.approx([0, 3, 6], abs=0.1)
    table = trento_program().table
    lateral, drive_brake = table[table["kappa"] == 0.0], table[table["kappa"] != 0.0]
    assert np.degrees(lateral["alpha"].agg(["min", "max"])).tolist() == pytest.approx([-12.0, 12.0])
    assert drive_brake["kappa"].agg(["min", "max"]).tolist() == pytest.approx([-0.3, 0.3])
    assert set(drive_brake["Fz"]) == {220.0, 700.0, 900.0, 1120.0}
    assert {round(degrees(angle)) for angle in set(drive_brake["gamma"])} == {0, 2, 4}


def test_small_tire_program_is_unicamps():
    table = small_tire_program().table
    assert len(table) == 297
    assert len(table.drop(columns="t").drop_duplicates()) == 297
    assert [table[name].nunique() for name in ("alpha", "Fz", "kappa", "gamma")] == [9, 3, 11, 1]
    assert (table["kappa"].min(), table["kappa"].max()) == (-0.5, 1.0)
    assert set(np.round(np.degrees(table["alpha"]))) == set(range(-20, 21, 5))
    bench = VirtualBench(BrushedTire(), Noise().scaled(0.05))
    check_plausible(bench.run(small_tire_program()))


@given(rate=st.floats(1.0, 20.0), amplitude=st.floats(2.0, 20.0), sample_rate=st.sampled_from([50.0, 100.0]))
def test_sweeps_have_their_rate_and_amplitude(rate, amplitude, sample_rate):
    program = alpha_sweeps([500.0], amplitude=radians(amplitude), rate=radians(rate), sample_rate=sample_rate)
    t, alpha = program.table["t"].to_numpy(), np.degrees(program.table["alpha"].to_numpy())
    assert np.diff(t) == pytest.approx(1.0 / sample_rate)
    assert np.abs(np.diff(alpha)).max() <= rate / sample_rate * (1 + 1e-6)
    assert np.abs(alpha).max() <= amplitude * (1 + 1e-9)
    assert max(amplitude - alpha.max(), amplitude + alpha.min()) <= rate / sample_rate
    assert t[-1] == pytest.approx(4.0 * amplitude / rate, abs=1.0 / sample_rate)
    # The sweep is antisymmetric: as much time at alpha as at -alpha.
    assert alpha.mean() == pytest.approx(0.0, abs=2.0 * amplitude / len(t))


def test_joined_programs_have_every_row_in_order_and_a_segment_for_each_sweep():
    first, second = alpha_sweeps([300.0, 600.0], [0.0, 0.05]), kappa_sweeps([300.0])
    both = concatenate([first, second])
    assert both.table["Fz"].tolist() == first.table["Fz"].tolist() + second.table["Fz"].tolist()
    assert (np.diff(both.table["t"]) > 0).all()
    assert len(VirtualBench(BrushedTire()).run(both).segments()) == 5


@pytest.mark.parametrize(
    ("make", "error", "expected"),
    [
        (lambda: concatenate([alpha_sweeps([300.0]), steady_points([0.0], [0.0], [60.0])]), DataError, "p is not in"),
        (lambda: concatenate([]), DataError, "no programs"),
        (lambda: alpha_sweeps([]), DataError, "no loads"),
        (lambda: steady_points([], [0.0], [60.0]), DataError, "no rows"),
        (lambda: kappa_sweeps([300.0], lowest=0.1), DataError, "a sweep needs"),
        (lambda: Program("x", pd.DataFrame({"t": [0.0], "Fy": [1.0]})), DataError, "'Fy' is not an input"),
        (lambda: Program("x", pd.DataFrame({"t": [0.0, 0.0]})), DataError, "t is not ascending"),
        (lambda: Program("x", pd.DataFrame({"t": [0.0], "Fz": [np.nan]})), DataError, "NaN or infinite"),
        (lambda: trento_program(signs="din"), UnknownName, "sign convention"),
    ],
)
def test_bad_programs(make, error, expected):
    with pytest.raises(error, match=expected):
        make()
