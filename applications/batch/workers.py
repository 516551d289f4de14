"""Where independent tasks are computed: on processes of this machine, or on a Dask cluster."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import TypeVar

from ...boundary.errors import FitError
from .cluster import completed_on_cluster
from .execution import Lost, completed

Task = TypeVar("Task")
Result = TypeVar("Result")
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
