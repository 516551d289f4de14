"""A planned program: within the limits of the bench, better with more time, with intervals that a fit has."""

from __future__ import annotations

import json
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pandas as pd
import pytest

from tests.json_schemas import check_file, objections
from tirefmu import plan
from tirefmu.applications.planning import (
    Bench,
    Heat,
    Limits,
    PlanError,
    change_time,
    example_text,
    program_from,
    read_bench,
)
from tirefmu.boundary.errors import UnknownName
from tirefmu.commands.cli import main
from tirefmu.commands.demo import bench_tire
from tirefmu.measurements import Noise, VirtualBench, alpha_sweeps, recording_from
from tirefmu.tires import published

LOADS = Limits(220.0, 1120.0, 4.0, levels=3)
ALPHA = Limits(-0.2, 0.2, 3.0, rate=0.14)
LATERAL = Bench({"Fz": LOADS, "alpha": ALPHA}, Noise(), sample_rate=25.0, warm_up=20.0, repeat_every=60.0)


@pytest.fixture(scope="module")
def result():
    today = recording_from(alpha_sweeps([220.0, 1120.0], sample_rate=25.0).table)
    return plan("trento_hoosier", LATERAL, aims=["stiffness", "friction"], minutes=3.0, today=today)


def test_program_respects_the_limits_of_the_bench(result):
    rows, steps = result.program.rows, result.program.steps
    assert 0.8 * 180.0 < result.program.seconds <= 180.0 + 1e-9
    assert steps[0].start == LATERAL.warm_up
    assert (np.diff(rows["t"]) > 0.0).all()
    for name, limits in LATERAL.limits.items():
        assert limits.low - 1e-12 <= rows[name].min()
        assert rows[name].max() <= limits.high + 1e-12
    inside = np.diff(rows["t"]) < 1.5 / LATERAL.sample_rate
    assert np.abs(np.diff(rows["alpha"]) / np.diff(rows["t"]))[inside].max() <= ALPHA.rate * (1.0 + 1e-9)
    for before, after in pairwise(steps):
        gap = after.start - before.start - before.maneuver.duration
        assert gap >= change_time(before.maneuver, after.maneuver, LATERAL) - 1e-6
    assert [step.reason for step in steps].count("repeat") >= 2
    sides = {np.sign(step.maneuver.values[1]) for step in steps}
    assert sides == {1.0, -1.0}


def test_intervals_shrink_with_time_and_beat_two_sweeps(result):
    widths = [at["intervals"] for at in result.prediction.over_time()]
    for name in ("stiffness_y", "friction_y"):
        series = [width[name] for width in widths]
        assert series[-1] < series[0]
        assert result.prediction.widths[name] < result.today.widths[name]


def test_combined_slip_is_named_as_missing(result):
    assert any("combined slip" in reason or "kappa" in reason for reason in result.undetermined.values())


@pytest.mark.slow
def test_predicted_intervals_are_those_of_simulated_estimates():
    """The truth is a linear estimate in plain NumPy, with finite differences, over noisy recordings.

    The coefficients differ from those of the plan by their prior. The inclination has no offset: its influence on
    this tire is not linear.
    """
    tire, noise = replace(bench_tire(), name=""), Noise()
    level = replace(noise, channels={**noise.channels, "gamma": replace(noise.channels["gamma"], offset=0.0)})
    bench = replace(LATERAL, noise=level)
    planned = plan(tire, bench, aims=["PKY1", "PDY1"], minutes=4.0)
    experiment, program = planned.prediction.experiment, planned.program.virtual
    names, sizes = experiment.free, experiment.sizes
    exact = VirtualBench(tire, Noise.none()).run(program).with_signs("adapted-sae").table
    inputs = {name: exact[name].to_numpy() for name in tire.inputs}

    def residual(values, given):
        forces = replace(tire, values={**tire.values, **values}).forces(**given)
        return np.array([forces[channel] for channel in ("Fx", "Fy", "Mz")])

    base = residual({}, inputs)
    steps = [1e-5 * size for size in sizes]
    moved = [residual({n: tire.values[n] + h}, inputs) for n, h in zip(names, steps, strict=True)]
    jacobian = np.array([(m - base) / 1e-5 for m in moved])
    deviation = {"Fx": [], "Fy": [], "Mz": []}
    noises = []
    for seed in range(120):
        table = VirtualBench(tire, bench.noise, seed=seed).run(program).with_signs("adapted-sae").table
        computed = residual({}, {name: table[name].to_numpy() for name in tire.inputs})
        difference = np.array([table[c].to_numpy() - f for c, f in zip(deviation, computed, strict=True)])
        noises.append(difference)
    weights = 1.0 / np.sqrt(np.mean(np.square(noises), axis=(0, 2)))
    rows = (jacobian * weights[:, None]).reshape(len(names), -1)
    gain = np.linalg.solve(rows @ rows.T + np.eye(len(names)), rows)
    shrinkage, random = gain @ rows.T - np.eye(len(names)), np.random.default_rng(0)
    estimates = np.array([
        gain @ (noise * weights[:, None]).ravel() + shrinkage @ random.standard_normal(len(names)) for noise in noises
    ])  # fmt: skip
    for name in ("PKY1", "PDY1"):
        achieved = np.sqrt(np.mean(estimates[:, names.index(name)] ** 2))
        target = next(prediction for prediction in planned.prediction.targets if prediction.name == name)
        predicted = np.sqrt(np.sum(target.squares[0] * planned.prediction.covariances[0]))
        assert predicted == pytest.approx(achieved, rel=0.2)  # the error of 120 estimates is 6 %, three times that


