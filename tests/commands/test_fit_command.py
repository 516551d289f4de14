"""`tirefmu fit`: constraints, cross-validation and reports."""

from __future__ import annotations

import json
import re
import shutil
import signal
import subprocess
import sys

import pandas as pd
import pytest

from tirefmu.commands.terminal import LINE
from tirefmu.tires import convert_signs, read_tir

from .conftest import EFFECTS


@pytest.mark.parametrize(("options", "stored"), [
    (("--without-constraint", "all"), set()),
    (("--without-constraint", "extrapolation,signs,friction_falling,stiffness_saturating"), {"curvature"}),
])  # fmt: skip
def test_constraints_are_switched_by_name(command, bench_csv, tmp_path, options, stored):
    path = tmp_path / "fit.json"
    given = ("--model", "mf96", "--effects", "none", "-o", tmp_path / "t.tir", "--all", "--json", path)
    outcome = command("fit", bench_csv, *given, *options)
    assert outcome.status == 0
    reported = json.loads(path.read_text(encoding="utf-8"))
    assert {margin["name"].partition(":")[0] for margin in reported["margins"]} == stored
    assert ("Constraints, verified" in outcome.out) == bool(stored)


def test_cross_validation_is_reported(validated):
    outcome, reported = validated
    assert {channel["channel"] for channel in reported["held_out"]} == {
        channel["channel"] for channel in reported["channels"]
    }
    for channel in reported["held_out"]:
        assert channel["held_out"] > 0.9 * channel["in_sample"]
        assert re.search(rf"^.* {channel['channel']} .* {channel['held_out']:.4g} ", outcome.out, re.MULTILINE)
    assert "; cross-validation over conditions" in outcome.out
    assert "out of sample" in outcome.out


@pytest.fixture(scope="module")
def misread(bench_csv, tmp_path_factory):
    """Return the bench table in adapted SAE, which is read as ISO."""
    path = tmp_path_factory.mktemp("misread") / "adapted.csv"
    convert_signs(pd.read_csv(bench_csv), "iso", "adapted-sae").to_csv(path, index=False)
    return path


def test_wrong_signs_load_no_solver(misread, tmp_path):
    """The error is fast because nothing of the fit is imported."""
    program = (
        "import sys; from tirefmu.commands.cli import main; "
        f"assert main(['fit', {str(misread)!r}, '-o', {str(tmp_path / 't.tir')!r}]) == 2; "
        "assert 'casadi' not in sys.modules and 'sympy' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", program], check=True, capture_output=True)


def test_evaluate_warns_of_wrong_signs_and_check_refuses_them(command, misread, published_tir, tmp_path):
    fmu, expected = tmp_path / "tire.fmu", "the data fit adapted-sae (--signs adapted-sae)"
    assert command("export", published_tir, "-o", fmu).status == 0
    result = tmp_path / "result.json"
    outcome = command("evaluate", published_tir, misread, "-o", tmp_path / "out.csv", "--json", result)
    (warning,) = json.loads(result.read_text(encoding="utf-8"))["warnings"]
    assert expected in warning
    assert f"warning: {warning}" in outcome.text
    refused = command("check", fmu, misread)
    assert (refused.status, refused.out) == (2, "")
    assert warning in refused.err


def test_values_that_nobody_measured_are_marked(command, bench_csv, tmp_path):
    """A radius that was not given is an assumption of the fit; a fitted coefficient is not."""
    for options, marked in ((), True), (("--nominal", "R0=0.23"), False):
        path = tmp_path / "t.tir"
        outcome = command("fit", bench_csv, "--model", "mf96", "--effects", "none", *options, "-o", path)
        assert outcome.status == 0
        section = path.read_text(encoding="utf-8").partition("[TIREFMU_ASSUMED]")[2]
        assert ("UNLOADED_RADIUS" in section) == marked
        assert "PDY1" not in section
        shown = command("info", path, "--json", tmp_path / "info.json").out
        assert ("assumed, not measured: UNLOADED_RADIUS = 0.3" in shown) == marked


