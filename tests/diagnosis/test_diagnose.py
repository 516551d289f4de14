import json
import re
from dataclasses import replace
from itertools import combinations

import numpy as np
import pandas as pd
import pytest
from markupsafe import escape

import tirefmu
from tirefmu.boundary.errors import DataError, TirefmuError, UnknownName
from tirefmu.boundary.escaping import visible
from tirefmu.diagnosis import Diagnosis, diagnose
from tirefmu.diagnosis.explanations import RankedExplanation
from tirefmu.diagnosis.probing.effect_probing import Screen
from tirefmu.diagnosis.reporting import report
from tirefmu.diagnosis.reporting.effect_figures import gain_figure, memory_figure
from tirefmu.diagnosis.reporting.report import report_page
from tirefmu.diagnosis.reporting.residual_figure import residual_location_figure
from tirefmu.diagnosis.unexplained.formula_proposal import Unknown
from tirefmu.diagnosis.verdict import (
    Adequacy,
    CoefficientInterval,
    Extrapolation,
    FoundEffect,
    Identifiability,
    verdict_sentences,
)
from tirefmu.drawing import picture as drawn
from tirefmu.drawing.figure import Figure, Panel
from tirefmu.measurements import Recording
from tirefmu.symbolic.added import library
from tirefmu.tires.property_file.names import unmeasured_outputs

from ..declared_flags import declared_flags, flags
from ..hostile import EACH_PAGE, Skeleton, is_plain
from ..json_schemas import check_file
from .suite import make_case

#: A figure that is drawn at once, in place of others.
EMPTY = Figure("figure", "figure", ((Panel("x", "y"),),))


def answer(case, **more):
    return diagnose(case.table, signs=case.signs, effects=case.effects, nominal=case.nominal, **more)


def squared_error(tire, case, diagnosis):
    computed = tire.evaluate(case.test.drop(columns=["Fx", "Fy", "Mz"]), signs="adapted-sae")
    return sum(
        np.mean((computed[name] - case.test[name]) ** 2) / part["floor"] ** 2
        for name, part in diagnosis.gap["train"].items()
    )


@pytest.fixture(scope="module")
def thrust():
    case = make_case(1, ("camber_thrust",))
    return case, answer(case)


def test_the_hidden_effect_is_identified_and_reduces_the_error(thrust):
    case, diagnosis = thrust
    assert [one.effect for one in diagnosis.found] == ["camber_thrust"]
    assert diagnosis.verdict.startswith("Missing: camber_thrust")
    before, after = (squared_error(tire, case, diagnosis) for tire in (diagnosis.base_tire, diagnosis.tire))
    assert after < 0.1 * before
    assert diagnosis.found[0].channels == ("Fy",)


def test_the_saved_files_agree_with_the_result(thrust, tmp_path):
    case, diagnosis = thrust
    reported = json.loads(diagnosis.save(tmp_path).read_text())
    assert reported["found"][0]["effect"] == "camber_thrust"
    assert {"verdict", "confounded_with", "unknown", "not_identifiable", "gap", "fmu"} <= reported.keys()
    assert set(reported["gap"]) == {"train", "cv", "holdout"}
    for key, tire in (("tire", diagnosis.tire), ("base_tire", diagnosis.base_tire)):
        read = tirefmu.load(tmp_path / reported[key])
        expected, computed = (x.evaluate(case.truth, signs="adapted-sae") for x in (tire, read))
        pd.testing.assert_frame_equal(computed[["Fx", "Fy", "Mz"]], expected[["Fx", "Fy", "Mz"]], rtol=1e-9)


def test_the_saved_files_follow_their_schemas(thrust, tmp_path):
    proposed = Unknown(("T",), "friction_y, factor: ...", True, library()["temp_friction"])
    check_file("diagnosis", replace(thrust[1], unknown=(proposed,)).save(tmp_path))
    check_file("effect", tmp_path / "temp_friction.toml")
    assert (tmp_path / "temp_friction.toml").read_text(encoding="utf-8").startswith("#:schema ./tirefmu-effect")


