"""The project file: what it accepts, which steps it has, what is repeated after a change, the page over all results."""

from __future__ import annotations

import json
import os
import re
from pathlib import Path

import pytest

from tests.hostile import HOSTILE, Skeleton
from tests.json_schemas import check_file
from tests.relatives import slow_but
from tirefmu.applications.project import (
    SECTIONS,
    Records,
    TimeLimitReached,
    project_text,
    read_project,
    run_limited,
    run_project,
    steps_of,
)
from tirefmu.boundary.errors import TirefmuError
from tirefmu.commands.cli import cli
from tirefmu.commands.terminal import Terminal

from .conftest import EFFECTS

#: A JSON result of each command with what a summary reads.
RESULTS = {
    "inspect": {"findings": [{"serious": True, "text": "too few loads"}]},
    "fit": {"model": "mf96", "verdict": "good", "reasons": ["one"],
            "channels": [{"recording": "a", "channel": "Fy", "rmse": 1.0, "unit": "N", "r2": None}]},
    "explore": {"bytes": 10},
    "export": {"fmi": 3, "inputs": "slip", "bytes": 2048},
    "check": {"ok": True, "channels": {"Fy": {"rmse": 1.0, "unit": "N", "r2": 0.5}},
              "statements": {"fmu": {"grade": "good", "text": "exact"}, "tire": {"grade": "good", "text": "close"}}},
    "diagnose": {"headline": "Nothing is missing", "verdict": "nothing is missing (a, b)", "found": [],
                 "adequacy": {"Fy": {"adequate": True}},
                 "gap": {"holdout": {"Fy": {"before": 2.0, "after": 1.0, "floor": None}}}},
}  # fmt: skip


@pytest.fixture
def project(tmp_path):
    """Return a project with two tables; each option of the file is given."""
    for name in ("a.csv", "b.csv"):
        (tmp_path / name).write_text(name)
    (tmp_path / "own.toml").write_text("recipe")
    text = project_text(["a.csv", "b.csv"], "mf96", {"Fz0": 220.0, "R0": 0.23}, ["load_friction"], "iso")
    text = text.replace('# recipe = "progressive"', 'recipe = "own.toml"').replace("# where", "where")
    text = text.replace("# constraints", "constraints").replace("# tolerance", "tolerance").replace("# fmi", "fmi")
    text = text.replace("[export]", 'weights = {"Fz in 1..2 N" = 2.5, "t > 3" = 0.5}\nfixed = {PCY1 = 1.3}\n\n[export]')
    (tmp_path / "tirefmu.toml").write_text(text)
    return read_project(tmp_path / "tirefmu.toml")


class Commands:
    """Stands for the commands: writes the outputs of a step, and remembers which were run."""

    def __init__(self, project, status=None):
        self.steps = {(step.command, *step.arguments): step for step in steps_of(project)}
        self.status, self.ran, self.text = status or {}, [], "output"

    def __call__(self, step):
        assert step == self.steps[(step.command, *step.arguments)]
        self.ran.append(step.name)
        for output in step.outputs:
            if output.suffix:
                output.write_text(f"{step.name} {self.text}")
            else:
                output.mkdir(exist_ok=True)
                (output / "report.html").write_text(step.name)
        step.result.write_text(json.dumps(RESULTS[step.command]))
        return self.status.get(step.name, 0)


ALL = ["inspect", "fit", "explore", "export", "check a", "check b", "diagnose a", "diagnose b"]


def repeated(project, commands, **options):
    commands.ran.clear()
    outcomes = run_project(project, commands, Terminal(quiet=True), **options)
    assert [outcome.step.name for outcome in outcomes] == ALL
    assert [outcome.step.name for outcome in outcomes if outcome.repeated] == commands.ran
    return commands.ran