def test_the_tables_are_short_unless_all_is_requested(chain, validated):
    """Without --all a fit prints its verdict and goodness, and counts the rest; nothing of it is lost in the JSON."""
    (_, outcomes), (short, result) = chain, validated
    fitted = [c["name"] for c in result["coefficients"]]
    known = [c["name"] for c in result["coefficients"] if c["determined"] and not c["at_bound"]]
    table = outcomes["fit"].out.splitlines()
    determined = len(known) - sum(line.split(" ")[0] in known and "not identifiable" in line for line in table)
    assert f"\n{determined} of {len(fitted)} coefficients are determined" in short.out
    assert [name for name in fitted if f"\n{name} " in short.out] == []
    assert [name for name in fitted if f"\n{name} " not in outcomes["fit"].out] == []
    assert "Stages of recipe" not in short.out
    assert "Stages of recipe" in outcomes["fit"].out
    assert "--all lists every coefficient" in short.out
    assert len(short.out) < 0.6 * len(outcomes["fit"].out)
    stages = [line.split(":")[0] for line in short.err.splitlines() if not line.startswith("cross-validation")]
    assert (stages[0], stages[-1]) == ("preparing the fit", "evidence and intervals")
    assert len(stages) == 2 + len(result["stages"])


def test_the_first_screen_of_a_fit_has_forty_lines_of_a_hundred_columns(command, bench_csv, tmp_path, monkeypatch):
    """Of two files whose long names differ at their ends; cells and numbers are whole, the middle of a name is not."""
    monkeypatch.chdir(tmp_path)
    names = [f"{'corner_' * 12}{end}.csv" for end in ("cold", "hot")]
    for name in names:
        shutil.copy(bench_csv, name)
    given = ("--model", "mf96", "--effects", "none", "--nominal", "Fz0=220,R0=0.23")
    outcome = command("fit", *names, *given, "-o", "t.tir", "--report", "t.html", "--json", "t.json")
    assert outcome.status in (0, 1), outcome.err
    lines = outcome.out.splitlines()
    assert len(lines) <= 40
    texts = [re.sub(r"\(?tirefmu [a-z]+ .*", "", line) for line in lines]
    assert [line for line in texts if len(line) > LINE and not line.startswith(("tire: ", "report: "))] == []
    channels = json.loads((tmp_path / "t.json").read_text(encoding="utf-8"))["channels"]
    for channel in channels:
        row = rf"^corner_\S*\.\.\.\S*{re.escape(channel['recording'][-8:])} +{channel['channel']} .* "
        assert re.search(rf"{row}{channel['fitted_rmse']:.4g} .*{channel['fitted_r2']:.4f}$", outcome.out, re.MULTILINE)


# -------- Ctrl-C during a fit: the best values so far are written


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no SIGINT for one process alone")
def test_a_process_that_gets_the_signal(chain, command, bench_csv, tmp_path):
    line = ["fit", str(bench_csv), "--model", "mf96", "--effects", EFFECTS, "--nominal", "Fz0=220,R0=0.23"]
    where = tmp_path / "tire.tir", tmp_path / "tire.json", tmp_path / "tire.html"
    positions = ["-o", where[0], "--json", where[1], "--report", where[2]]

    # A shell ignores SIGINT in background processes.
    program = "import signal, sys; signal.signal(signal.SIGINT, signal.default_int_handler); " \
              "from tirefmu.commands.cli import main; sys.exit(main())"  # fmt: skip
    process = subprocess.Popen(
        [sys.executable, "-c", program, *line, *map(str, positions)],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    assert process.stderr is not None
    while not process.stderr.readline().startswith("Fy") and process.poll() is None:
        pass
    process.send_signal(signal.SIGINT)
    out, err = process.communicate()
    assert process.returncode == 1, err
    assert "fit interrupted in stage" in out
    assert "Traceback" not in err
    reported = json.loads(where[1].read_text(encoding="utf-8"))
    assert reported["ok"] is False
    assert reported["values"] == dict(read_tir(where[0]).values)
    assert "interrupted in stage" in where[2].read_text(encoding="utf-8")
