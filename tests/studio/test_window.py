"""Messages of the page: what they show is what the files and commands have; whatever is malformed has an answer."""

from __future__ import annotations

import json
import random

import numpy as np
import pytest

from tirefmu.applications.project import Records, steps_of
from tirefmu.commands.cli import main
from tirefmu.fitting import fit
from tirefmu.measurements import predicted_outputs, recording_from, write_table
from tirefmu.tires import published, read_tir

from .conftest import ORIGIN, SOCKET, TOKEN, Page

pytest.importorskip("starlette", reason="the extra studio is not installed")
from tirefmu.applications.studio import recording_of


def test_the_tables_are_shown_with_the_state_of_each_row(window):
    page = window.page
    rows = len(recording_from(window.state.folder / "run.csv"))
    (table,) = page.result("data")
    assert table["counts"] == {"fitted": rows}
    assert sum(cell["rows"] for cell in table["grid"]) == rows
    page.edit("rows", table=0, first=11, last=20, how="exclude")
    page.edit("rows", table=0, first=16, last=30, how="hold_out")
    (table,) = page.result("data")
    assert table["counts"] == {"fitted": rows - 20, "excluded by the project": 10, "held out": 10}
    cell = table["grid"][1]
    page.edit("set", section="data", key="exclude", value=[cell["expression"]])
    (table,) = page.result("data")
    again = next(entry for entry in table["grid"] if entry["expression"] == cell["expression"])
    assert again["excluded"] == cell["rows"]
    assert table["counts"]["excluded by the project"] == cell["rows"]
    page.edit("set", section="fit", key="hold_out", value=None)
    page.edit("rows", table=0, first=1, last=100, how="keep")
    assert page.result("state")["sections"]["data"]["exclude"][-1] == 'file == "run.csv" and sample not in 1..100'
    for _ in range(5):
        page.edit("undo")
    assert page.result("data")[0]["counts"] == {"fitted": rows}


def test_the_example_is_added_as_a_table_that_can_be_fitted(window):
    assert window.page.result("example") is None
    table = window.page.result("data")[-1]
    assert table["name"] == "example.csv"
    assert set(table["counts"]) == {"fitted"}
    assert "exists already" in window.page.edit("example")["error"]


def test_a_table_that_cannot_be_read_has_its_error_and_can_be_removed(window):
    answer = window.client.post(f"/{TOKEN}/upload/bad.csv", content=b"alpha,Fz\nx,y\n", headers={"origin": ORIGIN})
    assert (answer.status_code, answer.text) == (200, "bad.csv")
    good, bad = window.page.result("data")
    assert "error" not in good
    assert "bad.csv: line 2" in bad["error"]
    assert window.page.edit("tables", tables=["run.csv"])["result"] is None
    assert len(window.page.result("data")) == 1


def test_a_wrong_unit_is_refused_with_a_correction_that_the_project_file_has(window):
    """The advice of the refusal, applied, is the reading of the right table; the table shows it."""
    path = window.state.folder / "run.csv"
    right = recording_from(path).table
    table = right.assign(Fz=right["Fz"] / 4.4482216152605)
    write_table(table, path)
    (shown,) = window.page.result("data")
    assert any("Fz is in lbf" in finding["text"] and finding["serious"] for finding in shown["findings"])
    correction = {offer["text"]: offer for offer in shown["corrections"]}["Fz is in lbf"]
    assert correction["keys"] == {"units": {"Fz": "lbf"}}
    window.page.edit("correct", keys=correction["keys"])
    assert 'units = {Fz = "lbf"}' in window.state.text()
    (shown,) = window.page.result("data")
    assert not [finding for finding in shown["findings"] if finding["serious"]]
    assert shown["corrections"] == []
    meanings = {meaning["channel"]: meaning for meaning in shown["meanings"]}
    assert (meanings["Fz"]["taken_for"], meanings["Fz"]["unit"]) == ("wheel load, lbf", "lbf")
    read = recording_of(path, window.state.project()).table["Fz"]
    np.testing.assert_allclose(read, right["Fz"], rtol=1e-9)


def test_columns_and_signs_are_corrected_together(window):
    """Corrections of a table that has another correction already are composed with it."""
    path = window.state.folder / "run.csv"
    right = recording_from(path).table
    write_table(right.rename(columns={"Fy": "FYC", "Mz": "MZC"}).assign(MZC=-right["Mz"]), path)
    assert "Fy" not in window.page.result("data")[0].get("channels", ())
    window.page.edit("correct", keys={"columns": {"Fy": "FYC", "Mz": "MZC"}})
    (shown,) = window.page.result("data")
    (correction,) = shown["corrections"]
    assert correction["keys"]["columns"] == {"Fy": "FYC", "Mz": "-MZC"}
    window.page.edit("correct", keys=correction["keys"])
    assert not window.page.result("data")[0]["corrections"]
    read = recording_of(path, window.state.project()).table
    for name in ("Fy", "Mz"):
        np.testing.assert_array_equal(read[name], right[name])
    text = window.state.text()
    for keys in ({"units": {"Fz": "m"}}, {"units": {"F": "N"}}, {"columns": {"Fy": "-"}}, {"tables": ["/etc/passwd"]},
                 {"columns": {"Fy": "a,Fz=b"}}, {"signs": 3}, {"nothing": "x"}):  # fmt: skip
        assert window.page.edit("correct", keys=keys)["error"], keys
    assert window.state.text() == text


