"""Text of a file is printed as text: no escape sequence, no markup, no second line."""

from __future__ import annotations

import io
import re
import shutil
import sys
from dataclasses import replace
from types import SimpleNamespace

import pytest
from rich.console import Console

from tirefmu.boundary.errors import LONGEST, TirefmuError, UnknownName
from tirefmu.boundary.terminal_table import LONGEST_CELL, plain_table
from tirefmu.commands.cli import main
from tirefmu.commands.terminal import LINE, Terminal, wrapped
from tirefmu.fitting.results.records import Bootstrap
from tirefmu.measurements import DataFinding
from tirefmu.tires import published

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
    table = plain_table("problem", "rows", title=text)
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


@pytest.mark.slow
def test_no_line_is_longer_than_the_limit(chain, command, bench_csv, published_fmu, tmp_path, monkeypatch):
    """Except for a command to enter: all tables and texts of the main commands, on a recording with few rows."""
    monkeypatch.chdir(tmp_path)
    shutil.copy(bench_csv, "bench.csv")
    shutil.copy(published_fmu, "trento.fmu")
    folder, outcomes = chain
    shutil.copy(folder / "fitted.tir", "my.tir")
    # Figures take longer than all commands.
    monkeypatch.setattr("tirefmu.applications.comparison.figures.write_figures", lambda _, folder: folder.mkdir() or [])
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


def test_the_first_screen_of_a_fit_has_at_most_40_lines_of_100_columns(capsys):
    """With long names, many reasons, warnings and channels, and every further line that a fit can have."""
    name = "a_long_name_of_a_recording_" * 3 + ".csv"
    enter = f"tirefmu diagnose {name} --tire my_fitted_tire.tir --candidates temp_friction,temp_stiffness -o answer"
    channel = SimpleNamespace(
        recording=name, channel="Mz", rows=123456, fitted_rows=123456, fitted_rmse=1234.5, unit="N m", noise_floor=99.9,
        fitted_r2=-0.4321,
    )  # fmt: skip
    result = SimpleNamespace(
        verdict=SimpleNamespace(word="usable with limits", reasons=[f"{name}: " + 30 * "reason "] * 12),
        data_findings=[DataFinding("lag", f"{name}: " + 40 * "word ", n % 2 == 0, enter, ("lag",)) for n in range(9)],
        channels=[channel] * 14, held_out=(), coefficients=(),
        bootstrap=Bootstrap(200, 12, 1234, 0, ()), excluded_rows=[1], notes=[2],
        temperature=SimpleNamespace(text=lambda: "temperature T: RMSE 1.2 K"), status="converged",
        run=SimpleNamespace(method="ipopt", seconds=12.3),
    )  # fmt: skip
    columns = ", ".join(f"column_{number}" for number in range(8))
    recordings = [
        SimpleNamespace(source=f"{number}_{name}", about={"selected": "1 of 9 rows", "ignored": f"{columns}, {number}"})
        for number in range(5)
    ]
    terminal = Terminal()
    terminal.selection(*recordings)
    terminal.fit_result(result)
    files = ["tire: my.tir", "figures: 9 in figures", "report: fit.html", f"next: {enter}"]
    terminal.print(*files)
    printed = capsys.readouterr().out
    words, lines = printed.split(), printed.splitlines()
    for word, length in (("reason", 30), ("word", 40)):  # sentences are whole or counted
        assert words.count(word) in range(length, 4 * length, length)
    assert len(lines) <= 40
    assert all(len(line) <= LINE for line in lines if enter not in line)
