"""A family as a prior: it fills what the data lack, yields to data, and a tire outside of it is said to be so."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from tirefmu.boundary.errors import FitError
from tirefmu.commands.cli import main
from tirefmu.commands.demo import bench_tire
from tirefmu.fitting import Family, fit
from tirefmu.fitting.problem import Prior
from tirefmu.measurements import ChannelNoise, Noise, VirtualBench, alpha_sweeps, kappa_sweeps, write_table
from tirefmu.tires import read_tir

NOISE = Noise({"Fx": ChannelNoise(5.0), "Fy": ChannelNoise(5.0), "Mz": ChannelNoise(0.5)})
NOMINAL = {"Fz0": 220.0, "R0": 0.2304}


def family_tires(count):
    """Return tires whose coefficients differ by 8 %, independent of each other."""
    base, random = bench_tire(), np.random.default_rng(3)
    declared = base.symbolic_model.coefficients
    varied = [name for name, one in declared.items() if one.fitted]
    for _ in range(count):
        factors = dict(zip(varied, 1.0 + 0.08 * random.standard_normal(len(varied)), strict=True))
        yield replace(base, values={name: value * factors.get(name, 1.0) for name, value in base.values.items()})


@pytest.fixture(scope="module")
def family(tmp_path_factory):
    folder = tmp_path_factory.mktemp("family")
    for number, tire in enumerate(family_tires(8)):
        tire.save(folder / f"{number}.tir")
    return folder


def recordings(tire, seed=0):
    loads = [220.0, 1120.0]
    programs = (alpha_sweeps(loads, sample_rate=20.0), kappa_sweeps(loads, sample_rate=20.0))
    return [VirtualBench(tire, NOISE, seed=seed).run(program) for program in programs]


@pytest.fixture(scope="module")
def result(family):
    return fit(recordings(bench_tire()), "mf96", family=family, nominal=NOMINAL, rows="equal")


def test_combined_slip_comes_from_the_family_and_is_marked(result):
    marked = {one.name for one in result.coefficients if one.from_family}
    assert {"RBX2", "RBY2", "PDY3"} <= marked
    assert not {"PDY1", "PKY1", "PDX1"} & marked
    assert set(result.tire.about["from_family"].split()) >= marked
    assert any(note.startswith("within the family of 8 tires") for note in result.notes)


def test_family_predicts_combined_slip_within_its_bands(result):
    truth = bench_tire()
    random = np.random.default_rng(0)
    table = {"alpha": random.uniform(-0.2, 0.2, 100), "kappa": random.uniform(-0.3, 0.3, 100)}
    rows = pd.DataFrame({**table, "Fz": random.uniform(220.0, 1120.0, 100)})
    for channel in ("Fx", "Fy"):
        band = result.interval(channel, rows)
        exact = truth.evaluate(rows, signs="iso")[channel].to_numpy()
        assert np.mean((band["lower"] <= exact) & (exact <= band["upper"])) > 0.8
        assert band["error"].median() < 0.1 * np.abs(exact).max()


def test_data_prevail_over_the_family(family, result):
    other = bench_tire().with_values(PDY1=bench_tire().values["PDY1"] * 0.85)
    moved = fit(recordings(other), "mf96", family=family, nominal=NOMINAL, rows="equal")
    assert moved.in_signs("adapted-sae").tire.values["PDY1"] == pytest.approx(other.values["PDY1"], rel=0.02)


def test_a_tire_outside_is_said_to_be_outside(family):
    strange = bench_tire().with_values(PDY1=1.0, PDX1=1.1, PKY1=40.0, PKX1=20.0)
    result = fit(recordings(strange), "mf96", family=family, nominal=NOMINAL, rows="equal")
    assert any(note.startswith("outside the family") for note in result.notes)
    with pytest.raises(FitError, match="outside the family"):
        fit(recordings(bench_tire()), "mf96", family=family, nominal={"Fz0": 30000.0, "R0": 0.5})


def test_family_of_one_published_tire_and_of_another_model(family):
    result = fit(recordings(bench_tire()), "mf96", family="trento_hoosier", nominal=NOMINAL, rows="equal")
    assert any(note.startswith("within the family of 1 tires") for note in result.notes)
    with pytest.raises(FitError, match="is mf96, not mf61"):
        fit(recordings(bench_tire()), "mf61", family=family, nominal=NOMINAL)


@pytest.mark.parametrize("count", [2, 3, 7])
def test_equal_tires_are_a_prior_without_correlations(tmp_path, count):
    """Their mean has a rounding error, and so do the deviations from it."""
    for number in range(count):
        bench_tire().save(tmp_path / f"{number}.tir")
    family = Family.of(str(tmp_path), bench_tire().symbolic_model, {})
    np.testing.assert_array_equal(family.covariance, np.diag(np.diag(family.covariance)))
    assert (np.diag(family.covariance) > 0.0).all()
    assert list(family.tire.values.values()) == pytest.approx(list(bench_tire().values.values()), rel=1e-9)


def test_order_of_the_files_does_not_matter(tmp_path, family):
    tires = [read_tir(path) for path in sorted(family.iterdir())]
    for number, tire in enumerate(reversed(tires)):
        tire.save(tmp_path / f"{number}.tir")
    first, second = (
        fit(recordings(bench_tire())[:1], "mf96", family=folder, nominal=NOMINAL).tire for folder in (family, tmp_path)
    )
    assert first.values == pytest.approx(second.values, rel=1e-4, abs=1e-4)


def test_prior_is_the_gradient_of_its_cost():
    random = np.random.default_rng(0)
    square = random.standard_normal((4, 4))
    prior = Prior(random.standard_normal(4), square @ square.T, 0.3)
    x, step = random.standard_normal(4), 1e-6
    slopes = [(prior.cost(x + step * one) - prior.cost(x - step * one)) / (2 * step) for one in np.eye(4)]
    assert prior.gradient(x) == pytest.approx(slopes, rel=1e-6)


def test_command(tmp_path, capsys, family):
    table, tire = tmp_path / "cornering.csv", tmp_path / "my.tir"
    write_table(recordings(bench_tire())[0].with_signs("iso").table, table)
    command = ["fit", str(table), "--model", "mf96", "--nominal", "Fz0=220,R0=0.2304", "-o", str(tire)]
    assert main([*command, "--family", str(family), "--all"]) == 0
    assert "from the family" in capsys.readouterr().out
    assert read_tir(tire).about["family"] == "8 tires, within"
    assert main([*command, "--family", "hoosier"]) == 2
    assert "did you mean trento_hoosier" in capsys.readouterr().err


@pytest.mark.parametrize("count", [2, 3, 5])
def test_rounded_values_are_no_differences_among_tires(count, tmp_path):
    """Neither of the tire's size, over which coefficients would have slopes, nor of coefficients."""
    tire = bench_tire()
    for number in range(count):
        size = {name: tire.values[name] * (1.0 + number * 2.0**-51) for name in ("FNOMIN", "UNLOADED_RADIUS")}
        replace(tire, values={**tire.values, **size}).save(tmp_path / f"{number}.tir")
    larger = {"FNOMIN": 1.5 * tire.values["FNOMIN"]}
    here, there = (Family.of(tmp_path, tire.symbolic_model, nominal) for nominal in ({}, larger))
    np.testing.assert_array_equal(there.mean, here.mean)
    np.testing.assert_array_equal(there.covariance, here.covariance)