def test_uploads_are_new_files_of_known_kinds_in_the_folder(window):
    def upload(name, content=b"alpha,Fz,Fy\n0.1,900,-3\n"):
        return window.client.post(f"/{TOKEN}/upload/{name}", content=content, headers={"origin": ORIGIN})

    for name in ("run.csv", "tirefmu.toml", "x.py", "x", "..%2F..%2Frun.csv"):
        answer = upload(name)
        assert answer.status_code in (400, 404), name
    assert upload("..%5C%3Cb%3E.csv").text == "b_.csv"
    names = {path.name for path in window.state.folder.iterdir()}
    assert names == {"b_.csv", "run.csv", "studio", "tirefmu.toml"}
    assert not list((window.state.folder / "studio").glob("*.part"))


def test_an_upload_has_a_limit(window, monkeypatch):
    monkeypatch.setattr("tirefmu.applications.studio.serve.MAX_UPLOAD", 100)
    answer = window.client.post(f"/{TOKEN}/upload/a.csv", content=b"1" * 101, headers={"origin": ORIGIN})
    assert (answer.status_code, "larger than" in answer.text) == (400, True)
    assert not (window.state.folder / "a.csv").exists()


def test_a_stale_change_of_a_second_page_is_refused(window):
    version = window.page.result("state")["version"]
    with window.client.websocket_connect(SOCKET, headers={"origin": ORIGIN}) as socket:
        second = Page(socket)
        assert second.edit("set", section="fit", key="model", value="mf61")["result"] is None
        answer = window.page.call("set", section="fit", key="model", value="mf52", version=version)
        assert answer["stale"]
        assert {"event": "changed"} in window.page.events
        assert window.page.result("state") == second.result("state")
        assert second.result("state")["sections"]["fit"]["model"] == "mf61"


def test_errors_of_sliders_are_those_of_python(window):
    page = window.page
    tire = page.result("tire", tire="live")
    values = {coefficient["name"]: coefficient["value"] for coefficient in tire["coefficients"]}
    effects = [effect["name"] for effect in tire["effects"] if effect["on"]]
    for change in ({}, {"PDY1": values["PDY1"] * 1.1}):
        content = {"tire": "live", "model": "mf96", "effects": effects, "values": values | change}
        found = page.result("errors", condition=0, **content)
        assert page.edit("start_from", **content)["result"] is None
        started = read_tir(window.state.folder / "start.tir")
        assert started.values["PDY1"] == values["PDY1"] * (1.1 if change else 1.0)
        recording = recording_from(window.state.folder / "run.csv").with_signs("iso")
        computed = predicted_outputs(started, recording)
        for name, each in found.items():
            error = (recording.table[name] - computed[name]).to_numpy()
            assert each["all"]["rows"] == len(recording)
            assert each["all"]["rmse"] == pytest.approx(np.sqrt(np.mean(error**2)), rel=1e-9)
    assert page.result("state")["sections"]["fit"]["start"] == "start.tir"
    assert page.call("errors", condition=0, **{**content, "values": {"NONE": 1.0}})["error"]
    assert page.call("errors", condition=0, **{**content, "model": "mf61"})["error"]


def test_a_rejected_effect_is_no_candidate_of_the_next_diagnosis(window):
    assert "no fitted tire" in window.page.edit("reject", effect="temp_friction")["error"]
    (window.state.folder / "results").mkdir()
    published("trento_hoosier").save(window.state.folder / "results" / "tire.tir")
    assert window.page.edit("reject", effect="nothing")["error"]
    for effect in ("temp_friction", "heat_friction"):
        assert window.page.edit("reject", effect=effect)["result"] is None
    tested = window.page.result("state")["sections"]["diagnose"]["candidates"]
    assert not {"temp_friction", "heat_friction"} & set(tested)
    assert "wear_drift" in tested


def test_code_of_a_tire_is_served_by_its_digest(window):
    tire = window.page.result("tire", tire="live")
    answer = window.client.get(f"/{TOKEN}/code/{tire['code']}.js")
    assert answer.text.startswith("export default (() =>")
    assert "javascript" in answer.headers["content-type"]