def test_the_probabilities_are_those_of_the_explanations(thrust, tmp_path):
    case, diagnosis = thrust
    reported = json.loads(diagnosis.save(tmp_path).read_text())
    explanations, probabilities = reported["explanations"], reported["probabilities"]
    assert explanations[0]["effects"] == ["camber_thrust"]
    assert explanations[0]["unknown"] is False
    values = [one["probability"] for one in explanations]
    assert values == sorted(values, reverse=True)
    assert 0.95 <= sum(values) <= 1.0 + 1e-9
    assert reported["found"][0]["probability"] == probabilities["camber_thrust"] > 0.9
    assert {"UNKNOWN", "camber_thrust", "relax_lat", "conicity"} <= probabilities.keys()
    assert all(0.0 <= value <= 1.0 for value in probabilities.values())
    page = report_page(diagnosis, Recording(case.table, case.signs, "plain"))
    assert page.index("explanation of the recording") < page.index("<h2")


def test_the_tires_state_what_was_measured(thrust):
    case, diagnosis = thrust
    for tire in (diagnosis.base_tire, diagnosis.tire):
        assert unmeasured_outputs(tire) == set(tire.outputs) - {"Fx", "Fy", "Mz"}
        assert set(tire.ranges) <= set(case.table)
        for name, (low, high) in tire.ranges.items():
            spread = np.ptp(case.table[name])
            assert max(abs(case.table[name])) + 0.01 * spread >= max(abs(low), abs(high)), name
            assert high - low >= 0.9 * spread, name


@pytest.mark.slow
def test_the_result_does_not_depend_on_the_signs_of_the_recording(thrust):
    case, diagnosis = thrust
    turned = case.table.assign(Fy=-case.table["Fy"], Mz=-case.table["Mz"])
    other = diagnose(turned, signs="iso", effects=case.effects, nominal=case.nominal)
    assert [one.effect for one in other.found] == ["camber_thrust"]
    assert (diagnosis.signs, other.signs) == ("iso", "iso")
    assert (diagnosis.recording_signs, other.recording_signs) == ("adapted-sae", "iso")
    assert other.answer.probabilities == pytest.approx(diagnosis.answer.probabilities, abs=1e-3)
    here, there = diagnosis.found[0].coefficients["PKY6"], other.found[0].coefficients["PKY6"]
    assert there.value == pytest.approx(here.value, rel=1e-6)
    assert there.lower < there.value < there.upper
    for channel, offset in diagnosis.recording["offset"].items():
        assert other.recording["offset"][channel] == pytest.approx(offset, rel=1e-4, abs=1e-6)


@pytest.mark.slow
def test_an_offset_is_the_bench_s_only_if_the_evidence_needs_it():
    case = make_case(13, ())

    def diagnosed(offset):
        table = case.table.assign(Fy=case.table["Fy"] + offset)
        diagnosis = diagnose(
            table, signs=case.signs, effects=case.effects, nominal=case.nominal, candidates=["conicity"]
        )
        computed = diagnosis.tire.evaluate(table, signs=case.signs)["Fy"]
        return diagnosis.in_signs(case.signs).recording["offset"]["Fy"], computed

    size = np.sqrt(np.mean(case.table["Fy"] ** 2))
    (of_bench, force), (larger, same) = diagnosed(0.0), diagnosed(0.03 * size)
    absent, of_tire = diagnosed(-of_bench)
    assert larger - of_bench == pytest.approx(0.03 * size, rel=0.02)
    assert absent == 0.0
    assert max(np.sqrt(np.mean((other - force) ** 2)) for other in (same, of_tire)) < 0.001 * size


def test_an_interval_contains_what_an_offset_that_was_left_out_would_change(monkeypatch):
    """Also without any noise, which this is in addition to."""
    monkeypatch.setattr(Screen, "standard_errors", lambda screen: np.zeros(screen.tangent.shape[-1]))
    case = make_case(13, ("plysteer",))

    def diagnosed(offset):
        diagnosis = diagnose(
            case.table.assign(Fy=case.table["Fy"] + offset), signs=case.signs, effects=case.effects,
            nominal=case.nominal, candidates=["plysteer"],
        )  # fmt: skip
        (finding,) = diagnosis.found
        return diagnosis.in_signs(case.signs).recording["offset"]["Fy"], finding.coefficients["PHY1"]

    of_bench, fitted = diagnosed(0.0)
    absent, without = diagnosed(-0.6 * of_bench)  # less than the evidence needs
    assert of_bench != 0.0 == absent
    assert without.lower < fitted.value < without.upper


