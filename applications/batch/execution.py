"""Independent tasks on processes of this machine: results as they finish; a process that ends costs its own task."""

from __future__ import annotations

import multiprocessing
import os
import signal
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from itertools import islice
from typing import TypeVar

from threadpoolctl import threadpool_limits

Task = TypeVar("Task")
Result = TypeVar("Result")

#: Tasks that wait for a process, per process: the data of later tasks are not in memory yet.
WAITING = 2


@dataclass(frozen=True)
class Lost:
    """A task without a result: its process ended, or an error that is no misuse."""

    reason: str


def completed(
    function: Callable[[Task], Result], tasks: Iterable[Task], workers: int | None = None
) -> Iterator[tuple[int, Result | Lost]]:
    """Yield number and result of each task as it finishes.

    `function`: of a module that other processes can import. `tasks`: read as they are needed. `workers`: number of
    processes. Default: one for each processor. Yields: `Lost` if the function raises, or its process ends twice: once
    with others, then alone.

    Each process computes with one thread: the results do not depend on the number of processes.
    """
    workers = workers or os.cpu_count() or 1
    numbered = enumerate(tasks)
    while True:
        ended: list[tuple[int, Task]] = []
        with _pool(workers) as pool:
            yield from _until_a_process_ends(pool, function, numbered, workers, ended)
        if not ended:
            return
        for number, task in ended:
            yield number, _alone(function, task)


def _pool(workers: int) -> ProcessPoolExecutor:
    # Forked processes would inherit the threads and locks of numerical libraries.
    context = multiprocessing.get_context("spawn")
    return ProcessPoolExecutor(workers, mp_context=context, initializer=_end_with_ctrl_c)


def _end_with_ctrl_c() -> None:
    """End this process without a message if the user interrupts the batch; in the background nobody does."""
    if signal.getsignal(signal.SIGINT) is not signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.SIG_DFL)


def _until_a_process_ends(
    pool: ProcessPoolExecutor, function: Callable[[Task], Result], numbered: Iterator[tuple[int, Task]], workers: int,
    ended: list[tuple[int, Task]],
) -> Iterator[tuple[int, Result | Lost]]:  # fmt: skip
    """Yield results; the tasks that were under way when a process ended are appended to `ended`."""
    under_way: dict[Future[Result], tuple[int, Task]] = {}
    try:
        while True:
            for number, task in islice(numbered, 0 if ended else workers * WAITING - len(under_way)):
                under_way[pool.submit(single_threaded, function, task)] = number, task
            if not under_way:
                return
            for future in wait(under_way, return_when=FIRST_COMPLETED).done:
                number, task = under_way.pop(future)
                if isinstance(future.exception(), BrokenProcessPool):
                    ended.append((number, task))
                else:
                    result = _result_of(future)
                    yield number, result
    except BaseException:
        pool.shutdown(wait=False, cancel_futures=True)
        raise


def _alone(function: Callable[[Task], Result], task: Task) -> Result | Lost:
    """Return the result of a task in a process of its own."""
    with _pool(1) as pool:
        future: Future[Result] = pool.submit(single_threaded, function, task)
        result = _result_of(future)
    return result


def single_threaded(function: Callable[[Task], Result], task: Task) -> Result:
    """Return the result of a task, with one thread in numerical libraries."""
    with threadpool_limits(1):
        return function(task)


def _result_of(future: Future[Result]) -> Result | Lost:
    """Return the result of a future, or `Lost` with its exception as the reason."""
    try:
        return future.result()
    except BrokenProcessPool:
        return Lost("its process ended without a result (out of memory, or killed)")
    except Exception as error:
        return Lost(f"{type(error).__name__}: {error}")
