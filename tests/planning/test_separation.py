"""Programs that tell effects apart: evidence, a clear message where there is none, after a diagnosis."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest

from tests.json_schemas import objections
from tirefmu.applications.planning import Bench, Limits, PlanError, example_text, pairs_of, plan_between
from tirefmu.boundary.errors import UnknownName
from tirefmu.commands.cli import main
from tirefmu.measurements import Noise, VirtualBench, alpha_sweeps, concatenate, write_table
from tirefmu.tires import published, read_tir

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
    assert {(separation.effect, separation.rival) for separation in short.separations} == {
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
    result = plan_between(
        "trento_hoosier", held, [("camber_friction", "load_friction"), ("load_friction", "load_curvature")], minutes=1.0
    )
    assert list(result.undetermined) == ["camber_friction or load_friction"]
    assert result.separations[-1].evidence > 5.0
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


@pytest.mark.slow
def test_command_after_a_diagnosis(tmp_path, capsys):
    folder, bench = answer(tmp_path, {"conicity": ["load_friction"]}), tmp_path / "bench.toml"
    bench.write_text(example_text())
    command = ["plan", "--bench", str(bench), "--after", str(folder), "-o", str(tmp_path / "next")]
    assert main([*command, "--minutes", "1", "--json", "-", "--quiet"]) == 0
    content = json.loads(capsys.readouterr().out)
    assert {separation["effect"] for separation in content["separations"]} == {"conicity", "load_friction"}
    assert content["seconds"] <= 60.0
    assert main([*command, "--between", "conicity,plysteer"]) == 2
    assert "exclude each other" in capsys.readouterr().err


CHAIN_BENCH = """
sample_rate = 20.0
[Fz]
low = 2000.0
high = 6000.0
[alpha]
low = "-10 deg"
high = "10 deg"
rate = "8 deg"
[p]
low = "180 kPa"
high = "260 kPa"
levels = 2
"""


@pytest.mark.slow
def test_the_documented_chain_ends_with_the_effect(tmp_path):
    """Load and pressure change together in the first recording, so that it does not tell their effects apart."""
    golden = read_tir("tests/golden/MagicFormula61_Parameters.tir")
    truth = replace(golden, effects={"camber_thrust", "pressure_friction"}, values={**golden.values, "PPY3": -0.3})
    replace(truth, effects={"camber_thrust"}).save(tmp_path / "base.tir")
    truth.save(tmp_path / "truth.tir")
    conditions = [(2000.0, 180e3), (6000.0, 260e3)]
    sweeps = [alpha_sweeps([load], sample_rate=25.0, held={"p": p, "V": 11.0}) for load, p in conditions]
    write_table(VirtualBench(truth, seed=1).run(concatenate(sweeps)).with_signs("iso").table, tmp_path / "bench.csv")
    (tmp_path / "bench.toml").write_text(CHAIN_BENCH)
    chain = (
        "diagnose bench.csv --tire base.tir --candidates load_friction,pressure_friction --no-fmu -o answer",
        "plan --bench bench.toml --after answer -o next",
        "example --tire truth.tir --program next/program.csv --bench bench.toml -o next.csv",
        "diagnose next.csv --tire base.tir --candidates load_friction,pressure_friction --no-fmu -o answer2",
    )
    files = {path.name for path in tmp_path.iterdir()} | {"answer", "next", "next.csv", "answer2", "next/program.csv"}
    for command in chain:
        words = [str(tmp_path / word) if word in files else word for word in command.split()]
        assert main([*words, "--quiet"]) in (0, 1), command
    first, second = (json.loads((tmp_path / name / "diagnosis.json").read_text()) for name in ("answer", "answer2"))
    assert "pressure_friction" in {name for pair in pairs_of(tmp_path / "answer")[1] for name in pair}
    assert first["explanations"][0]["probability"] < 0.99 or first["confounded_with"]
    assert second["explanations"][0]["effects"] == ["pressure_friction"]
