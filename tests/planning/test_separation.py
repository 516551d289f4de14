"""Programs that tell effects apart: evidence, a clear message where there is none, after a diagnosis."""

from __future__ import annotations

import json

import pytest

from tests.json_schemas import objections
from tirefmu.boundary.errors import UnknownName
from tirefmu.cli import main
from tirefmu.measurements import Noise
from tirefmu.planning.bench_file import Bench, Limits, PlanError, example_text
from tirefmu.planning.separation import pairs_of, plan_between
from tirefmu.tires import published

BENCH = Bench(
    {"Fz": Limits(220.0, 1120.0, 3.0, levels=2), "alpha": Limits(-0.2, 0.2, 2.0, rate=0.14)}, Noise(), sample_rate=20.0
)


def answer(folder, confounded, explanations=((("conicity",), 0.97),)):
    published("trento_hoosier").save(folder / "base.tir")
    ranked = [{"effects": list(names), "unknown": False, "probability": p} for names, p in explanations]
    content = {
        "found": [{"effect": "conicity"}], "confounded_with": confounded, "explanations": ranked,
        "base_tire": "base.tir", "next_measurement": ["turn the tire on the rim"],
    }  # fmt: skip
    (folder / "diagnosis.json").write_text(json.dumps(content))
    return folder


def test_more_time_gives_more_evidence():
    short, long = (
        plan_between("trento_hoosier", BENCH, [("load_friction", "load_curvature")], minutes=minutes)
        for minutes in (0.6, 1.2)
    )
    assert short.program.seconds <= 36.0 < long.program.seconds <= 72.0
    pairs = list(zip(short.separations, long.separations, strict=True))
    assert {(one.effect, one.rival) for one in short.separations} == {
        ("load_friction", "load_curvature"), ("load_curvature", "load_friction"),
    }  # fmt: skip
    assert all(before.evidence < after.evidence for before, after in pairs)


def test_memory_needs_rates_and_the_program_has_them():
    result = plan_between("trento_hoosier", BENCH, [("slip_history", "conicity")], minutes=1.0)
    assert objections("plan", result.to_json()) == []
    assert result.separations[0].effect == "slip_history"
    assert result.separations[0].evidence > 5.0


def test_inseparable_effects_are_refused_with_advice():
    held = Bench({"Fz": BENCH.limits["Fz"], "alpha": BENCH.limits["alpha"]}, Noise(), sample_rate=20.0)
    with pytest.raises(PlanError, match="camber_friction"):
        plan_between("trento_hoosier", held, [("camber_friction", "load_friction")], minutes=1.0)
    with pytest.raises(UnknownName, match="did you mean conicity"):
        plan_between("trento_hoosier", held, [("conicty", "load_friction")], minutes=1.0)


def test_pairs_of_a_diagnosis(tmp_path):
    first = answer(tmp_path, {"conicity": ["load_friction", "slip_angle_zero_offset"]})
    assert pairs_of(first)[1] == [("conicity", "load_friction")]
    rivals = ((("conicity",), 0.6), (("load_friction",), 0.39), (("conicity", "heat_friction"), 0.01))
    assert pairs_of(answer(tmp_path, {}, rivals))[1] == [("conicity", "load_friction")]
    with pytest.raises(PlanError, match="turn the tire on the rim"):
        pairs_of(answer(tmp_path, {"conicity": ["slip_angle_zero_offset"]}))
    (tmp_path / "diagnosis.json").write_text("[]")
    with pytest.raises(PlanError, match="not the result of a diagnosis"):
        pairs_of(tmp_path)


def test_command_after_a_diagnosis(tmp_path, capsys):
    folder, bench = answer(tmp_path, {"conicity": ["load_friction"]}), tmp_path / "bench.toml"
    bench.write_text(example_text())
    command = ["plan", "--bench", str(bench), "--after", str(folder), "-o", str(tmp_path / "next")]
    assert main([*command, "--minutes", "1", "--json", "-", "--quiet"]) == 0
    content = json.loads(capsys.readouterr().out)
    assert {one["effect"] for one in content["separations"]} == {"conicity", "load_friction"}
    assert content["seconds"] <= 60.0
    assert main([*command, "--between", "conicity,plysteer"]) == 2
    assert "exclude each other" in capsys.readouterr().err
