"""A stopped fit returns and reports the best values so far; a running one reports its tire."""

from __future__ import annotations

import os
import signal
import threading
from dataclasses import replace

import pytest
from threadpoolctl import threadpool_info, threadpool_limits

from tirefmu.fitting import stage as solution_of_a_stage
from tirefmu.fitting.solvers import Interruption


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


def ended():
    signal.raise_signal(signal.SIGTERM)


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


@pytest.mark.parametrize("how", [raised, pressed, ended])
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
    prepared = solution_of_a_stage.prepared_stages

    def pressed_too_early(setup):
        pressed()
        return prepared(setup)

    monkeypatch.setattr(solution_of_a_stage, "prepared_stages", pressed_too_early)
    with pytest.raises(KeyboardInterrupt):
        make.fit(recording)


def test_an_exception_of_the_progress_callback_is_raised(recording, make):
    def wrong(stage, iteration, cost):
        raise ValueError("mine")

    with pytest.raises(ValueError, match="mine"):
        make.fit(recording, progress=wrong)


def test_a_fit_computes_with_one_thread_of_blas(recording, make, monkeypatch):
    threads = set()

    def look(stage, state, interruption):
        threads.update(each["num_threads"] for each in threadpool_info() if each["user_api"] == "blas")
        raise InterruptedError

    monkeypatch.setattr(solution_of_a_stage, "solve_stage", look)
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


def test_a_request_to_end_the_program_stops_once_and_then_ends_it():
    with Interruption() as interruption:
        ended()
        assert interruption.requested
        assert signal.getsignal(signal.SIGTERM) is signal.SIG_DFL


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


def test_the_tire_of_each_iteration_and_stage_is_reported(recording, make):
    class Following:
        def __init__(self):
            self.tires, self.stages, self.iterations = [], [], 0

        def __call__(self, stage, iteration, cost):
            self.iterations += 1
            if stage not in self.stages:
                self.stages.append(stage)

        def reached(self, tire):
            self.tires.append((self.stages[-1] if self.stages else "", tire))

    following = Following()
    result = make.fit(recording, progress=following)
    last = {stage: tire for stage, tire in following.tires if stage}
    assert list(last) == [stage.name for stage in result.stages]
    assert last[result.stages[-1].name].values["PDY1"] == result.tire.values["PDY1"]
    assert len(following.tires) >= following.iterations + len(result.stages)
