"""Lagged slips: the states of the FMU against the exact solution and the direct evaluation of the tire."""

from __future__ import annotations

import struct

import numpy as np
import pandas as pd
import pytest

from tirefmu.fmu import check

OK, DISCARD, ERROR = 0, 2, 3
POINT = {"kappa": 0.06, "alpha": -0.09, "gamma": 0.02, "Fz": 4200.0, "p": 2.3e5, "V": 14.0}
STRAIGHT = POINT | {"kappa": 0.0, "alpha": 0.0}
SLIPS = ("kappa_lagged", "alpha_lagged")


@pytest.fixture
def rolling(hosts, lagging, fmi):
    """Return a host of a lagging tire that has run straight so far."""
    host = hosts(lagging, fmi)
    host.initialize()
    assert host.set(**STRAIGHT) == OK
    assert host.call("ExitInitializationMode") == OK
    return host


def steady(tires, lagging, **point):
    return np.array([float(force) for force in tires[lagging].forces(**point).values()])


def distance(found, expected):
    return np.max(np.abs(found - expected) / (1.0 + np.abs(expected)))


def recording(n, seed):
    """Return rows of all kinds of motion of a wheel, some of them at equal times."""
    rng = np.random.default_rng(seed)
    speed = np.where(rng.random(n) < 0.2, rng.choice([0.0, -5.0, -0.01, 60.0], n), rng.uniform(1.0, 30.0, n))
    return pd.DataFrame(
        {
            "t": np.cumsum(np.where(rng.random(n) < 0.1, 0.0, rng.uniform(1e-4, 0.05, n))),
            "kappa": rng.uniform(-1.0, 1.5, n),
            "alpha": rng.uniform(-1.5, 1.5, n),
            "gamma": rng.uniform(-0.2, 0.2, n),
            "Fz": np.where(rng.random(n) < 0.1, rng.choice([0.0, -300.0, 1e-9], n), rng.uniform(50.0, 9000.0, n)),
            "p": rng.uniform(1.5e5, 3e5, n),
            "V": speed,
            "phit": rng.choice([0.0, 0.05, -0.2], n),
        }
    )


def test_it_is_the_evaluation_with_inputs_held(fmus, tires, lagging, fmi):
    table = recording(400, 11)
    tire = tires[lagging]
    at_once = tire.evaluate(table, steady=True)[list(tire.outputs)]
    result = check(fmus[lagging, fmi], table.assign(**at_once))
    assert result.ok
    assert result.evaluation_difference < 1e-9
    assert result.channels[0].rmse > 100.0  # the lag has an influence


def test_conventions_reach_the_lengths_too(hosts, tires):
    table, host, tire = recording(150, 13), hosts("rolling", 3), tires["rolling"]
    expected = tire.evaluate(table, convention="book", slip_angle="angle", limits=True, hold=True)
    host.initialize(time=table["t"][0])
    assert host.set(CONVENTION=1.0, SLIP_ANGLE=1.0, LIMITS=1.0) == OK
    found = []
    for i, size in enumerate(np.diff(table["t"], append=table["t"].iloc[-1])):
        assert host.set(**table.loc[i, host.inputs]) == OK
        if i == 0:
            assert host.call("ExitInitializationMode") == OK
        found.append(host.get(*host.outputs, *SLIPS))
        assert size == 0.0 or host.step(table["t"][i], size) == OK
    assert distance(np.array(found), expected[[*host.outputs, *SLIPS]].to_numpy()) < 1e-9


def test_every_segment_begins_in_steady_state(fmus, tires):
    runs = recording(300, 12)
    runs = pd.concat([runs, runs.assign(t=runs["t"] + 500.0, kappa=-0.6 * runs["kappa"])], ignore_index=True)
    result = check(fmus["rolling", 3], runs.assign(Fx=0.0))
    assert result.segments == 2
    assert result.evaluation_difference < 1e-9
    first = steady(tires, "rolling", **runs.drop(columns="t").iloc[300])
    assert distance(result.simulated.iloc[300].to_numpy(), first) < 1e-9


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
    names = ["kappa", "alpha", "Fz", "gamma", "PDY1"]
    steady_ones = [host.derivative(host.outputs, [key], [1.0])[1] for key in names]
    host.call("ExitInitializationMode")
    rolling_ones = [host.derivative(host.outputs, [key], [1.0])[1] for key in names]
    assert np.all(steady_ones[0][:3] != 0.0)
    assert not np.any(rolling_ones[:2])
    np.testing.assert_array_equal(rolling_ones[2:], steady_ones[2:])
    # With other inputs they are derivatives at the lagged slips, not at the inputs.
    host.set(kappa=0.3, alpha=0.3)
    np.testing.assert_array_equal(
        [host.derivative(host.outputs, [key], [1.0])[1] for key in names[2:]], steady_ones[2:]
    )
