"""docs/awkward_inputs.md states what tirefmu reports about each awkward input."""

from __future__ import annotations

import importlib.util
import re
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]


def _script():
    spec = importlib.util.spec_from_file_location("awkward_inputs", ROOT / "benchmarks" / "awkward_inputs.py")
    module = importlib.util.module_from_spec(spec)
    sys.modules[spec.name] = module  # dataclasses look it up
    spec.loader.exec_module(module)
    return module


script = _script()
CASES = script.cases()
ROW = re.compile(r"\| \d+ \| (?P<name>.*?) \| (?P<inspect>\d) \| (?P<fit>\d) \| (?P<messages>.*) \|")
DOCUMENTED = {row["name"]: row for row in ROW.finditer(script.DOCUMENT.read_text(encoding="utf-8"))}


def test_the_table_has_every_input():
    assert list(DOCUMENTED) == list(CASES)
    assert len(CASES) == 46


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


def test_no_input_passes_in_silence():
    assert not [name for name, row in DOCUMENTED.items() if row["messages"] == "-"]


def test_a_sound_recording_has_no_message(tmp_path):
    assert script.outcome([script.recording()], tmp_path) == script.Outcome(0, 0, ())