def test_a_diagnosis_in_another_sign_convention(thrust):
    _, diagnosis = thrust
    assert diagnosis.in_signs("iso") is diagnosis
    other = diagnosis.in_signs("adapted-sae")
    values = diagnosis.tire.in_signs("adapted-sae").values
    assert diagnosis.found[0].coefficients["PKY6"].value == pytest.approx(-values["PKY6"])
    assert other.found[0].coefficients["PKY6"].value == pytest.approx(values["PKY6"])
    assert other.found[0].coefficients["PKY6"].lower == -diagnosis.found[0].coefficients["PKY6"].upper
    turned = {channel: -1.0 if channel in ("Fy", "Mz", "My") else 1.0 for channel in diagnosis.recording["offset"]}
    for channel, sign in turned.items():
        assert other.recording["offset"][channel] == sign * diagnosis.recording["offset"][channel]
    for ours, theirs in zip(diagnosis.where, other.where, strict=True):
        assert theirs["worst"]["mean"] == turned[ours["channel"]] * ours["worst"]["mean"]
        np.testing.assert_array_equal(theirs["mean"], turned[ours["channel"]] * np.array(ours["mean"]))
    assert other.gap == diagnosis.gap
    with pytest.raises(UnknownName, match="sign convention"):
        diagnosis.in_signs("sae")


def test_the_summary_has_few_lines(thrust):
    _, diagnosis = thrust
    shown = repr(diagnosis)
    assert len(shown.splitlines()) < 10
    assert "camber_thrust" in shown
    assert "iso signs" in shown
    hostile = replace(diagnosis, sentences=("<img src=x onerror=alert(1)>",))
    assert "<img" not in hostile._repr_html_()
    assert "<td>PKY6</td>" in hostile._repr_html_()


def test_invalid_tables_and_tires_raise_an_error_with_the_parameter_name(tmp_path, thrust):
    case, _ = thrust
    case.table.head(50).to_csv(tmp_path / "short.csv", index=False)
    for path in (tmp_path / "short.csv", str(tmp_path / "short.csv")):
        with pytest.raises(DataError, match="has 50 rows: a diagnosis needs"):
            diagnose(path, signs="adapted-sae", nominal=case.nominal)
    for table in (None, [case.table], 3):
        with pytest.raises(TirefmuError, match=r"^table is .*a DataFrame or a Recording"):
            diagnose(table, nominal=case.nominal)
    with pytest.raises(TirefmuError, match=r"^tire is 3"):
        diagnose(case.table, signs=case.signs, tire=3)
    with pytest.raises(UnknownName, match="'trento_hosier': did you mean trento_hoosier"):
        diagnose(case.table, signs=case.signs, tire="trento_hosier")


def with_text(diagnosis, text):
    """Return a diagnosis and a simulation in which every text from files and users is this one."""
    unknown = Unknown((text,), text, False, None, text)
    finding = replace(diagnosis.found[0], effect=text, coefficients={text: CoefficientInterval(1.0, 0.0, 2.0)})
    left = {**diagnosis.recording, "left_aside": {text: text}}
    changed = replace(
        diagnosis, sentences=(text,), found=(finding,), confounded_with={text: {text: 0.9}}, unknown=(unknown,),
        identifiability=Identifiability({}, {text: text}, (text,)), recording=left,
    )  # fmt: skip
    rows = {"training": {"Fy": 1.0}, "holdout": {"Fy": 1.0}, "recordings": {text: {"Fy": 1.0}}}
    simulated = {when: {**rows, "difference_from_direct_evaluation": 0.0} for when in ("before", "after")}
    return changed, simulated


def page_with_text(thrust, text):
    case, diagnosis = thrust
    changed, simulated = with_text(diagnosis, text)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(report, "residual_location_figure", lambda *_: EMPTY)
        patch.setattr(drawn, "png", lambda *_: b"")
        patch.setattr(report, "gain_figure", lambda *_: EMPTY)
        return report_page(changed, Recording(case.table, case.signs, text), simulated, text)


@pytest.fixture(scope="module")
def plain_page(thrust):
    return page_with_text(thrust, "plain")


@pytest.mark.parametrize("text", EACH_PAGE)
def test_no_text_changes_the_structure_of_the_page(thrust, plain_page, text):
    pages = [plain_page, page_with_text(thrust, text)]
    # The only code is the same in both pages: it makes charts.
    contents, codes = zip(*(page.rsplit("<script>", 1) for page in pages), strict=True)
    assert codes[0] == codes[1]
    plain, shown = map(Skeleton, contents)
    assert is_plain(contents[1])
    pages[1].encode("utf-8")
    assert shown.parts == plain.parts
    assert contents[1].count("<script") == contents[1].count('<script type="application/json" class="panels">')
    assert not {"iframe", "object", "link", "a"} & {part[0] for part in shown.parts}
    assert shown.text.count(visible(text)) >= 12


