"""Independent tasks on processes of this machine or on a Dask cluster: results as they finish.

A process that ends costs its own task.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass
from importlib.metadata import version
from itertools import islice
from typing import TYPE_CHECKING, Any, TypeVar

from threadpoolctl import threadpool_limits

from ...boundary.errors import FitError

if TYPE_CHECKING:
    from distributed import Client


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
    """End this process without a message if the user interrupts the batch; in the background that cannot happen."""
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


#: Longest wait for the scheduler, s.
CONNECTION_TIMEOUT = 10.0


def completed_on_cluster(
    function: Callable[[Task], Result], tasks: Iterable[Task], address: str
) -> Iterator[tuple[int, Result | Lost]]:
    """Yield number and result of each task as it finishes.

    `tasks`: read as they are needed. The workers receive them with their data and read no files. `address`: of the
    scheduler, such as tcp://127.0.0.1:8786. Yields: `Lost` if the function raises, or workers end repeatedly with the
    task. If a worker ends, its tasks are computed by another one. Raises `FitError` if Dask is not installed, the
    scheduler does not answer, or workers have another version of tirefmu.
    """
    numbered = enumerate(tasks)
    with _connected(address) as client:
        from distributed import as_completed

        threads = sum(client.nthreads().values())
        number_of: dict[Any, int] = {}

        def submitted(count: int) -> Iterator[Any]:
            for number, task in islice(numbered, count):
                future = client.submit(single_threaded, function, task, pure=False)
                number_of[future.key] = number
                yield future

        finished = as_completed(submitted(threads * WAITING))
        for future in finished:
            yield number_of.pop(future.key), _cluster_result(future)
            for another in submitted(1):
                finished.add(another)


@contextmanager
def _connected(address: str) -> Iterator[Client]:
    """Connect to a scheduler whose workers have this version of tirefmu."""
    try:
        from distributed import Client
    except ImportError:
        raise FitError("--scheduler needs Dask: pip install 'tirefmu[distributed]'") from None
    try:
        client = Client(address, timeout=CONNECTION_TIMEOUT)
    except (OSError, ValueError) as error:
        raise FitError(f"no scheduler answers at {address} ({error})") from error
    with client:
        here, others = version("tirefmu"), client.run(_version)
        if not others:
            raise FitError(f"the scheduler at {address} has no workers")
        for worker, other in others.items():
            if other != here:
                raise FitError(f"worker {worker} has tirefmu {other}, not {here}")
        yield client


def _version() -> str:
    """Return the version of tirefmu of a worker."""
    return version("tirefmu")


def _cluster_result(future: Any) -> Any:
    from distributed import KilledWorker

    try:
        return future.result()
    except KilledWorker:
        return Lost("its worker ended repeatedly without a result (out of memory, or killed)")
    except Exception as error:
        return Lost(f"{type(error).__name__}: {error}")


#: Called with the numbers of finished and of all parts.
Progress = Callable[[int, int], None]


def results(
    function: Callable[[Task], Result], tasks: Iterable[Task], scheduler: str | None, workers: int | None
) -> Iterator[tuple[int, Result | Lost]]:
    """Yield number and result of each task as it finishes.

    `function`: of a module that other processes can import. `tasks`: read as they are needed. `scheduler`: address of a
    Dask scheduler, or None for processes of this machine. `workers`: number of local processes; by default one for each
    processor. Yields: `Lost` if a task has no result.
    """
    return completed_on_cluster(function, tasks, scheduler) if scheduler else completed(function, tasks, workers)


def all_results(
    function: Callable[[Task], Result], tasks: Sequence[Task], scheduler: str | None, workers: int | None,
    progress: Progress | None, size: Callable[[Task], int] = lambda task: 1,
) -> list[Result]:  # fmt: skip
    """Return the result of every task, in their order.

    `function`, `tasks`, `scheduler`, `workers`: as for `results`. `progress`: called as tasks finish. `size`: how much
    a task counts there. Raises `FitError` if a task has no result.
    """
    by_number: dict[int, Result] = {}
    total, finished = sum(map(size, tasks)), 0
    for number, outcome in results(function, tasks, scheduler, workers):
        if isinstance(outcome, Lost):
            raise FitError(f"a part of the computation has no result: {outcome.reason}")
        by_number[number] = outcome
        finished += size(tasks[number])
        if progress:
            progress(finished, total)
    return [by_number[number] for number in range(len(tasks))]
