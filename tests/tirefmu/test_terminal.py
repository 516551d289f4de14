"""Text of a file is printed as text: no escape sequence, no markup, no second line."""

from __future__ import annotations

import io
import re
import shutil
import sys
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from rich.console import Console

from tirefmu.boundary.errors import LONGEST, TirefmuError, UnknownName
from tirefmu.boundary.escaping import toml_string
from tirefmu.cli import main
from tirefmu.fit_tables import LONGEST_CELL, plain_table
from tirefmu.symbolic.added import effect_text, read_effect
from tirefmu.terminal import LINE, Terminal, wrapped
from tirefmu.tires import published, write_tir
from tirefmu.tires.code.compiler import CompilerError, find_compiler

from ..hostile import HOSTILE, is_plain


@pytest.mark.parametrize("text", HOSTILE)
def test_a_line_stays_a_line(text, capsys):
    Terminal().print(text)
    out = capsys.readouterr().out
    assert is_plain(out)
    assert out.count("\n") == 1
    if text.isprintable():
        assert out == f"{text}\n"


@pytest.mark.parametrize("text", HOSTILE)
def test_titles_and_cells_are_text(text, capsys):
    table = plain_table("recording", "rows", title=text)
    table.add_row(text, "12")
    Terminal().heading(text, "of a file")
    Terminal().heading("file", text)
    Terminal()._out.print(table)
    out = capsys.readouterr().out
    assert is_plain(out)
    assert len(out) < 3 * len(text) * 6 + 20 * LONGEST_CELL
    if "[bold]" in text or "{{" in text:
        assert out.count(text) == 4  # unchanged, without markup and emoji


@pytest.mark.parametrize("text", HOSTILE)
def test_progress_is_text(text, monkeypatch):
    seen = []
    monkeypatch.setattr(Console, "status", lambda self, what: seen.append((self, what)) or _Nothing())
    terminal = Terminal()
    with terminal.working(text):
        pass
    with terminal.fitting() as progress:
        progress(text, 3, 0.1)
    for console, shown in seen:
        assert is_plain(console.render_str(shown).plain)


class _Nothing:
    def __enter__(self):
        return self

    def __exit__(self, *_):
        return None

    def update(self, shown):
        assert is_plain(shown)


@pytest.mark.parametrize("text", HOSTILE)
def test_an_error_is_one_printable_line_of_bounded_length(text):
    for error in (TirefmuError(f"{text}: no rows"), UnknownName("effect", text, [text, "camber_thrust"])):
        assert is_plain(str(error))
        assert "\n" not in str(error)
        assert len(str(error)) <= 6 * LONGEST


@pytest.mark.parametrize("text", HOSTILE)
@pytest.mark.parametrize("position", ["a file", "a command", "an option", "a choice", "pairs"])
def test_the_command_line_is_reported_back_as_text(position, text, capsys):
    arguments = {
        "a file": ["info", text],
        "a command": [text],
        "an option": ["info", "trento_hoosier", f"--{text}"],
        "a choice": ["draw", "trento_hoosier", "-o", "new", "--signs", text],
        "pairs": ["fit", "missing.csv", "-o", "new.tir", "--nominal", text],
    }[position]
    if position == "a file":
        text = text.replace("\x00", "").replace("\ud800", "")  # which no system passes to a command
        arguments = ["info", text]
    assert main(arguments) == 2
    captured = capsys.readouterr()
    assert captured.out == ""
    assert is_plain(captured.err)
    assert captured.err.count("\n") == 1
    assert captured.err.startswith("tirefmu: error: ")


def test_a_terminal_without_a_character_still_shows_the_line(monkeypatch, tmp_path):
    path = tmp_path / "tire.tir"
    replace(published("trento_hoosier"), name="Stra\u00dfe \u65e5").save(path)
    screen = io.BytesIO()
    monkeypatch.setattr(sys, "stdout", io.TextIOWrapper(screen, encoding="ascii", write_through=True))
    assert main(["info", str(path)]) == 0
    assert screen.getvalue().startswith(rb"Stra\xdfe \u65e5: ")


def test_no_line_is_longer_than_the_limit(chain, command, bench_csv, published_fmu, tmp_path, monkeypatch):
    """Except for a command to enter: all tables and texts of the main commands, on a recording with few rows."""
    monkeypatch.chdir(tmp_path)
    shutil.copy(bench_csv, "bench.csv")
    shutil.copy(published_fmu, "trento.fmu")
    folder, outcomes = chain
    shutil.copy(folder / "fitted.tir", "my.tir")
    # Figures take longer than all commands.
    monkeypatch.setattr("tirefmu.comparison.report.write_figures", lambda _, folder: folder.mkdir() or [])
    lines = [
        "inspect bench.csv --all", "info my.tir --all", "info trento_hoosier", "effects", "effects camber_thrust",
        "columns", "models", "lint my.tir --for carsim", "convert my.tir --for adams -o adams.tir",
        "compare my.tir trento_hoosier -o comparison", "check trento.fmu bench.csv", "export my.tir -o my.fmu",
        "explore my.tir bench.csv -o my.html",
    ]  # fmt: skip
    for done in (outcomes["fit"], *(command(*line.split()) for line in lines)):
        assert done.status in (0, 1), done.err
        printed = [re.sub(r"\(?tirefmu [a-z]+ .*", "", shown) for shown in (done.out + done.err).splitlines()]
        assert printed
        assert [shown for shown in printed if len(shown) > LINE or "\u2026" in shown] == []


def test_a_command_to_enter_remains_in_one_line():
    enter = "tirefmu diagnose 'run 1.csv' --where " + 40 * "t"
    assert wrapped(f"next: {enter} {enter}") == [f"next: {enter} {enter}"]
    *text, last = wrapped(f"warning: {30 * 'word '}; to continue: {enter}")
    assert last == f"  to continue: {enter}"
    assert max(map(len, text)) <= LINE
    assert " ".join(map(str.strip, text)) == f"warning: {30 * 'word '};"


# --------------- Tire files whose texts are C code with a constructor: it does not run in anything generated from them


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
