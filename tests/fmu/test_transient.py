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


@pytest.mark.parametrize("alpha", [2.0, -2.9])
def test_beyond_90_degrees_the_slip_is_that_of_the_supplement(hosts, lagging, fmi, alpha):
    shown = []
    for angle in (alpha, np.copysign(np.pi, alpha) - alpha):
        host = hosts(lagging, fmi).start(**STRAIGHT)
        assert host.set(**POINT | {"alpha": angle}) == OK
        assert host.step(0.0, 0.02) == OK
        shown.append(host.get(*host.outputs, *SLIPS))
    assert distance(np.array(shown[0]), np.array(shown[1])) < 1e-9
