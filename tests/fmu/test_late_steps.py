"""Steps late in a simulation: their results depend on the inputs, not on the time."""

from __future__ import annotations

import numpy as np
import pytest

from tirefmu.fmu.description.interface import INPUTS

from .conftest import OK

MOVED = {"alpha": 0.04, "V_y": 0.6, "v_y": -0.6, "T_drive": 300.0}
#: Sizes of steps, s: parts of 1 ms, one part, and sizes that are no multiple of it.
SIZES = (0.001, 0.0002, 0.005, 0.001 / 3)


@pytest.mark.parametrize("inputs", INPUTS)
@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("passed", ["the size", "a difference of times"])
def test_equal_inputs_give_equal_outputs_at_any_time(hosts, inputs, size, passed):
    fmi = 2 if inputs == "hub-torque" else 3
    host = hosts("first", fmi) if inputs == "slip" else hosts("first", fmi, inputs)

    def run(begin):
        assert host.call("Reset") == OK
        host.start(begin, **{name: value for name, value in MOVED.items() if name in host.inputs})
        found = []
        for i in range(40):
            now, then = begin + i * size, begin + (i + 1) * size
            assert host.step(now, size if passed == "the size" else then - now) == OK
            found.append(host.get(*host.outputs))
        return np.array(found)

    early = run(0.0)
    for begin in (1e3, 1e5, 1e7):
        assert np.max(np.abs(run(begin) - early)) <= 1e-9 * np.max(np.abs(early))


@pytest.mark.parametrize("time", [0.0, 1e5])
def test_a_step_of_any_size_advances(hosts, time):
    host = hosts("first", 3, "hub-torque").start(time)
    for size in (5e-324, 1e-300, 1e-12, 0.0025, 20.0):
        assert host.step(time, size) == OK
        time += size
        assert np.all(np.isfinite(host.get(*host.outputs)))