def test_the_parts_of_a_recording_have_plain_names_on_the_page(thrust, monkeypatch):
    monkeypatch.setattr(report, "residual_location_figure", lambda *_: EMPTY)
    case, diagnosis = thrust
    _, simulated = with_text(diagnosis, "plain")
    page = report_page(diagnosis, Recording(case.table, case.signs, "plain"), simulated)
    for name, text in report.ROWS.items():
        assert f"<td>{text}</td>" in page
        assert f"<td>{name}</td>" not in page
    assert set(diagnosis.gap) <= set(report.ROWS)


def test_the_first_screen_has_the_next_measurement_the_picture_and_the_numbers(thrust, monkeypatch):
    """The force that the improved tire improves most; before, after and floor of each channel; the coefficients."""
    monkeypatch.setattr(report, "residual_location_figure", lambda *_: EMPTY)
    case, diagnosis = thrust
    page = report_page(diagnosis, Recording(case.table, case.signs, "plain"))
    first = page[page.index(diagnosis.headline) : page.index("<h2")]
    assert diagnosis.headline == "Missing: camber_thrust"
    assert all(f"<li>{escape(sentence)}</li>" in first for sentence in diagnosis.sentences)
    answer, _, numbers_below = first.partition("<section")
    assert f"Next measurement: {escape('; '.join(diagnosis.next_measurement) or 'none')}" in answer
    assert numbers_below.partition("<h3>")[2].startswith("What each identified effect adds")
    for channel, one in diagnosis.gap["train"].items():
        (row,) = (text for text in first.split("<tr>") if text.startswith(f"<td>{channel} ("))
        numbers = [f"{one[key]:.4g}" for key in ("before", "after", "floor")]
        assert re.findall(r'<td class="n">(\S+)</td>', row)[:3] == numbers
        assert f'">{channel}</td><td class="n">{numbers[0]}</td><td class="n">{numbers[1]}</td>' in page.replace(
            f"<td>{channel}", f'<td class="">{channel}'
        )
    value = diagnosis.found[0].coefficients["PKY6"].value
    assert f'<td>PKY6</td><td>camber_thrust</td><td class="n">{value:.4g}</td>' in first


def no_lines_coincide(figure):
    """Assert it of the panels with lines."""
    for panel in figure.panels:
        lines = [series.points[1] for series in panel.series if series.kind == "line" and series.label]
        for first, second in combinations(lines, 2):
            low, high = figure.limits(panel)[1]
            assert np.nanmax(np.abs(np.asarray(first) - np.asarray(second))) > 0.01 * (high - low)


def test_the_gain_is_drawn_over_the_input_that_the_effect_acts_through(thrust):
    """The side force that is missing without camber thrust grows with the inclination; with it nothing is missing."""
    _, diagnosis = thrust
    (panel,) = gain_figure(diagnosis).panels
    assert panel.x == "γ (deg)"
    assert panel.title.startswith("camber_thrust: F")
    without, with_it = (series.points[1] for series in panel.series)
    assert np.abs(with_it).max() < 0.2 * np.abs(without).max()
    x = panel.series[0].points[0]
    assert without[np.abs(x) < 0.5].max() < 0.5 * without.max()
    assert gain_figure(replace(diagnosis, found=())) is None


def test_no_panel_has_two_lines_that_coincide(thrust):
    _, diagnosis = thrust
    maps = [residual_location_figure(diagnosis, channel) for channel in diagnosis.time_course]
    assert len(maps) == 3
    for figure in maps:
        no_lines_coincide(figure)
    lagging = replace(
        diagnosis.tire, values={**diagnosis.tire.values, "SIGY": 2.0}, effects=diagnosis.tire.has | {"relax_lat"}
    )
    for tire in (diagnosis.tire, lagging):
        computed = (diagnosis.run.computed[0], tire.evaluate(diagnosis.rows, signs=diagnosis.recording_signs))
        figure = memory_figure(replace(diagnosis, tire=tire, run=replace(diagnosis.run, computed=computed)), "Fy")
        no_lines_coincide(figure)
    counts = [sum(series.label.startswith("tire") for series in panel.series) for panel in figure.rows[0]]
    assert counts == [1, 2]  # without memory, and with it


