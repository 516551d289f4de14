"""The command line: its files, its messages, and its errors."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import tirefmu
import tirefmu.generated
from tirefmu.commands.arguments import write_json
from tirefmu.symbolic.models import MODELS
from tirefmu.symbolic.printers import generate
from tirefmu.tires import read_tir


def strict(text):
    """Read JSON that has no NaN and no Infinity."""

    def refuse(constant):
        raise AssertionError(f"{constant} is not JSON")

    return json.loads(text, parse_constant=refuse)


#: What standard error has without a terminal: a line for each stage that has ended.
PROGRESS = re.compile(r".+: (.+, )?\d+\.\d s(; stage \d+ of \d+(, .+ left)?)?")


# ------------------------------------------------------------------ the full workflow


def test_every_step_of_the_workflow_succeeds(chain):
    _, outcomes = chain
    for step, outcome in outcomes.items():
        assert outcome.status == 0, (step, outcome.err)
        assert all(PROGRESS.fullmatch(line) for line in outcome.err.splitlines()), (step, outcome.err)


def test_no_files_but_the_requested_files(chain):
    folder, _ = chain
    files = {path.name for path in folder.iterdir()}
    requested = {"fitted.tir", "fit.json", "report.html", "figures"}
    assert files == requested | {f"fmi{fmi}.fmu" for fmi in "23"} | {f"check{fmi}.json" for fmi in "23"}
    assert {path.suffix for path in (folder / "figures").iterdir()} == {".png"}


def test_a_truth_value_of_numpy_is_no_text(tmp_path):
    write_json(tmp_path / "a.json", {"ok": np.bool_(False), "rows": np.int64(3), "path": tmp_path})
    assert strict((tmp_path / "a.json").read_text()) == {"ok": False, "rows": 3, "path": str(tmp_path)}


def test_the_report_has_the_figures_of_the_folder(chain):
    page = (chain[0] / "report.html").read_text(encoding="utf-8")
    tabs = page.count('type="radio"')  # the curves of forces and of moments, in addition
    assert page.count('class="panels"') == len(list((chain[0] / "figures").iterdir())) + tabs
    assert tabs == 2
    assert page.count("data:image/png;base64,") == 1  # the first one can be seen without JavaScript


def test_the_fit_is_the_same_everywhere(chain):
    folder, outcomes = chain
    reported = strict((folder / "fit.json").read_text(encoding="utf-8"))
    tire = read_tir(folder / "fitted.tir")
    assert reported["ok"] is True
    assert reported["values"] == dict(tire.values)
    assert reported["effects"] == sorted(tire.has)
    assert tire.values["FNOMIN"] == 220.0
    out, page = outcomes["fit"].out, (folder / "report.html").read_text(encoding="utf-8")
    assert "fit converged" in out
    for channel in reported["channels"]:
        assert f"{channel['r2']:.5f}" in out
        assert channel["channel"] == "Mz" or channel["r2"] > 0.99  # the fit does not include the effects of Mz
    for coefficient in reported["coefficients"]:
        assert coefficient["name"] in out
        assert coefficient["name"] in page


def test_the_check_reports_the_error_against_the_data(chain):
    folder, outcomes = chain
    fitted = {c["channel"]: c["rmse"] for c in strict((folder / "fit.json").read_text())["channels"]}
    for fmi in "23":
        reported = strict((folder / f"check{fmi}.json").read_text(encoding="utf-8"))
        assert reported["ok"] is True
        assert reported["evaluation_difference"] < 1e-9
        for name, rmse in fitted.items():
            assert reported["channels"][name]["rmse"] == pytest.approx(rmse, rel=1e-6)
            assert name in outcomes[f"check {fmi}"].out


def test_a_failed_check_exits_with_1(chain, command, bench_csv):
    folder, _ = chain
    assert command("check", folder / "fmi3.fmu", bench_csv, "--tolerance", "1e-6").status == 1
    assert command("check", folder / "fmi3.fmu", bench_csv, "--tolerance", "0.5").status == 0


def test_a_fit_that_does_not_converge_exits_with_1(command, bench_csv, tmp_path):
    outcome = command(
        "fit", bench_csv, "--model", "mf96", "--effects", "none", "--iterations", 1, "-o", tmp_path / "poor.tir"
    )
    assert outcome.status == 1
    assert "fit not converged: stage" in outcome.out
    assert read_tir(tmp_path / "poor.tir").has == frozenset()


def test_the_evolutionary_method_reports_that_its_limit_ended_it(command, bench_csv, tmp_path):
    reported = tmp_path / "reported.json"
    outcome = command(
        "fit", bench_csv, "--model", "mf96", "--effects", "none", "--method", "ioa", "--iterations", 2, "--seed", 5,
        "-o", tmp_path / "evolved.tir", "--json", reported,
    )  # fmt: skip
    assert outcome.status == 1
    assert "iteration limit (ioa)" in outcome.out
    content = strict(reported.read_text(encoding="utf-8"))
    assert content["method"] == "ioa"
    assert not content["ok"]
    assert read_tir(tmp_path / "evolved.tir").has == frozenset()


def test_a_fit_from_a_tire_and_a_user_defined_recipe(chain, command, bench_csv, tmp_path):
    folder, _ = chain
    recipe = tmp_path / "friction [only].toml"
    recipe.write_text('[[stage]]\nname = "[friction]"\n[stage.free]\nPDY1 = { guess = 2, lower = 1, upper = 4 }\n')
    start = ("--start", folder / "fitted.tir", "--recipe", recipe, "-o", tmp_path / "[new].tir")
    outcome = command("fit", bench_csv, "--model", "mf96", *start)
    assert outcome.status == 0, outcome.err
    before, after = read_tir(folder / "fitted.tir"), read_tir(tmp_path / "[new].tir")
    assert after.has == before.has
    assert {n for n in after.values if after.values[n] != before.values[n]} == {"PDY1"}
    assert "[friction]: iteration" in outcome.err  # brackets in names are not markup
    assert f"tire: {tmp_path / '[new].tir'}" in outcome.out


# ------------------------------------------------------------------ evaluate


@pytest.mark.parametrize("code", ["numpy", "c", "casadi"])
def test_evaluate_gives_the_golden_numbers(command, trento_table, published_tir, code, tmp_path):
    out = tmp_path / "out.csv"
    outcome = command("evaluate", published_tir, trento_table, "--signs", "adapted-sae", "--code", code, "-o", out)
    assert outcome.status == 0, outcome.err
    found, reference = pd.read_csv(out), pd.read_csv(trento_table)
    pairs = {
        "FX": "Fx", "FY": "Fy", "FX0": "F_x0", "FY0": "F_y0", "MZ0": "M_z0", "Kya": "K_yalpha", "Kxk": "K_xkappa",
        "Gxa": "G_xa", "Gyk": "G_yk", "SVyk": "S_Vyk", "Bt": "B_t", "Dr": "D_r", "Ey": "E_y",
        "CorneringStiffness_x": "F_x0_slope", "CorneringStiffness_y": "F_y0_slope",
    }  # fmt: skip
    for theirs, ours in pairs.items():
        error = (found[ours] - reference[theirs]).abs() / (1 + reference[theirs].abs())
        assert (error < 1e-9).all(), theirs
    for name in ("kappa", "alpha", "gamma", "Fz"):
        # Older versions of pandas read a number with an error of a few roundings.
        np.testing.assert_allclose(found[name], reference[name], rtol=1e-14)


def test_evaluate_takes_nominal_values_and_clamps_on_request(command, chain, tmp_path):
    tire, table = chain[0] / "fitted.tir", tmp_path / "in.csv"
    table.write_text("alpha [deg],Fz [kN]\n3,0.7\n30,0.7\n", encoding="utf-8")
    outcomes = {
        name: command("evaluate", tire, table, "-o", tmp_path / f"{name}.csv", *options)
        for name, options in (("free", []), ("clamped", ["--limits"]))
    }
    assert all(outcome.status == 0 for outcome in outcomes.values())
    assert "nominal values used: kappa, gamma" in outcomes["free"].out
    free, clamped = (pd.read_csv(tmp_path / f"{name}.csv") for name in ("free", "clamped"))
    known = read_tir(tire)
    highest = known.ranges["alpha"][1]
    assert highest < np.radians(30.0)
    expected = known.forces(alpha=[np.radians(3.0), np.radians(30.0), highest], Fz=700.0)["Fy"]
    np.testing.assert_allclose(free["Fy"], expected[:2], rtol=1e-12)
    np.testing.assert_allclose(clamped["Fy"], expected[[0, 2]], rtol=1e-12)
    assert clamped.loc[1, "alpha"] == free.loc[1, "alpha"]  # the input is returned unchanged


# ------------------------------------------------------------------ printed output


@pytest.fixture
def calls(chain, bench_csv, published_tir, tmp_path):
    """Return a call of every command of the workflow."""
    fit = ["--model", "mf96", "--effects", "none", "-o", tmp_path / "t.tir", "--figures", tmp_path / "figures"]
    return [
        ["evaluate", published_tir, bench_csv, "-o", tmp_path / "o.csv"],
        ["fit", bench_csv, *fit],
        ["export", published_tir, "-o", tmp_path / "t.fmu"],
        ["check", chain[0] / "fmi3.fmu", bench_csv],
        ["info", published_tir],
    ]


def test_json_is_the_only_output_of_a_quiet_command(calls, capfd):
    for call in calls:
        assert tirefmu.commands.cli.main([*map(str, call), "--quiet", "--json", "-"]) == 0
        out, err = capfd.readouterr()  # includes output that libraries write directly
        assert strict(out)["ok"] is True, call
        assert err == ""


def test_json_is_the_only_standard_output(command, published_tir):
    outcome = command("info", published_tir, "--json", "-")
    assert strict(outcome.out)["model"] == "mf96"
    assert "mu_y" in outcome.err


@pytest.mark.parametrize(
    "call",
    [
        "fit run.csv -o run.csv",
        "fit run.csv -o new.tir --report ./run.csv",
        "export my.tir -o my.tir",
        "evaluate my.tir run.csv -o link.csv",
        "inspect run.csv --table run.csv",
        "convert my.tir --for adams -o new.tir --json my.tir",
        "fit run.csv -o new.tir --json new.tir",
    ],
)
def test_no_command_writes_over_what_it_reads_or_wrote(command, call, published_tir, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("run.csv").write_text("alpha,Fz,Fy\n0.1,900,-700\n", encoding="utf-8")
    Path("link.csv").hardlink_to("run.csv")
    Path("my.tir").write_bytes(published_tir.read_bytes())
    before = {path.name: path.read_bytes() for path in tmp_path.iterdir()}
    outcome = command(*call.split())
    assert (outcome.status, len(outcome.err.splitlines())) == (2, 1)
    assert "is an input of this command" in outcome.err or "is the name of two results" in outcome.err
    assert {path.name: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_info_reports_what_is_in_a_tire(command, published_tir):
    outcome = command("info", published_tir)
    assert outcome.status == 0
    for word in ("Hoosier", "mf96", "mu_y (-)", "K_yalpha (N/rad)", "camber_thrust", "220"):
        assert word in outcome.out
    assert "PDY1" not in outcome.out
    assert "PDY1" in command("info", published_tir, "--all").out
    reported = strict(command("info", published_tir, "--quiet", "--json", "-").out)
    assert reported["values"] == dict(read_tir(published_tir).values)
    assert set(reported["effects"]) | set(reported["effects_at_neutral"]) == read_tir(published_tir).has


# ------------------------------------------------------------------ generate


@pytest.fixture(scope="module")
def smallest(tmp_path_factory):
    """Return generated code of the smallest model of the Magic Formula only; test_committed.py prints all models."""
    folder = tmp_path_factory.mktemp("smallest")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(generate, "packaged_models", lambda: {"mf96": MODELS["mf96"]})
        generate.write(folder)
        yield folder


@pytest.fixture
def generated(smallest, tmp_path, monkeypatch):
    """Return a copy of generated code that the command uses instead of the original."""
    folder = tmp_path / "generated"
    shutil.copytree(smallest, folder)
    monkeypatch.setattr(tirefmu.generated, "__file__", str(folder / "__init__.py"))
    return folder


def test_a_planted_edit_is_found_shown_and_repaired(command, generated, capfd):
    source = generated / "c" / "mf96.c"
    right = source.read_text(encoding="utf-8")
    source.write_text(right.replace("sin(", "cos(", 1), encoding="utf-8")
    planted = source.read_bytes()
    outcome = command("generate", "--check")
    assert outcome.status == 1
    removed = [line for line in outcome.out.splitlines() if line.startswith("-") and "cos(" in line]
    added = [line for line in outcome.out.splitlines() if line.startswith("+") and "sin(" in line]
    assert len(removed) == len(added) == 1
    assert "generated/c/mf96.c" in outcome.out
    assert source.read_bytes() == planted  # checked, not changed
    reported = strict(command("generate", "--check", "--quiet", "--json", "-").out)
    assert reported["ok"] is False
    assert "generated/c/mf96.c" in reported["diff"]
    written = command("generate")
    assert written.status == 0
    assert "generated/c/mf96.c" in written.out
    assert source.read_text(encoding="utf-8") == right
    assert command("generate", "--check").status == 0
    assert "up to date" in command("generate").out
    reported = command("generate", "--check", "--quiet", "--json", "-")
    assert (strict(reported.out)["ok"], reported.err) == (True, "")
    assert tirefmu.commands.cli.main(["generate", "--check", "--quiet"]) == 0
    assert capfd.readouterr() == ("", "")


def test_another_folder_gets_the_jacobians_too(command, generated, tmp_path, monkeypatch):
    monkeypatch.setattr(generate, "packaged_models", lambda: {"fiala": MODELS["fiala"]})
    outcome = command("generate", "-o", str(tmp_path / "all"))
    assert outcome.status == 0
    assert (tmp_path / "all" / "numpy" / "fiala_jacobians.py").is_file()
    assert (tmp_path / "all" / "with_effects" / "c" / "fiala_batch_jacobian_inputs.c").is_file()
    assert "all/c/fiala_jacobians.c" in outcome.out
    assert not list(generated.rglob("*_jacobians.*"))
    assert command("generate", "--check", "-o", str(tmp_path / "all")).status == 2


# ------------------------------------------------------------------ as a process


def test_python_m_tirefmu(published_tir, tmp_path):
    environment = {**os.environ, "PYTHONWARNINGS": "error"}
    reported = subprocess.run(
        [sys.executable, "-m", "tirefmu", "info", str(published_tir), "--json", "-", "--quiet"],
        capture_output=True, text=True, env=environment, cwd=tmp_path,
    )  # fmt: skip
    assert (reported.returncode, reported.stderr) == (0, "")
    assert strict(reported.stdout)["model"] == "mf96"
    refused = subprocess.run(
        [sys.executable, "-m", "tirefmu", "info", "missing.tir"], capture_output=True, text=True, cwd=tmp_path
    )
    assert refused.returncode == 2
    assert refused.stdout == ""
    assert len(refused.stderr.splitlines()) == 1
