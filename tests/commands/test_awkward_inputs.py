"""docs/awkward_inputs.md states what tirefmu reports about each awkward input."""

from __future__ import annotations

import importlib.util
import re
import shutil
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


def _script(name):
    spec = importlib.util.spec_from_file_location(name, ROOT / "benchmarks" / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # dataclasses look it up, and the other script does
    spec.loader.exec_module(module)
    return module


uses, script = _script("awkward_uses"), _script("awkward_inputs")
CASES = script.cases()
ROW = re.compile(r"\| \d+ \| (?P<name>.*?) \| (?P<inspect>\d) \| (?P<fit>\d) \| (?P<messages>.*) \|")
TEXT = script.DOCUMENT.read_text(encoding="utf-8")
DOCUMENTED = {row["name"]: row for row in ROW.finditer(TEXT)}
ANSWERS = dict(re.findall(r"(?m)^\| (.*?) \| (.*) \|$", TEXT[TEXT.index("## Awkward uses") :]))
USES = uses.uses()


def test_the_table_has_every_input():
    assert list(DOCUMENTED) == list(CASES)
    assert TEXT.startswith(script.INTRODUCTION.format(count=len(CASES)))


@pytest.mark.parametrize("name", CASES)
def test_the_table_is_up_to_date(name, tmp_path):
    """The column "fit" needs the slower start of a fit: it is compared where it adds a message."""
    row = DOCUMENTED[name]
    refused = row["inspect"] != row["fit"] and row["fit"] == "2"
    found = script.outcome(CASES[name], tmp_path, fit=refused)
    assert not (refused or found.inspect == 2) or found.fit == int(row["fit"])
    assert (str(found.inspect), "<br>".join(found.messages).replace("|", "\\|") or "-") == (
        row["inspect"], row["messages"],
    ), "run: python benchmarks/awkward_inputs.py --write"  # fmt: skip


def test_the_second_table_has_every_use():
    assert list(ANSWERS)[1:] == list(USES)
    assert script.USES.format(count=len(USES)) in TEXT


@pytest.mark.slow
@pytest.mark.parametrize("name", USES)
def test_the_answers_are_up_to_date(name):
    needed = uses.NEEDS.get(name)
    if needed == "cc" and not shutil.which(needed):
        pytest.skip("no C compiler")
    if needed not in (None, "cc"):
        pytest.importorskip(needed)
    assert script.cell(script.answer(USES[name])) == ANSWERS[name], "run: python benchmarks/awkward_inputs.py --write"


def test_no_input_passes_in_silence():
    assert not [name for name, row in DOCUMENTED.items() if row["messages"] == "-"]
    assert not [name for name, answer in ANSWERS.items() if answer == "exit 0"]


def test_a_sound_recording_has_no_message(tmp_path):
    assert script.outcome([script.recording()], tmp_path) == script.Outcome(0, 0, ())