@pytest.mark.parametrize("text", EACH_PAGE)
def test_the_json_is_valid_for_any_text(thrust, text, tmp_path):
    def refuse(constant):
        raise AssertionError(f"{constant} is not JSON")

    reported = with_text(thrust[1], text)[0].save(tmp_path).read_text(encoding="utf-8")
    assert json.loads(reported, parse_constant=refuse)["verdict"] == text


def test_every_yes_or_no_of_the_json_is_true_or_false(thrust):
    names = declared_flags(Diagnosis, RankedExplanation, FoundEffect, Adequacy, Unknown, Extrapolation)
    numbers = Adequacy("Fy", np.float64(20.0), np.float64(10.0), "", (), np.bool_(True))  # of NumPy, as computed
    unknown = Unknown(("T",), "", False)
    reported = replace(thrust[1], unknown=(unknown,), adequacy=(*thrust[1].adequacy, numbers)).to_json()
    found = dict(flags(json.loads(json.dumps(reported)), names))
    assert [path for path, right in found.items() if not right] == []
    assert {path.rpartition("/")[2] for path in found} == {
        "added", "adequate", "memory", "delivered", "doubtful", "unknown",
    }  # fmt: skip


@pytest.mark.slow
def test_what_nothing_explains_is_in_the_verdict():
    """Friction changes slowly with time: the bench cleaned its belt twice, and recorded nothing of it."""
    case = make_case(1)
    slow = 1.0 + 0.12 * np.sin(3.0 * np.pi * case.table["t"] / case.table["t"].max())
    table = case.table.assign(Fx=slow * case.table["Fx"], Fy=slow * case.table["Fy"])
    diagnosis = diagnose(table, signs=case.signs, effects=case.effects, nominal=case.nominal, candidates=["plysteer"])
    red = [one for one in diagnosis.adequacy if one.rating == "red"]
    assert "Fx" in {one.channel for one in red}
    assert diagnosis.rating == "red"
    assert "omething is missing " in diagnosis.verdict  # also beside a finer form of the core, which takes a part of it
    assert all(f"{one.channel} (residual {one.ratio:.1f} times the noise floor" in diagnosis.verdict for one in red)
    assert [one.effect for one in diagnosis.found] == ["UNKNOWN"]
    assert set(diagnosis.found[0].channels) == {one.channel for one in red}
    assert not any(one.formula for one in diagnosis.unknown)


@pytest.mark.slow
@pytest.mark.xfail(strict=True, reason="the amplitude in Mz is 17 % too small")
def test_a_periodic_disturbance_is_in_the_verdict():
    """Of Fy, several times the noise floor, with the wheel; and of Mz, with the time."""
    case = make_case(1)
    t, distance = case.table["t"], np.cumsum(case.table["V"]) * case.table["t"].diff().median()
    size = {"Fy": 150.0, "Mz": 4.0}
    table = case.table.assign(
        Fy=case.table["Fy"] + size["Fy"] * np.sin(2.0 * np.pi * distance / 1.85),
        Mz=case.table["Mz"] + size["Mz"] * np.sin(2.0 * np.pi * t / 0.23),
    )
    diagnosis = diagnose(table, signs=case.signs, effects=case.effects, nominal=case.nominal, candidates=["plysteer"])
    (sentence,) = (one for one in diagnosis.verdict.split(". ") if one.startswith("Removed as a periodic disturbance"))
    found = re.findall(r"(\S+) N( m)? in (\w+) every (\S+) (\S+).*?, (\S+) times the noise floor", sentence)
    assert {(channel, unit) for _, _, channel, _, unit, _ in found} == {("Fy", "m"), ("Mz", "s")}
    assert len(found) == 2
    floors = {one.channel: one.floor for one in diagnosis.adequacy}
    for amplitude, _, channel, period, unit, ratio in found:
        assert float(period) == pytest.approx({"m": 1.85, "s": 0.23}[unit], rel=0.01)
        assert float(amplitude) == pytest.approx(size[channel], rel=0.1)
        assert float(ratio) == pytest.approx(float(amplitude) / floors[channel], rel=0.05)
    assert all(one.rating == "green" for one in diagnosis.adequacy)


