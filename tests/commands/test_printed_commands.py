"""Every command that a command prints is accepted as printed; those that end quickly are run."""

from __future__ import annotations

import ast
import json
import re
import shlex
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from tirefmu.boundary.errors import LISTED_BY
from tirefmu.commands.arguments import TableOptions
from tirefmu.commands.cli import cli
from tirefmu.commands.diagnose_command import _next_command
from tirefmu.commands.fit_command import _testable
from tirefmu.measurements import Recording
from tirefmu.tires import published

from ..rooms import ROOMS, ROOT

#: A name that a shell would not leave alone.
HOSTILE = "run ;'$(b) 1.csv"
#: Sentences about a command.
SENTENCES = (
    "tirefmu effects NAME describes one",
    "tirefmu schema KIND writes one",
    "tirefmu info NAME shows source, ranges and coefficients",
    "tirefmu effects lists them",
    "tirefmu init in a terminal",
    "tirefmu run: inspects the data, fits, exports, checks, diagnoses; redoes what has changed.",
)


def accepted(line):
    """Return the command and its parsed options; raise if the command does not accept the line."""
    program, name, *arguments = shlex.split(line)
    assert program == "tirefmu"
    return name, cli.commands[name].make_context(name, arguments).params


def texts_of(path):
    """Yield the strings of a module that are no docstrings."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    statements = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
    for node in ast.walk(tree):
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in statements:
            yield node.value


def test_no_command_line_is_put_together_without_quotes():
    """`command_text` makes those with names and values; a constant one is parsed here."""
    begun = re.compile(rf"\btirefmu ({'|'.join(cli.commands)})\b.*")
    paths = [path for room in ROOMS for path in (ROOT / room).rglob("*.py")]
    found = {match[0].strip('"') for path in paths for text in texts_of(path) for match in begun.finditer(text)}
    assert {*SENTENCES, *(text for text in LISTED_BY.values() if begun.match(text))} <= found
    for line in found.difference(SENTENCES):
        accepted(line)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_the_example_prints_the_fit_of_its_recording(folder, command):
    printed = command("example", "-o", HOSTILE, "--sample-rate", "2").out
    (line,) = re.findall("next: (.*)", printed)
    name, options = accepted(line)
    assert (name, options["tables"]) == ("fit", (Path(HOSTILE),))
    assert command(*shlex.split(line)[1:-2]).status in (0, 1)  # without the report, which takes longer than the fit


def following(printed):
    """Return the arguments of the command that a command prints last."""
    last = printed.strip().splitlines()[-1]
    assert last.startswith("next: ")
    line = last.removeprefix("next: ")
    accepted(line)
    return shlex.split(line)[1:]


def test_each_step_prints_the_next_one_which_runs(folder, command):
    """From the recording to the check of the FMU, by the printed commands alone."""
    table = folder / HOSTILE
    late(0.0).to_csv(table, index=False)
    arguments = ["inspect", table, "--where", "t > 1"]
    steps = []
    while len(steps) < 6 and arguments:
        done = command(*arguments)
        steps.append(str(arguments[0]))
        assert done.status in (0, 1), done.err
        arguments = following(done.out) if "next: " in done.out else []
    assert steps[:2] == ["inspect", "fit"]
    assert steps[2:] in (["export", "explore"], ["diagnose", "check", "check"])
    assert list(folder.rglob("*.fmu"))


@pytest.mark.parametrize(("fmus", "step"), [(True, "check"), (False, "export")])
def test_the_next_command_of_a_diagnosis_is_accepted(folder, fmus, step):
    selection = TableOptions("iso", "t > 1", {"Fy": "my force"}, None)
    name, options = accepted(_next_command(folder / "an answer", Path(HOSTILE), selection, fmus))
    assert name == step
    assert options["fmu" if fmus else "output"] == folder / "an answer" / "improved.fmu"
    if fmus:
        assert options["table"] == Path(HOSTILE)
        assert {name: options[name] for name in vars(selection)} == vars(selection)


@pytest.mark.slow
@pytest.mark.parametrize(("option", "steps"), [((), "check"), (("--no-fmu",), "export")])
def test_a_diagnosis_prints_the_next_step_which_runs(folder, command, option, steps):
    late(0.15).to_csv(folder / HOSTILE, index=False)
    given = ["--model", "mf61", "--nominal", "Fz0=800,R0=0.25", "--candidates", "relax_lat", "--where", "t > 1"]
    done = command("diagnose", HOSTILE, *given, "-o", "an answer", *option)
    assert done.status == 0, done.err
    arguments = following(done.out)
    assert arguments[0] == steps
    last = command(*arguments)
    assert last.status == 0, last.err


def test_init_prints_the_run_of_its_project(folder, command):
    (folder / HOSTILE).write_text("alpha,Fz,Fy\n0,900,0\n", encoding="utf-8")
    (line,) = re.findall("run: (.*)", command("init", HOSTILE, "-o", "my project.toml").out)
    assert accepted(line)[1]["project"] == Path("my project.toml")


def late(lag):
    """Return a recording of a side force that lags by seconds."""
    clock = np.arange(1200) / 25.0
    alpha = 0.15 * np.sin(2.0 * np.pi * clock / 9.0)
    load = 800.0 + 300.0 * np.sin(2.0 * np.pi * clock / 31.0)
    force = -1.5 * load * np.tanh(12.0 * alpha)
    noise = np.random.default_rng(0).normal(0.0, 4.0, len(clock))
    return pd.DataFrame(
        {"t": clock, "alpha": alpha, "Fz": load, "V": 10.0, "Fy": np.interp(clock - lag, clock, force) + noise}
    )


@pytest.mark.slow
def test_a_fit_prints_the_diagnosis_of_its_residual(folder, command):
    data = folder / "bench data"
    data.mkdir()
    late(0.15).to_csv(data / HOSTILE, index=False)
    fit = ["fit", data / HOSTILE, "--model", "mf61", "--nominal", "Fz0=800,R0=0.25", "--where", "t > 1", "--all-rows"]
    printed = command(*fit, "-o", "my tire.tir", "--json", "fit.json")
    (finding,) = [row for row in json.loads(Path("fit.json").read_text())["data_findings"] if row["effects"]]
    assert finding["command"] in printed.out
    name, options = accepted(finding["command"])
    assert (name, options["where"], options["candidates"]) == ("diagnose", "t > 1", ("relax_lat",))
    done = command(*shlex.split(finding["command"])[1:], "--no-fmu")
    assert done.status == 0, done.err
    assert (options["output"] / "diagnosis.json").exists()


def test_only_effects_that_a_diagnosis_can_test_are_printed():
    recording, tires = Recording(late(0.1), "iso", "a.csv"), ("trento_hoosier", "unicamp_small_tire")
    effects = ("relax_lat", "temp_friction")  # MF96 has no relaxation, and the recording no temperature
    assert [_testable(effects, published(name), recording) for name in tires] == [[], ["relax_lat"]]
    without = Recording(late(0.1).drop(columns="Fz"), "iso", "a.csv")
    assert _testable(effects, published("unicamp_small_tire"), without) == []
