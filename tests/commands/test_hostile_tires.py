"""Tire files whose texts are C code with a constructor: it does not run in anything generated from them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from tirefmu.boundary.escaping import toml_string
from tirefmu.commands.cli import main
from tirefmu.symbolic.added import effect_text, read_effect
from tirefmu.tires import published, write_tir
from tirefmu.tires.code.compiler import CompilerError, find_compiler

EFFECT = """
name = "own"
physics = "friction by load"
source = "a test"
[coefficients]
OWN1 = {description = "friction", unit = "1", lower = -1.0, upper = 1.0}
[[acts]]
on = "mu_y"
factor = "1 + OWN1*(Fz - FNOMIN)/FNOMIN"
"""
TEXTS = {"description": '"friction"', "physics": '"friction by load"', "source": '"a test"', "unit": '"1"'}


@pytest.fixture(scope="module")
def table(tmp_path_factory):
    """Return the path of a table with enough rows for a compiled kernel."""
    path = tmp_path_factory.mktemp("table") / "rows.csv"
    t = np.arange(3000) * 1e-3
    pd.DataFrame({"t": t, "alpha": 0.1 * np.sin(t), "kappa": 0.0, "Fz": 1000.0}).to_csv(path, index=False)
    return path


def tire_file(folder, *positions):
    """Write a tire with an effect that has C code in some of its texts, and return its path."""
    code = (
        "*/ ONE }; extern int creat(const char *, unsigned); __attribute__((constructor)) static void run(void) "
        f'{{ creat("{(folder / "ran").as_posix()}", 0600); }} enum {{ TWO, /*'
    )
    own, first = read_effect(EFFECT, "own.toml"), published("trento_hoosier")
    write_tir(replace(first, effects=[*first.effects, "own"], added=(own,)), folder / "tire.tir")
    # As an attacker would: into the text of the file.
    hostile = effect_text(own)
    for position in positions:
        hostile = hostile.replace(TEXTS[position], toml_string(code))
    assert hostile.count("constructor") == len(positions)
    text = (folder / "tire.tir").read_text(encoding="utf-8")
    lines = [f"OWN = {_quoted(hostile)}" if line.startswith("OWN = ") else line for line in text.splitlines()]
    assert "creat" in "\n".join(lines)
    (folder / "tire.tir").write_text("\n".join(lines) + "\n", encoding="utf-8")
    return folder / "tire.tir"


def _quoted(text):
    return '"' + "".join(f"\\u{ord(c):04x}" if c in "\\\"'$!\n" else c for c in text) + '"'


def test_code_in_texts_does_not_run(table, tmp_path):
    try:
        find_compiler()
    except CompilerError:
        pytest.skip("no C compiler")
    tire = str(tire_file(tmp_path, "description", "physics", "source"))
    assert main(["evaluate", tire, str(table), "-o", str(tmp_path / "out.csv"), "--quiet"]) == 0
    assert main(["export", tire, "-o", str(tmp_path / "tire.fmu"), "--quiet"]) == 0
    assert main(["check", str(tmp_path / "tire.fmu"), str(tmp_path / "out.csv"), "--quiet"]) == 0
    assert not (tmp_path / "ran").exists()


def test_code_in_a_unit_is_one_line(table, tmp_path, capsys):
    tire = str(tire_file(tmp_path, "unit"))
    assert main(["evaluate", tire, str(table), "-o", str(tmp_path / "out.csv"), "--quiet"]) == 2
    assert "OWN1: unit has more than 40 characters" in capsys.readouterr().err
    assert sorted(path.name for path in tmp_path.iterdir()) == ["tire.tir"]
