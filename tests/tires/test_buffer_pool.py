"""Memory of large results: used again when nothing refers to it, never before."""

from __future__ import annotations

import sys
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from tirefmu.tires import published
from tirefmu.tires.code import buffer_pool, code_for
from tirefmu.tires.code.buffer_pool import LARGE, BufferPool

from .test_batch import rows_of


@pytest.fixture
def memory(monkeypatch):
    monkeypatch.setattr(buffer_pool, "LARGE", 100)
    return BufferPool(most=1000)


def address(array):
    return array.ctypes.data


def test_results_held_at_once_are_independent():
    tire = published("unicamp_small_tire")
    model, parameters = tire.symbolic_model, tire.parameters()
    code, n = code_for(model.name, "batch"), LARGE // (len(model.inputs) * len(model.outputs)) + 1
    first_rows, second_rows = rows_of(model.name, n, seed=1), rows_of(model.name, n, seed=2)
    first = code.jacobian_inputs(first_rows, parameters)
    by_slip, whole = first[:, :, 0], first.copy()
    second = code.jacobian_inputs(second_rows, parameters)
    assert not np.shares_memory(first, second)
    np.testing.assert_array_equal(first, whole)
    where = address(first)
    del first
    third = code.jacobian_inputs(second_rows, parameters)  # the view still refers to the first result
    np.testing.assert_array_equal(by_slip, whole[:, :, 0])
    np.testing.assert_array_equal(third, second)
    del by_slip
    assert address(code.jacobian_inputs(first_rows, parameters)) == where
    np.testing.assert_array_equal(code.jacobian_inputs(first_rows, parameters), whole)


def test_memory_of_a_dropped_result_is_used_again(memory):
    first = memory.empty((2, 100))
    where = address(first)
    assert address(memory.empty((200,))) != where
    del first
    smaller = memory.empty((190,))
    assert smaller.shape == (190,)
    assert address(smaller) == where  # what was kept last
    assert address(memory.empty((2, 100))) != where


def test_much_larger_memory_is_not_used_for_a_small_result(memory):
    large = memory.empty((1000,))
    where = address(large)
    del large
    assert address(memory.empty((200,))) != where


def test_kept_memory_is_limited(memory):
    results = [memory.empty((300,)) for _ in range(5)]
    addresses = {address(result) for result in results}
    results.clear()
    assert len(memory._kept) == 3
    assert {address(kept) for kept in memory._kept} <= addresses
    memory.empty((2000,))
    assert sum(kept.size for kept in memory._kept) <= 1000


def test_small_results_are_ordinary_arrays(memory):
    assert memory.empty((3, 30)).base is None


def test_threads_never_share_memory(memory):
    def fill(value):
        mismatches = 0
        for _ in range(300):
            array = memory.empty((150,))
            array[:] = value
            view = array[50:]
            del array
            mismatches += int((view != value).any())
        return mismatches

    interval = sys.getswitchinterval()
    sys.setswitchinterval(1e-6)
    try:
        with ThreadPoolExecutor(4) as pool:
            assert sum(pool.map(fill, range(4))) == 0
    finally:
        sys.setswitchinterval(interval)
