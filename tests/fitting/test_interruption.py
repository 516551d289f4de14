"""A stopped fit returns and reports the best values so far, and resumes after its completed stages."""

from __future__ import annotations

import json
import os
import re
import signal
import threading
from dataclasses import replace

import numpy as np
import pytest
from threadpoolctl import threadpool_info, threadpool_limits

from tirefmu.boundary.errors import FitError
from tirefmu.fitting.fit_run import FitRun
from tirefmu.fitting.results.checkpoint import Checkpoint
from tirefmu.fitting.solvers.interruption import Interruption

STAGES = ["Fy: core, load, combined slip", "Fy", "Fx, Fy, Mz, random rows", "Fx, Fy, Mz, all rows"]


def stopping(at_stage, at_iteration, how):
    """Return a progress callback that requests a stop at a stage and iteration."""

    def progress(stage, iteration, cost):
        if (stage, iteration) == (at_stage, at_iteration):
            how()

    return progress


def raised():
    raise KeyboardInterrupt


def pressed():
    os.kill(os.getpid(), signal.SIGINT)


@pytest.fixture(autouse=True)
def listening():
    """Install the default handler of Ctrl-C, which shells disable for background processes."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.fixture
def whole(side_fit):
    return side_fit[0]


@pytest.fixture
def recording(side_fit):
    return side_fit[1]


def same(one, other):
    """Compare two results to the last digit; only the time may differ."""
    records = [{**result.to_json(), "seconds": 0.0} for result in (one, other)]
    assert records[0] == records[1]


@pytest.mark.parametrize("how", [raised, pressed])
def test_an_interrupt_returns_the_best_values_so_far(recording, whole, make, how):
    handler = signal.getsignal(signal.SIGINT)
    progress = stopping("Fy", 8, how)
    result = make.fit(recording, progress=progress)
    assert signal.getsignal(signal.SIGINT) is handler
    assert not result.ok
    assert result.status.startswith("interrupted in stage 'Fy', iteration 8, 3 of 10 stages done")
    assert result.to_json()["status"] == result.status
    assert [(stage.name, stage.converged, stage.reason) for stage in result.stages[1:]] == [
        ("Fy", False, "interrupted")
    ]
    # The second stage has improved the fit, but less than the complete fit.
    first = replace(result, run=replace(result.run, stages=result.stages[:1]))
    assert whole.channels[0].rmse < result.channels[0].rmse
    assert result.stages[1].cost < first.stages[0].cost
    assert all(margin.margin >= -1e-6 for margin in result.margins)


def test_an_interrupt_before_the_first_stage_has_no_result(recording, make, monkeypatch):
    from tirefmu.fitting import fit_run

    def pressed_too_early(*arguments):
        pressed()
        return np.ones((1, 5))

    monkeypatch.setattr(fit_run, "emphasis", pressed_too_early)
    with pytest.raises(KeyboardInterrupt):
        make.fit(recording)


def test_an_exception_of_the_progress_callback_is_raised(recording, make):
    def wrong(stage, iteration, cost):
        raise ValueError("mine")

    with pytest.raises(ValueError, match="mine"):
        make.fit(recording, progress=wrong)


def test_a_fit_computes_with_one_thread_of_blas(recording, make, monkeypatch):
    threads = set()

    def look(run, stage):
        threads.update(each["num_threads"] for each in threadpool_info() if each["user_api"] == "blas")
        raise InterruptedError

    monkeypatch.setattr(FitRun, "_run", look)
    with threadpool_limits(limits=2, user_api="blas"), pytest.raises(InterruptedError):
        make.fit(recording)
    assert threads <= {1}


def test_a_second_interrupt_is_not_delayed():
    def twice():
        with Interruption():
            pressed()
            pressed()

    with pytest.raises(KeyboardInterrupt):
        twice()


def test_a_signal_handler_of_the_program_is_not_replaced():
    seen = []
    before = signal.signal(signal.SIGINT, lambda number, frame: seen.append(number))
    try:
        with Interruption() as interruption:
            pressed()
    finally:
        signal.signal(signal.SIGINT, before)
    assert (seen, interruption.requested) == ([signal.SIGINT], False)


def test_another_thread_does_not_replace_the_handler():
    outcome = []

    def run():
        with Interruption(lambda *call: raised()) as interruption:
            interruption.report("Fx", 1, 0.5)
            outcome.append(interruption.requested)

    thread = threading.Thread(target=run)
    thread.start()
    thread.join()
    assert outcome == [True]


@pytest.mark.parametrize("stage", STAGES[1:])
def test_a_resumed_fit_equals_an_uninterrupted_one(recording, whole, make, tmp_path, stage):
    path = tmp_path / "tire.progress.json"
    interrupted = make.fit(recording, checkpoint=path, progress=stopping(stage, 2, raised))
    assert interrupted.run.interrupted
    assert json.loads(path.read_text(encoding="utf-8"))["state"]["done"] > 0
    stages = []
    resumed = make.fit(recording, checkpoint=path, resume=True, progress=lambda *call: stages.append(call[0]))
    assert stages[0] == stage
    same(resumed, whole)
    same(make.fit(recording, checkpoint=path, resume=True, progress=raised), whole)  # no stage runs again


def test_a_progress_file_of_another_fit_is_rejected(recording, make, tmp_path):
    path = tmp_path / "tire.progress.json"
    make.fit(recording, checkpoint=path, progress=stopping(STAGES[1], 1, raised))
    moved = replace(recording, table=recording.table.assign(Fy=recording.table["Fy"] + 1e-9))
    for data, changed, name in (
        (moved, {}, "data"),
        (recording, {"effects": make.effects[1:]}, "effects"),
        (recording, {"recipe": "joint"}, "recipe"),
        (recording, {"nominal": {"Fz0": 800.0, "R0": 0.23}}, "initial values"),
        (recording, {"rows": "equal"}, "rows"),
        (recording, {"screening": False}, "screening"),
    ):
        with pytest.raises(FitError, match=rf"belongs to a fit with other {name}: restore them"):
            make.fit(data, checkpoint=path, **changed, resume=True)
    assert path.exists()


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (None, "no such file: there is no interrupted fit"),
        ("{", "not a progress file"),
        ("[]", "not a progress file of this version"),
        ('{"version": 2}', "not a progress file of this version"),
        ('{"version": 4}', "was changed after it was written"),
        ("[" * 100_000, "not a progress file"),
        (Checkpoint.sealed({"version": 4}), "belongs to a fit with other"),
        (Checkpoint.sealed({"version": 4, "identity": [1]}), "belongs to a fit with other"),
    ],
)
def test_an_invalid_progress_file_is_rejected(recording, make, tmp_path, text, message):
    path = tmp_path / "tire.progress.json"
    if text is not None:
        path.write_text(text, encoding="utf-8")
    with pytest.raises(FitError, match=message):
        make.fit(recording, checkpoint=path, resume=True)


BOUNDS = {"bounds": {"guess": 1.0, "lower": 0.0, "upper": 2.0}, "stage": "one", "determined": True}
#: Invalid content of a progress file: key, value, message.
WRONG = (
    ("done", "all", "done is 'all': expected a whole number"),
    ("done", 99, "not those of this fit"),
    ("values", [], "values is ..: expected a table of values"),
    ("values", {"PDY1": None}, "float"),
    ("values", {"PDY1": float("nan")}, "values.PDY1 is nan: expected a number"),
    ("values", {"<script>": 1.0}, "not those of this fit"),
    ("values", {}, "not those of this fit"),
    ("freed", {"PDY1": 1}, "freed.PDY1 is 1: expected a table"),
    ("freed", {"<script>": BOUNDS}, "not those of this fit"),
    ("freed", {}, "not those of this fit"),
    ("freed", {"PDY1": {**BOUNDS, "bounds": {"guess": 1.0, "lower": 2.0, "upper": 1.0}}}, "2 to 1 are no bounds"),
    ("freed", {"PDY1": {**BOUNDS, "bounds": {"guess": "inf", "lower": 1.0, "upper": 2.0}}}, "guess is 'inf'"),
    ("violated", [["no such", [[1.0]]]], "not those of this fit"),
    ("violated", [3], "is 3: expected a list"),
    ("stages", [{}], r"name is missing in stages\[1\]"),
    ("ended", [{"stage": 77, "values": {}, "free": {}, "x": []}], "not those of this fit"),
    ("notes", "a note", "notes is 'a note': expected a list of texts"),
)


def test_a_modified_progress_file_is_rejected(recording, make, tmp_path):
    path = tmp_path / "tire.progress.json"
    make.fit(recording, checkpoint=path, progress=stopping(STAGES[1], 1, raised))
    whole = json.loads(path.read_text(encoding="utf-8"))
    changed = re.sub(r'"done": \d+', '"done": 0', path.read_text(encoding="utf-8"))
    for text, message in (
        (changed, "was changed after it was written"),
        (Checkpoint.sealed({**whole, "state": {"done": 1}}), "values is missing"),
        *((Checkpoint.sealed({**whole, "state": {**whole["state"], key: value}}), text) for key, value, text in WRONG),
    ):
        path.write_text(text, encoding="utf-8")
        with pytest.raises(FitError, match=rf"tire\.progress\.json: invalid progress file:? .*{message}"):
            make.fit(recording, checkpoint=path, resume=True)


def test_resuming_requires_a_file(recording, make):
    with pytest.raises(FitError, match="requires the file of the completed stages"):
        make.fit(recording, resume=True)
