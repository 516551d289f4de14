"""The score: a perfect answer, an empty one, a wrong one; wrong files are refused in one line."""

from __future__ import annotations

import json
import sys

import numpy as np
import pandas as pd
import pytest
from missing_effects.answers import UNKNOWN, Answer, Case, read_answer, read_cases, write_answer
from missing_effects.command import main
from missing_effects.entries import ENTRIES, NEED_EXTRA, answer_of
from missing_effects.entries.problem import channels_of
from missing_effects.generator.cases import made
from missing_effects.generator.draws import Draws
from missing_effects.generator.systems import SYSTEMS
from missing_effects.score import calibration_error, outcome, scores, summary

from tirefmu.boundary.errors import DataError, TirefmuError


@pytest.fixture(scope="module")
def cases():
    return list(made(4))


def perfect(case):
    names = (UNKNOWN,) if case.truth.kind == "unknown" else case.truth.hidden
    return Answer(names, dict.fromkeys(names, 1.0), case.truth.variables, pd.DataFrame(dict(case.truth.forces)))


def test_a_perfect_answer_has_a_perfect_score(cases):
    found = scores([outcome(case, perfect(case)) for case in cases])
    assert {tier: score["cases"] for tier, score in found.items()} == {"tires": 24, "systems": 6}
    for score in found.values():
        assert score["exact"] == score["named"]
        assert score["unknown_found"] == score["variables"] == score["unknown"]
        assert score["extra"] == score["false_names"] == score["false_unknown"] == score["failed"] == 0
        assert score["brier"] == score["calibration"] == 0.0
        assert score["closed"] == score["least_closed"] == 1.0


def test_nothing_as_an_answer_closes_nothing_and_names_nothing(cases):
    found = summary([outcome(case, Answer(failed="no method")) for case in cases])
    hidden = sum(len(perfect(case).found) for case in cases)
    assert found["brier"] == hidden / len(cases)
    assert found["exact"] == found["closed"] == found["false_names"] == 0
    assert found["failed"] == len(cases)


def test_a_false_name_counts_in_nulls_and_with_right_names(cases):
    wrong = [outcome(case, Answer((*perfect(case).found, "load_lag"), {"load_lag": 1.0})) for case in cases]
    found = summary(wrong)
    assert found["false_names"] == found["nulls"]
    assert found["extra"] == found["named"]
    assert found["exact"] == found["unknown_found"] == found["false_unknown"] == 0


def test_variables_of_an_unknown_effect_are_right_from_half_of_the_union(cases):
    case = next(case for case in cases if case.truth.kind == "unknown" and len(case.truth.variables) == 3)
    first, second, third = case.truth.variables

    def right(*reported, found=(UNKNOWN,)):
        return outcome(case, Answer(found, variables=reported)).variables

    assert right(first, second, third)
    assert right(first, second, "other")
    assert not right(first, "other")
    assert not right(first, second, third, "a", "b", "c", "d")
    assert not right(first, second, third, found=("conicity",))


def test_calibration_error_is_small_for_frequencies_and_does_not_depend_on_order():
    claims = [(0.25, True), (0.25, False), (0.25, False), (0.25, False), (1.0, True)]
    assert calibration_error(claims) == calibration_error(claims[::-1]) == 0.0
    assert calibration_error([(0.9, False)]) == pytest.approx(0.9)
    assert calibration_error([]) == 0.0


@pytest.fixture
def answers(tmp_path, cases):
    case = cases[0]
    write_answer(tmp_path, "mine", case.name, perfect(case))
    return tmp_path, case


def test_an_answer_is_read_as_it_was_written(answers):
    folder, case = answers
    found = read_answer(folder, case.name, list(case.about["channels"]), len(case.other["t"]))
    written = perfect(case)
    assert (found.found, found.probabilities) == (written.found, written.probabilities)
    assert np.allclose(found.forces, written.forces, rtol=1e-5, atol=1e-4)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"probabilities": {"conicity": 1.5}}, "probabilities.conicity is 1.5: expected a number"),
        ({"found": ["a", "a"]}, "found is ['a', 'a']: expected a list of at most 100 different texts"),
        ({"extra": 1}, "unknown key 'extra'"),
        ({"case": "tire_24"}, "is the answer to tire_24"),
        ({"version": 2}, "version is 2: expected 1"),
    ],
)
def test_an_answer_that_contradicts_the_schema_is_refused(answers, change, message):
    folder, case = answers
    path = folder / f"{case.name}.json"
    path.write_text(json.dumps({**json.loads(path.read_text()), **change}))
    with pytest.raises(DataError) as error:
        read_answer(folder, case.name, list(case.about["channels"]), len(case.other["t"]))
    assert message in str(error.value)
    assert str(path) in str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("text", "message"),
    [("Fx,Fy\n1,2\n", "no column Mz"), ("Fx,Fy,Mz\n1,2,3\n", "needs a number in each of 1500 rows"),
     ("Fx,Fy,Mz\n" + "1,2,inf\n" * 1500, "needs a number"), ("", "is not CSV")],
)  # fmt: skip
def test_forces_that_are_not_numbers_for_each_row_are_refused(answers, text, message):
    folder, case = answers
    (folder / f"{case.name}.csv").write_text(text)
    with pytest.raises(DataError, match=message):
        read_answer(folder, case.name, list(case.about["channels"]), len(case.other["t"]))


