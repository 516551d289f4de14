"""A user-defined effect that is not in the library: hidden, identified, saved, evaluated, exported."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from tirefmu.commands.cli import main
from tirefmu.fmu import check
from tirefmu.symbolic.added import read_effect
from tirefmu.tires import Tire, read_tir

from .suite import make_case

FILE = Path(__file__).parents[2] / "docs" / "effects" / "flash_temperature.toml"
EFFECT = read_effect(FILE.read_text(encoding="utf-8"), FILE.name)
HIDDEN = 0.45
VALUES = {
    "PCX1": 1.6, "PDX1": 1.25, "PDX2": -0.1, "PEX1": -0.2, "PKX1": 22.0, "PCY1": 1.4, "PDY1": 1.15, "PDY2": -0.12,
    "PEY1": -0.5, "PKY1": 24.0, "PKY2": 1.9,
}  # fmt: skip
BASE = ("load_friction", "load_stiffness", "combined_Gxa", "combined_Gyk")


@pytest.fixture(scope="module")
def recorded(tmp_path_factory):
    """Return a recording and its nominal values: noisy Fx and Fy, 18 sweeps at several loads and speeds."""
    folder = tmp_path_factory.mktemp("own effect")
    case = make_case(7, sweeps=18)
    size = {"FNOMIN": case.nominal["Fz0"], "UNLOADED_RADIUS": 0.3, "NOMPRES": 220e3, "INFLPRES": 220e3, "LONGVL": 16.7}
    combined = {"RBX1": 12.0, "RBX2": 9.0, "RCX1": 1.1, "RBY1": 11.0, "RBY2": 9.0, "RCY1": 1.05}
    truth = Tire("mf61", {**size, **VALUES, **combined, "FLASH1": HIDDEN}, effects=(*BASE, EFFECT.name),
                 signs="adapted-sae", added=(EFFECT,))  # fmt: skip
    table = case.truth.drop(columns=["Fx", "Fy", "Mz"])
    forces = truth.evaluate(table, signs="adapted-sae")
    rng = np.random.default_rng(7)
    for name in ("Fx", "Fy"):
        table[name] = forces[name] + rng.normal(0.0, 0.01 * size["FNOMIN"], len(table))
    table.to_csv(folder / "bench.csv", index=False)
    return folder / "bench.csv", f"Fz0={size['FNOMIN']},R0=0.3,p0=220000,V0=16.7"


@pytest.fixture(scope="module")
def answered(recorded):
    """Return the folder of a diagnosis, and the recording."""
    table, nominal = recorded
    folder = table.with_name("answer")
    status = main(["diagnose", str(table), "--signs", "adapted-sae", "--effects", ",".join(BASE),
                   "--nominal", nominal, "--effect", str(FILE), "-o", str(folder), "--quiet"])  # fmt: skip
    assert status == 0
    return folder, table


@pytest.mark.slow
def test_it_is_identified_among_all_candidates(answered):
    reported = json.loads((answered[0] / "diagnosis.json").read_text(encoding="utf-8"))
    assert [one["effect"] for one in reported["found"]] == [EFFECT.name]
    size = reported["found"][0]["coefficients"]["FLASH1"]
    assert size["lower"] < size["value"] < size["upper"]
    assert size["value"] == pytest.approx(HIDDEN, rel=0.15)
    gap = reported["gap"]["holdout"]["Fy"]
    assert gap["after"] < 1.2 * gap["floor"] < 0.5 * gap["before"]
    assert reported["confounded_with"][EFFECT.name] == ["speed_friction"]  # both grow with V
    assert {one["input"] for one in reported["extrapolation"]} == {"Fz", "V"}


@pytest.mark.slow
def test_the_improved_tire_contains_its_equations(answered):
    improved = read_tir(answered[0] / "improved.tir")
    assert EFFECT.name in improved.has
    assert improved.values["FLASH1"] == pytest.approx(HIDDEN, rel=0.15)
    assert any("FLASH1*" in str(line) for line in improved.symbolic_model.as_written(improved.has).values())
    page = (answered[0] / "report.html").read_text(encoding="utf-8")
    assert "FLASH1*sqrt(" in page


@pytest.mark.slow
def test_fmu_and_tire_file_agree(answered, tmp_path):
    folder, table = answered
    reported = json.loads((folder / "diagnosis.json").read_text(encoding="utf-8"))
    for when, tire, fmu in (("before", "base_tire", "base_fmu"), ("after", "tire", "fmu")):
        simulated = reported["simulated"][when]
        assert simulated["difference_from_direct_evaluation"] < 1e-9
        output = tmp_path / f"{when}.csv"
        arguments = ["evaluate", str(folder / reported[tire]), str(table), "--signs", "adapted-sae", "--hold"]
        assert main([*arguments, "-o", str(output), "--quiet"]) == 0
        again = check(folder / reported[fmu], table, signs="adapted-sae")
        assert again.evaluation_difference is not None
        assert again.evaluation_difference < 1e-9
        evaluated, measured = (np.genfromtxt(path, delimiter=",", names=True) for path in (output, table))
        for name, rmse in simulated["rmse"].items():
            assert np.sqrt(np.mean((evaluated[name] - measured[name]) ** 2)) == pytest.approx(rmse, rel=1e-9)
    assert reported["simulated"]["after"]["holdout"]["Fy"] < 0.8 * reported["simulated"]["before"]["holdout"]["Fy"]


@pytest.mark.slow
def test_an_exported_tire_file_contains_the_effect(answered, tmp_path):
    folder, table = answered
    assert main(["export", str(folder / "improved.tir"), "-o", str(tmp_path / "own.fmu"), "--quiet"]) == 0
    assert check(tmp_path / "own.fmu", table, signs="adapted-sae").ok


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("sqrt(Fz", "__import__('os').system('id')*sqrt(Fz", "is not allowed in a formula"),
        ("FLASH1*sqrt", "FLASH1.__class__*sqrt", "is not allowed in a formula"),
        ("FLASH1*sqrt", "__builtins__*FLASH1*sqrt", "__builtins__"),
        ("kappa**2", "kappa**999999999", "too high"),
        ("kappa**2", "9**9**9**9", "a power of 387420489: it is too high"),
        ("abs(V)", "abs(VV)", "reads 'VV', which"),
        ("abs(V)", "[V for V in (1,)][0]", "is not allowed in a formula"),
        ('on = "mu_y"', 'on = "mu"', "acts on 'mu', which is no named quantity"),
    ],
)
def test_an_invalid_file_raises_one_line_and_writes_nothing(recorded, tmp_path, capsys, old, new, message):
    text = FILE.read_text(encoding="utf-8")
    assert old in text
    (tmp_path / "own.toml").write_text(text.replace(old, new), encoding="utf-8")
    arguments = ["diagnose", str(recorded[0]), "--signs", "adapted-sae", "--nominal", "Fz0=3000,R0=0.3"]
    arguments += ["--effect", str(tmp_path / "own.toml")]
    assert main([*arguments, "-o", str(tmp_path / "answer"), "--quiet"]) == 2
    error = capsys.readouterr().err
    assert message in error
    assert len(error.strip().splitlines()) == 1
    assert not (tmp_path / "answer").exists()