def test_a_wave_far_below_the_noise_floor_is_not_in_the_verdict():
    wave = {"over": "t", "frequency": 0.5, "amplitude": {"Fy": 2.0}, "cosine": {"Fy": 2.0}, "sine": {"Fy": 0.0}}
    recording = {"periodic": [wave], "derived_columns": [], "ignored_columns": []}
    texts = {
        floor: verdict_sentences((), (), {}, (), [Adequacy("Fy", floor, floor, "", (), False)], {}, (), recording)
        for floor in (100.0, 1.0)
    }
    assert ["periodic" in text[-1] for text in texts.values()] == [False, True]


def test_the_verdict_has_every_explanation_that_the_page_lists_as_confounded():
    finding = FoundEffect("relax_lat", ("Fy",), {}, 1e-9, 0.5, 0.01, 0.8)
    confounded = {"relax_lat": {"relax_load": 0.71, "relax_slip": 0.95}}
    recording = {"periodic": [], "derived_columns": [], "ignored_columns": []}
    (text,) = verdict_sentences((finding,), (), confounded, (), (), {}, (), recording)
    assert text == "Missing: relax_lat (probability 50 to 90 %; confounded with relax_slip, relax_load)"


def test_a_page_unfolds_only_what_there_is(thrust):
    case, diagnosis = thrust
    recording = Recording(case.table, "adapted-sae", "bench.csv")
    pages = [report_page(replace(diagnosis, tire=tire), recording) for tire in (diagnosis.tire, diagnosis.base_tire)]
    sections = [page.split("<h2>Changed equations</h2>")[1].split("<h2>")[0] for page in pages]
    assert ["<summary>" in section for section in sections] == [True, False]
    assert "None." in sections[1]


def test_no_effect_is_identified_without_a_missing_effect():
    diagnosis = answer(make_case(13, extra=("camber_thrust",), artefacts=("outliers", "ripple", "drift")))
    assert diagnosis.found == ()
    assert diagnosis.tire.values == diagnosis.base_tire.values  # one tire, not two in a flat valley
    assert diagnosis.verdict.startswith("Nothing material is missing")
    assert diagnosis.answer.explanations[0].effects == ()
    assert diagnosis.answer.explanations[0].probability > 0.5
    assert diagnosis.detectable["temp_friction"]["Fy"] > 0.0


@pytest.mark.slow
def test_sensor_errors_are_reported_as_confounded_only():
    diagnosis = answer(make_case(21, ("plysteer",)))
    assert [one.effect for one in diagnosis.found] == ["plysteer"]
    assert "slip_angle_zero_offset" in diagnosis.confounded_with["plysteer"]
    assert any("turn the tire on the rim" in text for text in diagnosis.next_measurement)


@pytest.mark.slow
def test_what_was_not_recorded_is_not_identifiable():
    diagnosis = answer(make_case(31, ("relax_lat",), without=("T", "Fx")))
    assert [one.effect for one in diagnosis.found] == ["relax_lat"]
    assert {"temp_friction", "temp_stiffness", "relax_lon"} <= set(diagnosis.not_identifiable)
    assert "T" in diagnosis.not_identifiable["temp_friction"]
    assert diagnosis.not_identifiable["kappa_sideforce_SVyk"].startswith("cross-talk of Fx, which was not recorded")


@pytest.mark.slow
def test_a_force_that_follows_the_direction_of_slip_is_a_hysteresis():
    """Its law is another one: the rate of slip behind a lag."""
    case = make_case(41, unknown="hysteresis")
    diagnosis = answer(case)
    assert diagnosis.found[0].effect == "hysteresis_force"
    assert squared_error(diagnosis.tire, case, diagnosis) <= 1.001 * squared_error(diagnosis.base_tire, case, diagnosis)


def test_invalid_input_raises_a_clear_error():
    case = make_case(1)
    with pytest.raises(UnknownName, match="camber_thrust"):
        diagnose(case.table, signs=case.signs, effects=("camber_trust",), nominal=case.nominal)
    with pytest.raises(UnknownName, match="Fz0"):
        diagnose(case.table, signs=case.signs, nominal={"FZ": 4000.0})
    with pytest.raises(DataError, match="200"):
        diagnose(case.table.head(50), signs=case.signs, nominal=case.nominal)
    broken = case.table.copy()
    broken.loc[7:, "alpha"] = np.nan
    with pytest.raises(DataError, match="row 8: alpha"):
        diagnose(broken, signs=case.signs, nominal=case.nominal)
    with pytest.raises(DataError, match="no measured output"):
        diagnose(case.table.drop(columns=["Fx", "Fy", "Mz"]), signs=case.signs, nominal=case.nominal)