def test_family_has_no_random_tires():
    tires = [published("trento_hoosier"), published("trento_hoosier").with_values(PDY1=2.5)]
    planned = plan(tires, LATERAL, aims=["friction"], minutes=2.0)
    assert len(planned.prediction.experiment.tires) == 2


@pytest.mark.parametrize(
    ("limits", "aims", "message"),
    [
        ({"Fz": LOADS, "alpha": Limits(-0.01, 0.01, 2.0, rate=0.1)}, ["friction"], "determines friction_y.*alpha"),
        ({"Fz": LOADS, "alpha": ALPHA}, ["PCX1"], "determines PCX1"),
    ],
)
def test_impossible_aims_are_named(limits, aims, message):
    with pytest.raises(PlanError, match=message):
        plan("trento_hoosier", Bench(limits, Noise()), aims=aims, minutes=2.0)


def test_unknown_aim_and_too_little_time():
    with pytest.raises(UnknownName, match="did you mean friction"):
        plan("trento_hoosier", LATERAL, aims=["frict"], minutes=2.0)
    with pytest.raises(PlanError, match="too short"):
        plan("trento_hoosier", LATERAL, aims=["friction"], minutes=0.2)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('low = "-12 deg"', 'low = "-12 kPa"', "measures pressure, not angle"),
        ('high = "12 deg"', 'high = "-20 deg"', "low is above high"),
        ("sample_rate = 50.0", "sample_rate = -1.0", "sample_rate is -1.0: expected a number above 0"),
        ("levels = 4", "levles = 4", "did you mean levels"),
        ("low = 220.0", "low = 0.0", "low has to be positive"),
    ],
)
def test_errors_of_a_bench_file_name_the_key(tmp_path, old, new, message):
    path = tmp_path / "bench.toml"
    path.write_text(example_text().replace(old, new, 1))
    with pytest.raises((PlanError, UnknownName), match=message):
        read_bench(path)


def test_a_compared_program_follows_the_schema(result):
    assert result.to_json()["compared"]["name"]
    assert objections("plan", result.to_json()) == []


@pytest.mark.slow
def test_command_writes_a_program_that_the_virtual_bench_runs(tmp_path, capsys):
    assert main(["plan", "--example"]) == 0
    bench, folder = tmp_path / "bench.toml", tmp_path / "program"
    bench.write_text(capsys.readouterr().out)
    options = ["--bench", str(bench), "--for", "stiffness", "--minutes", "3", "-o", str(folder), "--quiet"]
    assert main(["plan", "trento_hoosier", *options]) == 0
    check_file("plan", folder / "plan.json")
    content = json.loads((folder / "plan.json").read_text())
    assert content["seconds"] <= 180.0
    assert set(content["intervals"]) == {"stiffness_x", "stiffness_y"}
    assert len(pd.read_csv(folder / "steps.csv")) == content["steps"]
    program, measured = folder / "program.csv", tmp_path / "measured.csv"
    run = ["--tire", "trento_hoosier", "--program", str(program), "--bench", str(bench), "-o", str(measured)]
    assert main(["example", *run, "--quiet"]) == 0
    assert {"Fx", "Fy", "Mz"} <= set(pd.read_csv(measured))
    assert len(program_from(program)) == len(pd.read_csv(measured))
    assert main(["plan", "trento_hoosier", *options[:2], "--for", "stifness", "-o", str(tmp_path / "no")]) == 2
    assert not (tmp_path / "no").exists()
    assert "did you mean stiffness" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"alpha": "low = 0.0\nhigh = 0.0\nrate = 0.1"}, "no slip is swept"),
        ({"alpha": "low = -0.2\nhigh = 0.2"}, "no slip is swept"),
        ({"alpha": "low = 0.1\nhigh = 0.2\nrate = 0.1"}, "0 has to be within"),
        (
            {"alpha": "low = -0.2\nhigh = 0.2\nrate = 0.1", "heat": "energy_of_a_sweep = 1.0"},
            r"\[heat\] needs the speed",
        ),
    ],
)
def test_a_bench_that_cannot_sweep_is_refused_when_it_is_read(tmp_path, change, message):
    path = tmp_path / "bench.toml"
    path.write_text("\n".join(f"[{name}]\n{text}" for name, text in change.items()))
    with pytest.raises(PlanError, match=message):
        read_bench(path)


@pytest.mark.parametrize(
    ("bench", "aims", "message"),
    [
        ({"heat": Heat(energy_of_a_sweep=1.0)}, ["stiffness"], "every sweep has more sliding energy"),
        ({"warm_up": 200.0}, ["stiffness"], "too short: a warm-up of 200 s"),
        ({"limits": {"alpha": ALPHA}}, ["PKX1"], "the bench does not sweep kappa"),
        ({"limits": {"alpha": replace(ALPHA, change=1e3)}}, ["PDY1"], "too short"),
        ({"limits": {"alpha": ALPHA}}, ["PKY2"], "and the load does not vary"),
    ],
)
def test_a_bench_that_cannot_do_what_is_required_is_named(bench, aims, message):
    limits = {"Fz": LOADS, "alpha": ALPHA, "V": Limits(11.0, 11.0)}
    with pytest.raises(PlanError, match=message):
        plan("trento_hoosier", Bench(**{"limits": limits, **bench}), aims=aims, minutes=2.0)


@pytest.mark.slow
def test_a_bench_with_one_side_has_programs():
    bench = replace(LATERAL, limits={"Fz": LOADS, "alpha": replace(ALPHA, low=0.0)})
    steps = plan("trento_hoosier", bench, aims=["stiffness"], minutes=2.0).program.table
    assert (steps["first side"] > 0.0).all()
    assert (steps["second side"] == 0.0).all()
