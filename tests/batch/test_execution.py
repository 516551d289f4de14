"""Independent tasks on processes of this machine and on a Dask cluster. The tasks are expressions for `eval`."""

from __future__ import annotations

import pytest

from tirefmu.applications.batch import Lost, completed, completed_on_cluster
from tirefmu.boundary.errors import FitError

from .conftest import kill_a_busy_worker

END = "__import__('os')._exit(3)"
SLOW = "__import__('time').sleep(0.5) or {}"


def test_results_have_the_number_of_their_task():
    assert dict(completed(eval, (f"{i}**2" for i in range(9)), workers=2)) == {i: i**2 for i in range(9)}
    assert list(completed(eval, [], workers=2)) == []


def test_a_process_that_ends_costs_its_own_task_only():
    tasks = ["1", "1/0", END, *(SLOW.format(i) for i in range(3, 7))]
    results = dict(completed(eval, tasks, workers=2))
    assert results.keys() == set(range(7))
    assert [results[i] for i in (0, *range(3, 7))] == [1, 3, 4, 5, 6]
    assert results[1] == Lost("ZeroDivisionError: division by zero")
    assert "its process ended" in results[2].reason


def test_later_tasks_are_not_read_before_they_are_needed():
    read = []

    def tasks():
        for i in range(50):
            read.append(i)
            yield f"{i}"

    results = completed(eval, tasks(), workers=1)
    next(results)
    assert len(read) < 5
    results.close()


def test_a_cluster_gives_the_same_results(cluster):
    tasks = [f"{i}**2" for i in range(8)] + ["1/0"]
    results = dict(completed_on_cluster(eval, tasks, cluster.scheduler_address))
    assert results == {**{i: i**2 for i in range(8)}, 8: Lost("ZeroDivisionError: division by zero")}


def test_a_killed_worker_loses_nothing(cluster):
    results = {}
    for number, result in completed_on_cluster(eval, [SLOW.format(i) for i in range(6)], cluster.scheduler_address):
        if not results:
            kill_a_busy_worker(cluster)
        results[number] = result
    assert results == {i: i for i in range(6)}


def test_a_scheduler_that_does_not_answer_is_an_error(monkeypatch):
    pytest.importorskip("distributed")
    monkeypatch.setattr("tirefmu.applications.batch.execution.CONNECTION_TIMEOUT", 0.5)
    with pytest.raises(FitError, match="no scheduler answers at tcp://127"):
        list(completed_on_cluster(eval, ["1"], "tcp://127.0.0.1:1"))
