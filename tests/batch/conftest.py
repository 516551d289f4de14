"""A Dask cluster of two workers for the tests of a file: an idle one takes time, too. Nannies replace dead workers."""

from __future__ import annotations

import os
import signal

import pytest


@pytest.fixture(scope="module")
def cluster(tmp_path_factory):
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, host="127.0.0.1", dashboard_address="127.0.0.1:0",
        local_directory=str(tmp_path_factory.mktemp("dask")), silence_logs=50,
    ) as cluster:  # fmt: skip
        yield cluster


@pytest.fixture
def kill_once(cluster):
    """Return a progress function that kills a busy worker at its first call; it has to be called."""
    killed = []

    def progress(*_: object) -> None:
        if not killed:
            killed.append(kill_a_busy_worker(cluster))

    yield progress
    assert killed


def kill_a_busy_worker(cluster) -> str:
    """Kill a worker that computes, and return its address."""
    from distributed import Client

    with Client(cluster.scheduler_address) as client:
        busy = {address for address, keys in client.processing().items() if keys}
    nanny = next(worker for worker in cluster.workers.values() if worker.worker_address in busy)
    os.kill(nanny.pid, signal.SIGKILL)
    return nanny.worker_address