def test_the_options_of_every_step_are_accepted_by_its_command(project):
    for step in steps_of(project):
        context = cli.commands[step.command].make_context(step.command, list(step.arguments))
        given = {key: value for key, value in context.params.items() if value}
        assert given["json_file"] == step.result
        if step.command == "fit":
            assert given["nominal"] == {"Fz0": 220.0, "R0": 0.23}
            assert given["effects"] == ("load_friction",)
            assert given["recipe"] == str(project.path.parent / "own.toml")
            assert given["where"] == "t > 120 and p in 70..90 kPa"
            assert given["weights"] == {"Fz in 1..2 N": 2.5, "t > 3": 0.5}
            assert given["fixed"] == {"PCY1": 1.3}


def test_only_what_has_changed_is_repeated(project):
    commands = Commands(project, {"check b": 1})
    assert repeated(project, commands) == ALL
    assert repeated(project, commands) == []
    assert repeated(project, commands, force=True) == ALL
    (project.folder / "check_a.html").unlink()
    assert repeated(project, commands) == ["check a"]
    (project.path.parent / "own.toml").write_text("another recipe")
    assert repeated(project, commands) == ["fit"]  # the same tire: nothing else depends on it
    commands.text = "another tire"
    (project.path.parent / "b.csv").write_text("more rows")
    assert repeated(project, commands) == ALL  # the data of the fit, and with it the tire
    assert repeated(project, commands) == []


def test_a_failed_check_is_remembered_and_invalid_input_stops_the_run(project, monkeypatch):
    commands = Commands(project, {"fit": 1})
    for _ in range(2):
        outcomes = run_project(project, commands, Terminal(quiet=True))
        assert [outcome.step.name for outcome in outcomes if outcome.status] == ["fit"]

    def refuse(step):
        raise TirefmuError("no rows")

    with pytest.raises(TirefmuError, match="step inspect: no rows"):
        run_project(project, refuse, Terminal(quiet=True), force=True)
    assert Records.of(project.folder).status(steps_of(project)[0]) is None
    monkeypatch.setitem(RESULTS, "fit", {**RESULTS["fit"], "interrupted": True})
    with pytest.raises(KeyboardInterrupt):
        run_project(project, commands, Terminal(quiet=True), force=True)
    monkeypatch.undo()
    assert Records.of(project.folder).status(steps_of(project)[1]) is None
    (project.folder / "run.json").write_text("[damaged")
    assert repeated(project, commands) == ALL


def test_the_page_has_what_was_run_before_an_interruption(project):
    commands = Commands(project)

    def interrupted(step):
        if step.name == stopped:
            raise KeyboardInterrupt
        return commands(step)

    stopped = "inspect"
    with pytest.raises(KeyboardInterrupt):
        run_project(project, interrupted, Terminal(quiet=True))
    page = (project.folder / "index.html").read_text(encoding="utf-8")
    assert f"Not run: {', '.join(ALL)}." in page
    stopped = "export"
    with pytest.raises(KeyboardInterrupt):
        run_project(project, interrupted, Terminal(quiet=True))
    page = (project.folder / "index.html").read_text(encoding="utf-8")
    assert 'href="./tire.tir"' in page
    assert "Not run: export, check a, check b, diagnose a, diagnose b." in page
    assert repeated(project, commands) == ALL[3:]
    assert "Not run" not in (project.folder / "index.html").read_text(encoding="utf-8")


def test_the_page_shows_the_first_picture_of_each_step(project):
    commands, data = Commands(project), "data:image/png;base64,"

    def drawing(step):
        status = commands(step)
        if step.name in ("fit", "check a"):
            step.page.write_text(f'<img alt="x" src="{data}QUJD+/="><img alt="x" src="{data}REVG">')
        if step.name == "check b":
            step.page.write_text(f'<img src="{data}QUJD&quot;"><img src="https://tire.example/a.png">')
        return status

    run_project(project, drawing, Terminal(quiet=True))
    page = (project.folder / "index.html").read_text(encoding="utf-8")
    shown = re.findall(r'<img class="thumbnail" alt="First figure of (.*?)" src="(.*?)">', page)
    assert shown == [("fit", f"{data}QUJD+/="), ("check a", f"{data}QUJD+/=")]
    assert page.count("<img") == 2


