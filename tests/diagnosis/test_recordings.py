"""Recordings with various rates, signs, formats and missing columns; baseline models of other families."""

from __future__ import annotations

import json

import numpy as np
import pandas as pd
import pytest
from threadpoolctl import threadpool_info, threadpool_limits

from tirefmu.boundary.errors import DataError
from tirefmu.commands.cli import main
from tirefmu.diagnosis import diagnose
from tirefmu.diagnosis.signals import ripple, signals_of
from tirefmu.tires import Tire, published

from .suite import make_case

NOMINAL = {"Fz0": 3000.0, "R0": 0.3, "p0": 2e5, "V0": 16.7}
VALUES = {"FNOMIN": 3000.0, "UNLOADED_RADIUS": 0.3, "NOMPRES": 2e5, "INFLPRES": 2e5, "LONGVL": 16.7}
FY = {"PCY1": 1.35, "PDY1": 1.1, "PDY2": -0.1, "PEY1": -0.6, "PKY1": 25.0, "PKY2": 1.9}
EFFECTS = ("load_friction", "load_stiffness")


def sweeps(rate=25.0, seconds=6.0):
    """Return inputs, adapted SAE: sweeps of alpha at three loads and three inclinations."""
    parts = [
        pd.DataFrame({"alpha": 0.14 * np.sin(np.linspace(0.0, 2.0 * np.pi, int(rate * seconds))), "gamma": g, "Fz": f})
        for f in (1500.0, 3000.0, 4500.0)
        for g in (-0.06, 0.0, 0.06)
    ]
    table = pd.concat(parts, ignore_index=True).assign(kappa=0.0)
    table.insert(0, "t", np.arange(len(table)) / rate)
    return table


def measured(tire, table, signs="adapted-sae"):
    force = tire.evaluate(table, signs=signs)["Fy"]
    return table.assign(Fy=force + np.random.default_rng(3).normal(0.0, 15.0, len(table)))


def hidden():
    return Tire("mf61", {**VALUES, **FY, "PKY6": 1.3, "PVY3": 0.4}, effects=(*EFFECTS, "camber_thrust"),
                signs="adapted-sae")  # fmt: skip


@pytest.mark.parametrize(("rate", "dropped"), [(20.0, ["kappa"]), (100.0, ["t", "kappa"])])
def test_a_bare_parquet_file_of_side_force(tmp_path, rate, dropped):
    table = measured(hidden(), sweeps(rate)).assign(Fy=lambda rows: -rows["Fy"])  # as ISO writes it
    table.drop(columns=dropped).to_parquet(tmp_path / "bench.parquet")
    nominal = ",".join(f"{name}={value}" for name, value in NOMINAL.items())
    status = main(["diagnose", str(tmp_path / "bench.parquet"), "--effects", ",".join(EFFECTS), "--nominal", nominal,
                   "--no-fmu", "-o", str(tmp_path / "answer"), "--quiet"])  # fmt: skip
    assert status == 0
    reported = json.loads((tmp_path / "answer" / "diagnosis.json").read_text(encoding="utf-8"))
    assert [one["effect"] for one in reported["found"]] == ["camber_thrust"]
    assert (reported["signs"], reported["recording_signs"]) == ("iso", "iso")
    absent = {"temp_friction", "speed_friction", "pressure_friction", "relax_lon", "combined_Gyk", "Mz_from_Fx"}
    assert absent | ({"relax_lat", "wear_drift"} if "t" in dropped else set()) <= set(reported["not_identifiable"])
    gap = reported["gap"]["holdout"]["Fy"]
    assert gap["after"] < 0.6 * gap["before"]