def case_of(name, hidden):
    """Return a case of a system with strong hidden effects."""
    system = SYSTEMS[name]
    tables = []
    for other in (False, True):
        x = system.program(Draws(11, other), other)
        tables.append((x, system.outputs(np.array([high for _, high in system.values]), x, hidden)))
    (x, y), (at, true) = tables
    rng = np.random.default_rng(5)
    noisy = {key: values + 0.008 * np.std(values) * rng.standard_normal(len(values)) for key, values in y.items()}
    candidates = {key: text for key, (text, _) in system.effects.items()}
    about = {"system": name, "channels": system.channels, "base": system.base, "candidates": candidates}
    return Case(about, pd.DataFrame({**x, **noisy}), pd.DataFrame(at)), true


@pytest.mark.parametrize(
    ("name", "hidden"),
    [
        ("bouc_wen", "cubic_stiffness"),
        ("drive", "cogging"),
        ("two_tanks", "leak"),
        ("drive", ""),
        ("bouc_wen", UNKNOWN),
    ],
)
def test_the_evidence_of_the_diagnosis_explains_systems_that_are_not_tires(name, hidden):
    case, true = case_of(name, {hidden: 0.5} if hidden else {})
    answer = answer_of("diagnosis", case)
    assert answer.failed == ""
    assert answer.found == ((hidden,) if hidden else ())
    assert set(answer.probabilities) == {*case.about["candidates"], UNKNOWN}
    for channel, force in true.items():
        assert np.std(answer.forces[channel] - force) < 0.05 * np.std(force)


@pytest.mark.parametrize("entry", [name for name in ENTRIES if name != "diagnosis"])
def test_every_entry_answers(entry):
    if entry in NEED_EXTRA:
        pytest.importorskip("sklearn")
        pytest.importorskip("pysindy")
    case, _ = case_of("bouc_wen", {"coulomb_friction": 0.5})
    answer = answer_of(entry, case)
    assert answer.failed == ""
    assert len(answer.forces) == len(case.other)
    assert all(0.0 <= value <= 1.0 for value in answer.probabilities.values())
    if entry not in ("baseline", "gaussian_process"):
        assert "coulomb_friction" in answer.found


@pytest.mark.parametrize("name", SYSTEMS)
def test_projected_residual_and_features_have_nothing_that_the_base_explains(name):
    for channel in channels_of(case_of(name, {})[0]).values():
        base = channel.base[: len(channel.y)] / np.linalg.norm(channel.base[: len(channel.y)], axis=0)
        for projected in channel.projected:
            assert np.abs(base.T @ projected).max() < 1e-9 * np.linalg.norm(channel.y / channel.noise)


def test_an_entry_without_its_packages_names_the_extra(monkeypatch):
    case, _ = case_of("drive", {})
    monkeypatch.setitem(sys.modules, "sklearn.linear_model", None)
    monkeypatch.delitem(sys.modules, "missing_effects.entries.stability", raising=False)
    with pytest.raises(TirefmuError, match=r"pip install 'missing-effects\[regressions\]'"):
        answer_of("stability", case)


def test_a_method_that_raises_an_error_has_no_answer():
    case, _ = case_of("drive", {})
    answer = answer_of("stepwise", Case(case.about, case.recording.iloc[:0], case.other))
    assert answer.failed
    assert answer.forces is None


def test_command_writes_recordings_runs_an_entry_and_scores_answers(tmp_path, capsys):
    folder, json_file = tmp_path / "recordings", tmp_path / "score.json"
    assert main(["-o", str(folder), "--seed", "2", "--quiet"]) == 0
    assert len(read_cases(folder)) == 30
    only = ["--only", "system_01,system_02", "--json", str(json_file)]
    assert main(["-o", str(folder), "--entry", "stepwise", *only]) == 0  # finds the seed by its digest
    first = json.loads(json_file.read_text())["scores"]
    assert main(["--score", str(folder / "answers" / "stepwise"), "--seed", "2", *only]) == 0
    assert json.loads(json_file.read_text())["scores"] == first
    assert "systems" in capsys.readouterr().out
    assert main(["--score", str(folder / "answers" / "stepwise"), "--seed", "2"]) == 2
    assert "tire_01.json" in capsys.readouterr().err
    assert main(["-o", str(folder), "--entry", "stepwise", "--only", "tire_99"]) == 2
    assert "unknown recording 'tire_99'" in capsys.readouterr().err