def test_each_step_begins_with_the_time_that_the_remaining_ones_took(project, capsys):
    def began(**options):
        run_project(project, commands, Terminal(), **options)
        return capsys.readouterr().err.splitlines()

    commands = Commands(project)
    assert "left" not in "".join(began())
    records = json.loads((project.folder / "run.json").read_text())
    for seconds, name in enumerate(ALL, 10):
        records[name]["seconds"] = float(seconds)
    (project.folder / "run.json").write_text(json.dumps(records))
    (project.folder / "check_a.html").unlink()
    lines = began()
    assert lines[0] == "1/8 inspect (all steps: about 14 s left)"
    assert lines[5] == "6/8 check b"  # nothing is left


def test_a_diagnosis_beyond_its_time_limit_is_stated_and_repeated(project):
    commands = Commands(project)

    def slow(step):
        if step.name == "diagnose a":
            raise TimeLimitReached("searching for missing effects: <i>")
        return commands(step)

    outcomes = run_project(project, slow, Terminal(quiet=True))
    assert [outcome.step.name for outcome in outcomes if outcome.status] == ["diagnose a"]
    page = (project.folder / "index.html").read_text(encoding="utf-8")
    assert "no answer within the time limit of 900 s" in page
    assert "last progress: searching for missing effects: &lt;i&gt;" in page
    assert "diagnosis_a/" not in page
    assert "diagnosis_b/report.html" in page
    assert repeated(project, commands) == ["diagnose a"]


def test_a_command_is_ended_at_its_time_limit(project, tmp_path):
    """Whatever it computes; its progress is reported line by line, and its error is that of the step."""
    lines = []
    with pytest.raises(TimeLimitReached):
        run_limited("example", ["-o", str(tmp_path / "x.csv")], 0.01, lines.append)
    assert not (tmp_path / "x.csv").exists()
    assert run_limited("example", ["-o", str(tmp_path / "x.csv"), "--sample-rate", "1"], 600.0, lines.append) == 0
    assert any(line.startswith("running the virtual bench") for line in lines)
    with pytest.raises(TirefmuError, match=r"^missing\.tir: no such file$"):
        run_limited("info", ["missing.tir"], 600.0, lines.append)


def test_the_page_links_to_every_result(project):
    run_project(project, Commands(project, {"fit": 1}), Terminal(quiet=True))
    page = (project.folder / "index.html").read_text(encoding="utf-8")
    assert re.search(r'<p class="verdict bad">Tire good; FMU check passed; nothing is missing', page)
    for step in steps_of(project):
        for output in step.outputs:
            file = output if output.suffix else output / "report.html"
            assert f'href="./{file.relative_to(project.folder).as_posix()}"' in page
    for text in ("too few loads", "model mf96", "data would mislead a fit", "nothing is missing (a, b)"):
        assert text in page


@pytest.mark.parametrize(
    "text", slow_but(HOSTILE[5:7], [text for text in HOSTILE if text.encode(errors="ignore").decode() == text])
)
def test_texts_of_results_do_not_change_the_page(project, monkeypatch, text):
    def page():
        run_project(project, Commands(project), Terminal(quiet=True), force=True)
        return (project.folder / "index.html").read_text(encoding="utf-8")

    monkeypatch.setitem(RESULTS, "inspect", {**RESULTS["inspect"], "findings": [{"serious": True, "text": "plain"}]})
    plain = page()
    monkeypatch.setitem(RESULTS, "inspect", {**RESULTS["inspect"], "findings": [{"serious": True, "text": text}]})
    assert Skeleton(page()).parts == Skeleton(plain).parts


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "PATH: data is missing"),
        ("[dat]\n", "PATH: unknown key 'dat': did you mean data?"),
        ('[data]\ntables = ["a.csv"]\n[fit]\nmodle = "mf61"', "unknown key 'modle' in fit: did you mean model?"),
        ('[data]\ntables = ["a.csv"]\n[export]\nconvert = ["adam"]', "in export.convert[1]: did you mean adams?"),
        ('[data]\ntables = ["a.csv"]\n[export]\ngenerate = ["../x"]', "unknown word '../x' in export.generate[1]"),
        ('[data]\ntables = ["a.csv"]\n[fit]\ncross_validate = 1', "step fit: Invalid value for '--cross-validate': 1"),
        ('[data]\ntables = ["a.csv"]\n[export]\nfmi = "9"', "PATH: step export: Invalid value for '--fmi'"),
        ('[data]\ntables = ["tirefmu.toml"]\n[output]\nfolder = "x\\u0000"', "expected a text"),
        ("[data\n", "is not TOML"),
        ("\udcff", "not a text file"),
    ],
)  # fmt: skip
def test_a_wrong_file_is_one_line(tmp_path, command, text, message):
    path = tmp_path / "tirefmu.toml"
    path.write_bytes(text.encode(errors="surrogateescape"))
    outcome = command("run", path)
    assert (outcome.status, outcome.err.count("\n")) == (2, 1)
    assert message.replace("PATH", str(path)) in outcome.err
    assert [path.name for path in tmp_path.iterdir()] == ["tirefmu.toml"]


