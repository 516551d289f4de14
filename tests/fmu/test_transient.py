"""Lagged slips: the states of the FMU against the exact solution and the direct evaluation of the tire."""

from __future__ import annotations

import struct

import numpy as np
import pytest

from .conftest import ERROR, OK, distance
from .test_states import recording

POINT = {"kappa": 0.06, "alpha": -0.09, "gamma": 0.02, "Fz": 4200.0, "p": 2.3e5, "V": 14.0}
STRAIGHT = POINT | {"kappa": 0.0, "alpha": 0.0}
SLIPS = ("kappa_lagged", "alpha_lagged")


@pytest.fixture
def rolling(hosts, lagging, fmi):
    """Return a host of a lagging tire that has run straight so far."""
    return hosts(lagging, fmi).start(**STRAIGHT)


def steady(tires, lagging, **point):
    return np.array([float(force) for force in tires[lagging].forces(**point).values()])


def test_conventions_reach_the_lengths_too(hosts, tires):
    host, tire = hosts("rolling", 3), tires["rolling"]
    table = recording(tire, 150, 13)
    expected = tire.evaluate(table, convention="book", slip_angle="angle", limits=True, hold=True)
    host.initialize(time=table["t"][0])
    assert host.set(CONVENTION=1.0, SLIP_ANGLE=1.0, LIMITS=1.0) == OK
    shown = []
    for i, size in enumerate(np.diff(table["t"], append=table["t"].iloc[-1])):
        assert host.set(**table.loc[i, host.inputs]) == OK
        if i == 0:
            assert host.call("ExitInitializationMode") == OK
        shown.append(host.get(*host.outputs, *SLIPS))
        assert size == 0.0 or host.step(table["t"][i], size) == OK
    assert distance(np.array(shown), expected[[*host.outputs, *SLIPS]].to_numpy()) < 1e-9


def test_initialization_is_steady_and_stays_so(hosts, tires, lagging, fmi):
    host = hosts(lagging, fmi)
    host.initialize()
    host.set(**STRAIGHT)
    assert distance(host.forces(**POINT), steady(tires, lagging, **POINT)) < 1e-9
    host.call("ExitInitializationMode")
    for k in range(3):
        assert distance(host.get(*host.outputs), steady(tires, lagging, **POINT)) < 1e-9
        assert host.step(0.1 * k, 0.1) == OK


def test_without_a_length_a_slip_acts_at_once(hosts, tires):
    host = hosts("rolling", 3).start()
    host.set(**POINT)
    assert host.get("kappa_lagged")[0] == 0.0
    assert host.set(SIGX=0.0) == OK
    assert host.get("kappa_lagged")[0] == POINT["kappa"]
    assert host.set(SIGY=0.0) == OK
    assert distance(host.get(*host.outputs), steady(tires, "rolling", **POINT)) < 1e-9


def test_a_serialized_slip_of_nan_is_rejected(rolling):
    rolling.set(**POINT)
    assert rolling.step(0.0, 0.01) == OK
    content = rolling.serialized()
    (kappa,) = rolling.get("kappa_lagged")
    position = content.index(struct.pack("d", kappa))  # the state is located before the variable that reports it
    bad = content[:position] + struct.pack("d", np.nan) + content[position + 8 :]
    assert rolling.deserialize(bad)[0] == ERROR
    assert rolling.log[-1] == "the bytes are not a serialized state of this FMU"


def test_derivatives_hold_the_lagging_slips(hosts, tires, lagging, fmi):
    host = hosts(lagging, fmi)
    host.initialize()
    host.set(**POINT)

    def slopes():
        return [host.derivative(host.outputs, [key], [1.0])[1] for key in ("kappa", "alpha", "Fz", "gamma", "PDY1")]

    at_rest = slopes()
    host.call("ExitInitializationMode")
    lagging_slopes = slopes()
    assert np.all(at_rest[0][:3] != 0.0)
    assert not np.any(lagging_slopes[:2])
    np.testing.assert_array_equal(lagging_slopes[2:], at_rest[2:])
    # With other inputs they are derivatives at the lagged slips, not at the inputs.
    host.set(kappa=0.3, alpha=0.3)
    np.testing.assert_array_equal(slopes()[2:], at_rest[2:])
