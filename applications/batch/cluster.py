"""Independent tasks on the workers of a Dask cluster."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from importlib.metadata import version
from itertools import islice
from typing import TYPE_CHECKING, Any, TypeVar

from ...boundary.errors import FitError
from .execution import WAITING, Lost, single_threaded

if TYPE_CHECKING:
    from distributed import Client

Task = TypeVar("Task")
Result = TypeVar("Result")

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
            yield number_of.pop(future.key), _result_of(future)
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


def _result_of(future: Any) -> Any:
    from distributed import KilledWorker

    try:
        return future.result()
    except KilledWorker:
        return Lost("its worker ended repeatedly without a result (out of memory, or killed)")
    except Exception as error:
        return Lost(f"{type(error).__name__}: {error}")
