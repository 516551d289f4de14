"""`tirefmu fit`: constraints, cross-validation and reports."""

from __future__ import annotations

import json

import pytest


def test_a_misspelt_constraint_is_refused_with_the_nearest_name(command, bench_csv, tmp_path):
    for option in ("--constraint", "--without-constraint"):
        outcome = command("fit", bench_csv, "--model", "mf96", option, "curvature:E_yy", "-o", tmp_path / "t.tir")
        assert outcome.status == 2
        assert "constraint of mf96 'curvature:E_yy': did you mean curvature:E_y" in outcome.err
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(("options", "stored"), [
    (("--without-constraint", "all"), set()),
    (("--without-constraint", "extrapolation,signs,friction_falling,stiffness_saturating"), {"curvature"}),
])  # fmt: skip
def test_constraints_are_switched_by_name(command, bench_csv, tmp_path, options, stored):
    path = tmp_path / "fit.json"
    outcome = command(
        "fit", bench_csv, "--model", "mf96", "--effects", "none", *options, "-o", tmp_path / "t.tir", "--json", path
    )
    assert outcome.status == 0
    reported = json.loads(path.read_text(encoding="utf-8"))
    assert {margin["name"].partition(":")[0] for margin in reported["margins"]} == stored
    assert ("Constraints, verified" in outcome.out) == bool(stored)


def test_cross_validation_is_reported(command, bench_csv, tmp_path):
    path, effects = tmp_path / "fit.json", "load_friction,load_stiffness,camber_thrust"
    outcome = command(
        "fit",
        bench_csv,
        "--model",
        "mf96",
        "--effects",
        effects,
        "--cross-validate",
        "2",
        "-o",
        tmp_path / "t.tir",
        "--json",
        path,
    )
    assert outcome.status == 0
    reported = json.loads(path.read_text(encoding="utf-8"))
    assert {each["channel"] for each in reported["held_out"]} == {each["channel"] for each in reported["channels"]}
    for each in reported["held_out"]:
        assert each["held_out"] > 0.9 * each["in_sample"]
    assert "Cross-validation over operating conditions" in outcome.out
    assert "largest error" in outcome.out
    assert "noise floor" in outcome.out


def test_more_folds_than_conditions_are_refused_before_the_work(command, bench_csv, tmp_path):
    outcome = command("fit", bench_csv, "--model", "mf96", "--cross-validate", "500", "-o", tmp_path / "t.tir")
    assert outcome.status == 2
    assert "500 folds require at least 500 operating conditions" in outcome.err
    assert list(tmp_path.iterdir()) == []