@pytest.mark.parametrize("family", ["mf96", pytest.param("mf52", marks=pytest.mark.slow)])
def test_a_fitted_tire_of_another_family_is_a_baseline(family):
    if family == "mf96":
        whole = published("trento_hoosier")
        whole = Tire("mf96", {**whole.values, "PHY3": 0.05, "PVY3": 0.0}, effects=whole.has, signs=whole.signs)
        table = sweeps().assign(Fz=lambda rows: rows["Fz"] / 4.0)
    else:
        effects = (*EFFECTS, "camber_thrust")
        whole = Tire("mf52", {**VALUES, **FY, "PHY3": 0.05}, effects=effects, signs="adapted-sae")
        table = sweeps()
    start = Tire(family, whole.values, effects=whole.has - {"camber_thrust"}, signs=whole.signs)
    answer = diagnose(measured(whole, table), signs="adapted-sae", tire=start)
    assert [one.effect for one in answer.found] == ["camber_thrust"]
    interval = answer.in_signs("adapted-sae").found[0].coefficients["PHY3"]
    assert interval.value == pytest.approx(0.05, abs=0.02)
    assert answer.tire.model == family


def test_ripple_quantisation_and_uninformative_channels_are_reported():
    table = measured(hidden(), sweeps(50.0, 8.0)).assign(V=16.7, Fx=2.0)
    turned = 16.7 * table["t"] / (0.97 * 0.3)
    table["Fy"] = np.round((table["Fy"] + 40.0 * np.sin(turned)) / 5.0) * 5.0
    answer = diagnose(table, signs="adapted-sae", effects=(*EFFECTS, "camber_thrust"), nominal=NOMINAL)
    assert answer.found == ()
    assert answer.recording["ripple"]["Fy"] == pytest.approx(40.0, rel=0.15)
    assert answer.recording["quantisation"]["Fy"] == pytest.approx(5.0)
    assert list(answer.recording["left_aside"]) == ["Fx"]
    holdout = answer.holdout_mask(len(table))
    assert 0.05 < holdout.mean() < 0.2


def test_a_diagnosis_computes_with_one_thread_of_blas():
    threads = set()

    def first(sentence):
        threads.update(each["num_threads"] for each in threadpool_info() if each["user_api"] == "blas")
        raise InterruptedError

    with threadpool_limits(limits=2, user_api="blas"), pytest.raises(InterruptedError):
        diagnose(measured(hidden(), sweeps()), signs="adapted-sae", nominal=NOMINAL, progress=first)
    assert threads <= {1}


def test_noise_is_not_reported_as_ripple():
    case = make_case(3, sweeps=10)
    tire = Tire("mf61", VALUES, effects=EFFECTS, signs="adapted-sae")
    signals = signals_of(case.table, tire, "adapted-sae")
    noise = np.random.default_rng(4).normal(0.0, 30.0, signals.measured.shape)
    assert ripple(signals, noise, 0.3) == {}


@pytest.mark.parametrize(
    ("spoiled", "message"),
    [
        (lambda table: table.drop(columns="Fz"), "no column 'Fz'"),
        (lambda table: table.drop(columns="Fy"), "no measured output"),
        (lambda table: table.assign(gamma=np.where(table.index >= 7, np.nan, table["gamma"])), "row 8: gamma"),
        (lambda table: table.assign(t=np.inf), "row 1: t is inf"),
    ],
)
def test_unusable_recordings_raise_a_clear_error(spoiled, message):
    with pytest.raises(DataError, match=message):
        diagnose(spoiled(measured(hidden(), sweeps())), signs="adapted-sae", nominal=NOMINAL)


@pytest.mark.slow
@pytest.mark.parametrize("seed", ["1", "12"])
def test_nothing_is_named_on_recordings_of_a_fitted_tire_that_lacks_nothing(tmp_path, seed):
    """At 10 Hz: the drift of the grip of every explanation is as probable as an effect of the first metres."""
    table, tire = (str(tmp_path / name) for name in ("bench.csv", "fitted.tir"))
    assert main(["example", "-o", table, "--sample-rate", "10", "--seed", seed, "--quiet"]) == 0
    nominal = ["--nominal", "Fz0=700,R0=0.23"]
    assert main(["fit", table, "--model", "mf96", *nominal, "-o", tire, "--quiet"]) == 0
    diagnosis = diagnose(table, tire=tire)
    assert diagnosis.headline == "Nothing material is missing"
    assert max(diagnosis.answer.probabilities.values()) < 0.5
