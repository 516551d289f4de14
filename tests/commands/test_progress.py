"""Progress: the time left follows the remaining work; lines on standard error only, and none with --quiet."""

from __future__ import annotations

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st
from rich.console import Console

from tirefmu.commands.progress import EVIDENCE, FitProgress, Stages, counting, showing_stages
from tirefmu.fitting import fit
from tirefmu.measurements import read_recording
from tirefmu.numerics import Forecast, seconds_left

from .conftest import EFFECTS

WORK = st.floats(0.1, 1e6)
#: A line of a stage that has ended, and of the parts of a computation.
ENDED = re.compile(r"^.+: .*\d+\.\d s(; stage \d+ of \d+(, (about \d+ (s|min)|less than 1 s) left)?)?$")
COUNTED = re.compile(r"^.+: \d+ of \d+, (about \d+ (s|min) left|less than 1 s left|\d+\.\d s)$")


def after(stages, seconds):
    """Return the forecast after each of the first stages has taken its seconds."""
    forecast = Forecast([(str(number), work) for number, work in enumerate(stages)])
    for number, each in enumerate(seconds):
        forecast.begin(str(number))
        forecast.end(each)
    return forecast


@given(done=st.lists(WORK, min_size=1, max_size=4), left=st.lists(WORK, max_size=4), more=WORK, seconds=WORK)
def test_the_time_left_grows_with_the_remaining_work(done, left, more, seconds):
    times = [seconds * work for work in done]
    found = after([*done, *left], times).left()
    assert found == pytest.approx(seconds * sum(left))  # at the pace so far
    assert after([*done, *left, more], times).left() > found
    assert after([*done, *(2.0 * work for work in left)], times).left() == pytest.approx(2.0 * found)


@given(stages=st.lists(WORK, min_size=3, max_size=6), running=st.floats(0.0, 1e9))
def test_within_a_stage_the_time_left_never_ends_before_the_stages_that_follow(stages, running):
    forecast = after(stages, [stages[0]])
    before = forecast.left()
    forecast.begin("1")
    assert forecast.left(0.0) == pytest.approx(before)
    assert forecast.left(running) >= sum(stages[2:]) * (1.0 - 1e-9)
    if running > 2.0 * stages[1] + stages[0]:  # slower than its work suggests: the others will be, too
        assert forecast.left(running) > sum(stages[2:])


def test_a_skipped_stage_has_no_work_and_an_unknown_one_no_place():
    forecast = Forecast([("a", 1.0), ("b", 100.0), ("c", 2.0)])
    forecast.begin("preparing")
    forecast.end(5.0)
    assert (forecast.place, forecast.left()) == ("", None)
    forecast.begin("a")
    forecast.end(1.0)
    forecast.begin("c")
    assert (forecast.place, forecast.left()) == ("stage 3 of 3", 2.0)


@given(parts=st.integers(2, 1000), finished=st.data(), seconds=WORK)
def test_counted_parts_take_equal_times(parts, finished, seconds):
    first = finished.draw(st.integers(1, parts - 1))
    assert seconds_left(first, parts, seconds) / (parts - first) == pytest.approx(seconds / first)
    assert seconds_left(parts, parts, seconds) == 0.0


def test_a_fit_announces_its_stages(bench_csv):
    """The announced stages are those that are solved, with rows times coefficients as their work."""
    planned, reported = [], []

    class Progress:
        def planned(self, work):
            planned.append(list(work))

        def __call__(self, stage, iteration, cost):
            reported.append(stage)

    result = fit([read_recording(bench_csv)], "mf96", effects=EFFECTS.split(","), nominal={"Fz0": 220.0, "R0": 0.23},
                 progress=Progress())  # fmt: skip
    (work,) = planned
    assert [name for name, _ in work] == list(dict.fromkeys(reported)) == [stage.name for stage in result.stages]
    for (_, size), stage in zip(work, result.stages, strict=True):
        assert size >= stage.rows * stage.free  # those that the rows do not determine are announced, too


def test_a_fit_prints_a_line_for_each_stage_without_a_terminal(validated, command, bench_csv, tmp_path):
    shown, found = validated
    lines = shown.err.splitlines()
    stages = [line for line in lines if "; stage " in line]
    assert [line for line in lines if not ENDED.match(line) and not COUNTED.match(line)] == []
    assert [re.search(r"stage (\d+) of (\d+)", line).groups() for line in stages] == [
        (str(number), str(len(stages))) for number in range(1, len(stages) + 1)
    ]
    assert len(stages) == len(found["stages"]) + 1  # and the evidence
    assert stages[-1].startswith(f"{EVIDENCE}: ")
    assert all(" left" in line for line in stages[:-1])
    assert [line.split(",")[0] for line in lines if line.startswith("cross")] == [
        f"cross-validation: {number} of 2" for number in range(3)
    ]
    assert not any(line in shown.out for line in lines)
    fast = ("--model", "mf96", "--effects", "none", "--cross-validate", "2", "--iterations", "1", "--quiet")
    assert command("fit", bench_csv, *fast, "-o", tmp_path / "t.tir").err == ""


@pytest.mark.parametrize("terminal", [True, False])
def test_a_terminal_has_one_line_and_a_log_all(terminal, capsys):
    console = Console(stderr=True, force_terminal=terminal, width=200, soft_wrap=True)
    with showing_stages(console, [("first", 1.0), ("second", 2.0)]) as stages:
        stages.begin("first")
        stages.event("identified: one")
        stages.begin("second")
    captured = capsys.readouterr()
    assert captured.out == ""
    assert "identified: one" in captured.err
    assert bool(re.search("^first: 0.0 s; stage 1 of 2", captured.err, flags=re.MULTILINE)) != terminal


def test_a_stage_that_raises_has_no_line(capsys):
    def failing():
        with showing_stages(Console(stderr=True), [("first", 1.0)]) as stages:
            stages.begin("first")
            raise RuntimeError

    with pytest.raises(RuntimeError):
        failing()
    assert capsys.readouterr().err == ""


def test_parts_of_an_earlier_run_are_not_counted(capsys, monkeypatch):
    """Of 100 parts 90 were there: one of the ten others has taken 2 s."""
    seconds = iter([0.0, 2.0])
    monkeypatch.setattr("tirefmu.commands.progress.monotonic", lambda: next(seconds))
    with counting(Console(stderr=True), "fitting", singly=True) as counted:
        counted(91, 100)
    assert capsys.readouterr().err == "fitting: 91 of 100, about 18 s left\n"


def test_what_follows_the_last_report_is_no_part_of_its_stage():
    lines, seconds = [], iter([0.0, 1.0, 2.0, 3.0, 10.0])
    stages = Stages(lines.append, lambda text: None, lines.append, lambda: next(seconds))
    progress = FitProgress(stages)
    progress.planned([("Fx", 1.0)])
    progress("Fx", 1, 0.5)
    progress("Fx", 2, 0.25)
    progress.finish()
    stages.end()
    assert lines == [
        "preparing the fit: 1.0 s", "Fx: iteration 2, cost 0.25, 2.0 s; stage 1 of 2, about 2 s left",
        "evidence and intervals: 7.0 s; stage 2 of 2",
    ]  # fmt: skip