@pytest.mark.parametrize(
    "text",
    ["", "[", "3", "null", "[1]", "{}", '{"do": 3}', '{"do": "__init__"}', '{"do": "state_"}', "[" * 100_000,
     '{"do": "set"}', '{"do": "errors", "values": {}}'],
)  # fmt: skip
def test_a_malformed_message_has_an_error(window, text):
    window.page.websocket.send_text(text)
    answer = window.page.websocket.receive_json()
    assert answer["error"]
    assert "internal" not in answer["error"]


def test_a_thousand_malformed_messages_change_nothing(window):
    """Random values for every argument of every action: an answer each, no internal error."""
    rng = random.Random(1)
    before = window.state.text()
    odd = [None, True, -1, 0, 2**70, 1e308, "", "x", "a\0b", "../x", "/etc/passwd", [], [[]], ["x"], [1], {},
           {"a": "b"}, {"a": 1.0}, "\ud800", "live", "result", "9" * 5000]  # fmt: skip
    names = ["version", "section", "key", "value", "tables", "table", "first", "last", "how", "channel", "tire",
             "model", "effects", "values", "keys", "condition", "steps", "fit", "text", "id"]  # fmt: skip
    actions = [action for action in window.server.window._actions if action not in ("run", "stop", "example")]
    for _ in range(1000):
        message = {name: rng.choice(odd) for name in rng.sample(names, rng.randrange(len(names)))}
        message["do"] = rng.choice([*actions, *odd])
        window.page.websocket.send_text(json.dumps(message))
        answer = window.page.websocket.receive_json()
        assert "internal" not in answer.get("error", ""), (message, answer)
    window.page.websocket.send_bytes(b"\xff\x00")
    assert window.page.websocket.receive_json()["error"]
    assert window.state.text() == before


def test_the_step_that_the_window_runs_is_that_of_the_command(window, monkeypatch, tmp_path):
    """`tirefmu run` afterwards finds the window's results up to date."""
    started = {}

    async def start(title, arguments, tire_file):
        started[title] = arguments

    monkeypatch.setattr(window.server.window.work, "start", start)
    window.page.result("run", steps=["inspect"])
    assert main([*started["inspect"], "--quiet"]) == 0
    (inspect, *others) = window.page.result("state")["steps"]
    assert (inspect["status"], inspect["headline"]) == (0, "data ready for a fit")
    assert [step["status"] for step in others] == [None] * len(others)
    assert [step["name"] for step in (inspect, *others)] == [step.name for step in steps_of(window.state.project())]
    assert window.page.call("run", steps=["rm"])["error"]


def test_property_files_and_code_are_steps_of_the_project(window):
    """The page offers what the commands write; a choice is a line of the project file; their files are listed."""
    page = window.page
    exports = page.result("choices")["exports"]
    assert ("adams" in exports["convert"], "cpp" in exports["generate"]) == (True, True)
    for key, name in (("convert", "adams"), ("generate", "cpp")):
        assert page.edit("set", section="export", key=key, value=[name])["result"] is None
        assert page.edit("set", section="export", key=key, value=["../x"])["error"]
    assert 'convert = ["adams"]' in window.state.text()
    results = window.state.folder / "results"
    results.mkdir()
    published("trento_hoosier").save(results / "tire.tir")
    records = Records.of(window.state.project().folder)
    for step in steps_of(window.state.project()):
        if step.command in ("convert", "generate"):
            records.add(step, main([step.command, *step.arguments]), 0.0)
        elif step.command == "fit":  # the tire is that of the fit
            for path in step.outputs:
                path.touch()
            records.add(step, 0, 0.0)
    shown = {step["command"]: step for step in page.result("state")["steps"]}
    assert shown["convert"]["files"] == ["convert_adams.json", "tire_adams.tir"]
    assert {"generate_cpp.json"} < set(shown["generate"]["files"])
    assert (shown["convert"]["headline"], shown["generate"]["headline"]) == (
        "property file, model mf52", "code in cpp")  # fmt: skip
    for name in shown["generate"]["files"]:
        assert window.client.get(f"/{TOKEN}/results/{name}").status_code == 200


def test_a_kept_fit_is_shown_with_its_verdict_and_errors(window, bench_file):
    result = fit(bench_file, "mf96", effects=[], recipe="joint", iterations=1)
    results = window.state.folder / "results"
    results.mkdir()
    result.tire.save(results / "tire.tir")
    (results / "fit.json").write_text(json.dumps(result.to_json()))
    fits = window.server.window.fits
    assert fits.keep(results, window.state.text()) == 1
    assert fits.keep(results, window.state.text()) is None  # the latest one is kept once
    (shown,) = window.page.result("state")["fits"]
    assert (shown["model"], shown["verdict"]) == ("mf96", result.verdict.word)
    assert [channel["fitted_rmse"] for channel in shown["channels"]] == [c.fitted_rmse for c in result.channels]
