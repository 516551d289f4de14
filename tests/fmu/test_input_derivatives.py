"""Derivatives of inputs (FMI 2, canInterpolateInputs): inputs that change over a step."""

from __future__ import annotations

import ctypes

import numpy as np
import pytest

from .conftest import DISCARD, ERROR, OK


@pytest.fixture
def rolling(hosts):
    return hosts("rolling", 2)


def set_slopes(host, order=1, **slopes):
    n = len(slopes)
    orders, values = (ctypes.c_int * n)(*[order] * n), (ctypes.c_double * n)(*slopes.values())
    return host.call("SetRealInputDerivatives", host.references(slopes), n, orders, values)


def course(host, steps, slope=None):
    """Return Fy at the end of 0.2 s in which alpha grows to 0.1."""
    assert host.call("Reset") == OK
    assert host.set(V=12.0, Fz=4000.0) == OK
    host.start()
    size = 0.2 / steps
    for k in range(steps):
        assert host.set(alpha=0.5 * size * (k + 0.5 if slope is None else k)) == OK
        assert slope is None or set_slopes(host, alpha=slope) == OK
        assert host.step(k * size, size) == OK
    assert not slope or host.get("alpha")[0] == pytest.approx(0.1, rel=1e-12)
    assert host.set(alpha=0.1) == OK
    return host.get("Fy")[0]


def test_a_coarse_step_is_that_of_fine_ones(rolling):
    exact = course(rolling, 4000)
    assert course(rolling, 5, 0.5) == pytest.approx(exact, rel=1e-4)
    assert course(rolling, 5, 0.0) != pytest.approx(exact, rel=1e-3)  # held at the start of each step
    rolling.call("Reset")
    course(rolling, 1, 0.5)


def test_they_are_for_one_step(rolling):
    rolling.start()
    assert set_slopes(rolling, alpha=1.0) == OK
    assert rolling.step(0.0, 0.01) == OK
    assert rolling.get("alpha")[0] == pytest.approx(0.01)
    assert rolling.step(0.01, 0.01) == OK
    assert rolling.get("alpha")[0] == pytest.approx(0.01)


def test_a_refused_call_changes_nothing(rolling):
    rolling.start()
    before = rolling.everything()
    assert set_slopes(rolling, order=2, alpha=1.0) == ERROR
    assert set_slopes(rolling, Fy=1.0) == ERROR
    assert set_slopes(rolling, alpha=np.inf) == DISCARD
    assert set_slopes(rolling, alpha=1e308) == OK
    assert rolling.step(0.0, 100.0) == DISCARD
    assert set_slopes(rolling, alpha=0.0) == OK
    np.testing.assert_array_equal(rolling.everything(), before)