@pytest.mark.parametrize("folder", ["../beside", "ABSOLUTE", "link", "inside/../../beside", "linked", "nested"])
def test_results_outside_the_folder_of_the_project_are_refused(tmp_path, command, folder):
    """The folder, or a result in it, may be a link that comes with the project."""
    beside, home = tmp_path / "beside", tmp_path / "home"
    for path in (beside, home, home / "linked", home / "nested" / "diagnosis_a"):
        path.mkdir(parents=True)
    (home / "link").symlink_to(beside)
    (home / "linked" / "fit.json").symlink_to(beside / "fit.json")
    (home / "nested" / "diagnosis_a" / "report.html").symlink_to(beside / "report.html")
    (home / "a.csv").write_text("alpha,Fz,Fy\n0.0,1000,0.0\n")
    text = '[data]\ntables = ["a.csv"]\n[output]\nfolder = "' + folder.replace("ABSOLUTE", beside.as_posix()) + '"'
    (home / "tirefmu.toml").write_text(text)
    outcome = command("run", home / "tirefmu.toml")
    assert (outcome.status, outcome.err.count("\n")) == (2, 1)
    assert "outside the folder of the project: --outside permits it" in outcome.err
    assert not list(beside.iterdir())
    project = read_project(home / "tirefmu.toml")
    run_project(project, Commands(project), Terminal(quiet=True), outside=True)
    assert (project.folder / "index.html").is_file()


def test_every_key_has_an_option_of_its_command():
    commands = {"data": "fit"}
    for section, keys in SECTIONS.items():
        options = {
            option
            for parameter in cli.commands.get(commands.get(section, section), cli).params
            for option in parameter.opts
        }
        assert {key.option for key in keys.values() if key.option} <= options


