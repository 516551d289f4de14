"""The demo: the end-to-end workflow on the built-in bench, as a user runs it."""

from __future__ import annotations

import json
import re
from functools import partial

import pytest

from tests.json_schemas import check_file
from tirefmu.commands import demo
from tirefmu.commands.demo import BENCH_TIRE, bench_tire
from tirefmu.tires import published, read_tir


@pytest.mark.slow
def test_the_end_to_end_workflow(command, tmp_path, monkeypatch):
    """With fewer pixels in its second process, too."""
    coarse = (
        "from tirefmu.drawing import picture; from tirefmu.tires.drawing import files; "
        "files.DPI = picture.DPI = picture.PAGE_DPI = 40"
    )
    monkeypatch.setattr(demo, "_end_with_ctrl_c", partial(exec, coarse))
    folder = tmp_path / "made for it" / "demo"
    outcome = command("demo", "-o", folder, "--json", tmp_path / "demo.json")
    assert outcome.status == 0, outcome.out + outcome.err
    reported = json.loads((tmp_path / "demo.json").read_text(encoding="utf-8"))
    assert reported["ok"] is True
    assert reported["checks"] == {"tire_fmi3.fmu": True, "tire_fmi2.fmu": True}
    # Comparison of both recipes.
    rmse = {r: {c["channel"]: c["rmse"] for c in reported[r]["channels"]} for r in ("trento", "joint")}
    assert all(rmse["joint"][name] < rmse["trento"][name] for name in ("Fx", "Fy", "Mz"))
    # A missing effect is visible in the residuals, and not after it was added.
    missing = reported["missing_effect"]
    assert (missing["effect"], missing["channel"]) == ("camber_thrust", "Fy")
    assert missing["rmse_without"] > 1.2 * missing["rmse_with"]
    assert missing["explained_by_inputs_with"] < 0.5 * missing["explained_by_inputs_without"]
    # The diagnosis identifies the missing effect and adds it.
    diagnosis = reported["diagnosis"]
    assert diagnosis["found"] == ["camber_thrust"]
    assert diagnosis["gap"]["after"] < 0.7 * diagnosis["gap"]["before"]
    for when in ("before", "after"):
        assert diagnosis["simulated"][when]["difference_from_direct_evaluation"] < 1e-9
    check_file("diagnosis", folder / "diagnosis" / "diagnosis.json")
    # The reported files exist.
    files = {"bench.csv", "truth.tir", "trento.tir", "joint.tir", "without_camber_thrust.tir", "missing_effect.png"}
    made = {"figures", "diagnosis", "tire_fmi2.fmu", "tire_fmi3.fmu"}
    made |= {"index.html", "inspection.html", "explorer.html", "check.html"}
    files |= {"fit.png", "fmu_check.png", "diagnosis.png"}
    assert files | made == {path.name for path in folder.iterdir()}
    for name in files | {"figures", "tire_fmi2.fmu", "tire_fmi3.fmu"}:
        assert str(folder / name) in outcome.text or name.endswith(".tir"), name
    # The page links to files that exist, and has pictures of the steps after the data.
    page = (folder / "index.html").read_text(encoding="utf-8")
    assert "All checks passed" in page
    assert page.count('class="panels"') == 5
    assert page.count("data:image/png;base64,") == 1
    linked = re.findall(r'href="([^"#]+)"', page)
    assert len(linked) > 12
    assert all((folder / address).is_file() for address in linked)
    figures = {path.name for path in (folder / "figures").iterdir()}
    assert figures == {f"{name}.png" for name in (
        "pure_Fx", "pure_Fy", "pure_Mz", "combined", "weighting", "stiffness", "friction", "residuals_over_inputs",
        "residuals",
    )}  # fmt: skip
    assert "camber_thrust" not in read_tir(folder / "without_camber_thrust.tir").has
    truth = read_tir(folder / "truth.tir").in_signs("adapted-sae")
    assert truth.parameters() == pytest.approx(bench_tire().parameters(), rel=1e-15)
    for step in ("1 Virtual bench.", "2 Fit.", "3 FMU.", "4 A missing effect.", "5 Diagnosis."):
        assert step in outcome.out


def test_the_bench_tire_is_the_published_one_except_for_documented_values():
    tire, trento = bench_tire(), published("trento_hoosier")
    changed = {name for name, value in trento.values.items() if tire.values[name] != value}
    assert changed == {name for name, value in BENCH_TIRE.items() if trento.values[name] != value}
    assert "camber_thrust" in tire.has
    assert any(tire.values[name] for name in tire.symbolic_model.owned("camber_thrust"))