@pytest.mark.parametrize("converted", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_init_and_run(command, bench_csv, tmp_path, converted):
    """A new project runs as it is; a second run repeats nothing. MF96 is converted by a fit of another model."""
    path = tmp_path / "tirefmu.toml"
    arguments = ("init", bench_csv, "--model", "mf96", "--nominal", "Fz0=220,R0=0.23", "--effects", EFFECTS, "-o", path)
    assert command(*arguments).status == 0
    assert command(*arguments).err.count("exists already") == 1
    text = path.read_text().replace(
        '# convert = ["adams"]  # property files; generate', f'{"" if converted else "# "}convert = ["adams"]\ngenerate'
    )
    path.write_text(text.replace("]: code", "]  # code").replace("run = true", "run = false"))
    first = command("run", path)
    begun = [line.split(maxsplit=1)[1] for line in first.err.splitlines() if re.match(r"\d/[67] ", line)]
    conversion = ["convert adams"] if converted else []
    steps = ["inspect", "fit", "explore", "export", *conversion, "generate cpp", "check bench"]
    assert begun == steps
    (tmp_path / "direct").mkdir()
    for arguments in (*[("convert", "--for", "adams")][: len(conversion)], ("generate", "--language", "cpp")):
        written, output = {"convert": "tire_adams.tir", "generate": "code_cpp"}[arguments[0]], tmp_path / "direct"
        assert command(*arguments, tmp_path / "results" / "tire.tir", "-o", output / written).status == 0
        for file in filter(Path.is_file, [output / written, *(output / written).rglob("*")]):
            assert file.read_bytes() == (tmp_path / "results" / file.relative_to(output)).read_bytes()
    assert "; stage 2 of " in first.err  # what a fit reports
    assert command("run", path, "--quiet", "--force", "--only", "inspect").err == ""
    assert first.status in (0, 1)
    check_file("run", tmp_path / "results" / "run.json")
    second = command("run", path, "--json", tmp_path / "run.json")
    assert second.status == first.status
    summary = json.loads((tmp_path / "run.json").read_text())
    assert [step["name"] for step in summary["steps"]] == steps
    assert not any(step["repeated"] for step in summary["steps"])
    assert summary["ok"] is (first.status == 0)
    page = Path(summary["index"]).read_text(encoding="utf-8")
    assert "RMSE" in page
    for link in [part.split('"')[0] for part in page.split('href="')[1:]]:
        assert os.path.exists(tmp_path / "results" / link)


def test_some_steps_are_run_with_those_that_they_need(project):
    commands = Commands(project)
    outcomes = run_project(project, commands, Terminal(quiet=True), only=("check",))
    assert commands.ran == ["fit", "export", "check a", "check b"]
    assert [outcome.step.name for outcome in outcomes] == commands.ran
    page = (project.folder / "index.html").read_text(encoding="utf-8")
    assert "Not run: inspect, explore, diagnose a, diagnose b." in page
    commands.ran.clear()
    outcomes = run_project(project, commands, Terminal(quiet=True), only=("inspect",), force=True)
    assert commands.ran == ["inspect"]
    assert [outcome.step.name for outcome in outcomes] == ["inspect", "fit", "export", "check a", "check b"]
    assert repeated(project, commands) == ["explore", "diagnose a", "diagnose b"]
    commands.ran.clear()
    commands.text = "another tire"
    outcomes = run_project(project, commands, Terminal(quiet=True), only=("fit",), force=True)
    assert commands.ran == ["fit"]
    assert [outcome.step.name for outcome in outcomes] == ["inspect", "fit"]  # the others were up to date before


def test_excluded_rows_are_in_no_step_and_held_out_rows_not_in_the_fit(project):
    text = project.path.read_text().replace(
        "[fit]", 'exclude = ["sample in 1..9", "t > 5"]\n[fit]\nhold_out = ["p > 3"]'
    )
    rows = "(t > 120 and p in 70..90 kPa\n) and not (sample in 1..9) and not (t > 5)"

    def where(text):
        project.path.write_text(text)
        return {step.command: step.arguments[step.arguments.index("--where") + 1]
                for step in steps_of(read_project(project.path)) if "--where" in step.arguments}  # fmt: skip

    found = where(text)
    assert found.pop("fit") == f"{rows} and not (p > 3)"
    assert set(found) == {"inspect", "explore", "export", "check", "diagnose"}
    assert set(found.values()) == {rows}
    (project.path.parent / "own.where").write_text("alpha > 0 # steady")
    own = re.sub('where = ".*"', 'where = "own.where"', text)
    assert where(own)["inspect"].startswith("(alpha > 0 # steady\n) and not (sample")
    assert where(re.sub("where = .*", "", text))["fit"] == "not (sample in 1..9) and not (t > 5) and not (p > 3)"


def test_columns_and_units_are_options_of_every_step_that_reads_tables(tmp_path):
    path = tmp_path / "p.toml"
    path.write_text('[data]\ntables = ["a.csv"]\ncolumns = {Fy = "FYC", alpha = "-SA"}\nunits = {Fz = "lbf"}\n')
    project = read_project(path)
    assert project.options("data") == ["--columns", "Fy=FYC,alpha=-SA", "--units", "Fz=lbf"]
    for step in steps_of(project):
        assert ("--columns" in step.arguments) == (step.command in ("inspect", "fit", "explore", "check", "diagnose") or
                                                   "--proof" in step.arguments)  # fmt: skip
    path.write_text('[data]\ntables = ["a.csv"]\ncolumns = ["Fy"]\n')
    with pytest.raises(TirefmuError, match=r"columns is .*: expected a table of texts"):
        read_project(path)
