"""Lagged slips: the states of the FMU against the exact solution and the direct evaluation of the tire."""

from __future__ import annotations

import ctypes
import struct

import numpy as np
import pandas as pd
import pytest
from fmpy import simulate_fmu

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


@pytest.fixture
def lengths(tires, lagging):
    """Return a function: the relaxation lengths at a point, m."""
    return lambda **point: tires[lagging].evaluate(pd.DataFrame([point])).iloc[0][["sigma_kappa", "sigma_alpha"]]


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


def test_fmpys_own_simulation(fmus, tires, fmi):
    """fmpy sets inputs, makes a step, and reads the outputs at its end."""
    time = np.linspace(0.0, 0.5, 51)
    inputs = {"kappa": 0.2 * np.sin(20.0 * time), "alpha": 0.3 * np.cos(15.0 * time), "Fz": 4000.0 + 5000.0 * time}
    signal = np.zeros(len(time), dtype=[("time", float), *((key, float) for key in inputs)])
    signal["time"] = time
    for key, values in inputs.items():
        signal[key] = values
    names = list(tires["rolling"].outputs)
    result = simulate_fmu(
        str(fmus["rolling", fmi]), stop_time=0.5, output_interval=0.01, input=signal, output=[*inputs, *names]
    )
    rows = pd.DataFrame({"t": result["time"], **{key: result[key] for key in inputs}})
    # The inputs of a row act in the step that ends at its time; from there on those of the next row act.
    going_on = rows.shift(-1).assign(t=rows["t"]).iloc[:-1]
    table = pd.concat([rows, going_on]).sort_values("t", kind="stable", ignore_index=True)
    reported = tires["rolling"].evaluate(table, hold=True)
    ends = reported[~table["t"].duplicated()]
    assert len(ends) == 51
    assert distance(np.array([result[key] for key in names]), ends[names].to_numpy().T) < 1e-9


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


def test_slips_follow_the_exponential(rolling, lengths):
    sigma = lengths(**POINT).to_numpy()
    assert np.all(sigma > 0.05)
    before = rolling.get(*rolling.outputs)
    assert distance(rolling.forces(**POINT), before) < 0.1 * np.abs(before).max()
    assert rolling.get(*SLIPS).tolist() == [0.0, 0.0]  # a jump of the input is not a jump of the lagged slip
    end = np.array([POINT["kappa"], np.tan(POINT["alpha"])])
    for k in range(1, 30):
        assert rolling.step(0.01 * (k - 1), 0.01) == OK
        expected = end * -np.expm1(-abs(POINT["V"]) * 0.01 * k / sigma)
        kappa, alpha = rolling.get(*SLIPS)
        np.testing.assert_allclose([kappa, np.tan(alpha)], expected, rtol=1e-12)


def test_the_step_size_does_not_matter(hosts, lagging, fmi):
    """Inputs held over 50 ms: one step, 50 steps, or uneven ones."""
    found = []
    cuts = {"one": [0.05], "many": [0.001] * 50, "uneven": [0.02, 1e-6, 0.0033, 0.0266, 0.05 - 0.049901]}
    for sizes in cuts.values():
        host, time = hosts(lagging, fmi).start(), 0.0
        rows = []
        for i in range(12):
            host.set(**POINT | {"kappa": 0.1 * np.sin(i), "alpha": 0.2 * np.cos(2 * i), "V": 8.0 + i})
            for size in sizes:
                assert host.step(time, size) == OK
                time += size
            rows.append(np.concatenate([host.get(*host.outputs), host.get(*SLIPS)]))
        found.append(rows)
    assert distance(np.array(found[1]), np.array(found[0])) < 1e-9
    assert distance(np.array(found[2]), np.array(found[0])) < 1e-9


def test_states_are_constant_at_standstill(rolling):
    rolling.set(**POINT | {"V": 0.0})
    for k in range(3):
        assert rolling.step(10.0 * k, 10.0) == OK
        assert rolling.get(*SLIPS).tolist() == [0.0, 0.0]


def test_backward_rolls_as_far_as_forward(hosts):
    slips = []
    for speed in (9.0, -9.0):
        host = hosts("rolling", 3)
        host.initialize()
        host.set(**STRAIGHT)
        host.call("ExitInitializationMode")
        host.set(**POINT | {"V": speed})
        assert host.step(0.0, 0.03) == OK
        slips.append(host.get(*SLIPS))
    assert np.array_equal(*slips)
    assert np.all(slips[0] != 0.0)


def test_a_long_step_arrives(rolling, tires, lagging):
    rolling.set(**POINT)
    assert rolling.step(0.0, 1e6) == OK
    assert distance(rolling.get(*rolling.outputs), steady(tires, lagging, **POINT)) < 1e-12


def test_without_a_length_a_slip_acts_at_once(hosts, tires):
    host = hosts("rolling", 3).start()
    host.set(**POINT)
    assert host.get("kappa_lagged")[0] == 0.0
    assert host.set(SIGX=0.0) == OK
    assert host.get("kappa_lagged")[0] == POINT["kappa"]
    assert host.set(SIGY=0.0) == OK
    assert distance(host.get(*host.outputs), steady(tires, "rolling", **POINT)) < 1e-9


def test_a_rejected_value_does_not_change_the_slips(rolling):
    rolling.set(**POINT)
    assert rolling.step(0.0, 0.01) == OK
    before = rolling.everything()
    for bad in (np.nan, np.inf):
        for known in ("kappa", "alpha", "V"):
            assert rolling.set(**{known: bad}) == DISCARD
    for size in (0.0, -0.1, np.nan, np.inf):
        assert rolling.step(0.01, size) == ERROR
    assert rolling.set_references(["kappa_lagged"], [0.1]) == ERROR
    assert np.array_equal(rolling.everything(), before)


def saved(host):
    state = ctypes.c_void_p()
    assert host.call("GetFMUState" if host.version == 3 else "GetFMUstate", ctypes.byref(state)) == OK
    return state


def go_on(host):
    """Return the results of a few more steps with the same inputs."""
    found = []
    for k in range(4):
        assert host.step(0.01 * (k + 1), 0.01) == OK
        found.append(host.everything())
    return np.array(found)


def test_slips_are_saved_restored_and_serialized(rolling, hosts, lagging, fmi):
    rolling.set(**POINT)
    assert rolling.step(0.0, 0.01) == OK
    state = saved(rolling)
    content = rolling.fmu.serializeFMUState(state)
    first = go_on(rolling)
    assert rolling.call("SetFMUState" if fmi == 3 else "SetFMUstate", state) == OK
    assert np.array_equal(go_on(rolling), first)
    other = hosts(lagging, fmi)
    copy = other.fmu.deserializeFMUState(content)
    assert other.call("SetFMUState" if fmi == 3 else "SetFMUstate", copy) == OK
    assert np.array_equal(go_on(other), first)
    for owner, stored in ((rolling, state), (other, copy)):
        owner.call("FreeFMUState" if fmi == 3 else "FreeFMUstate", ctypes.byref(stored))


def test_a_serialized_slip_of_nan_is_rejected(rolling, fmi):
    rolling.set(**POINT)
    assert rolling.step(0.0, 0.01) == OK
    state = saved(rolling)
    content = rolling.fmu.serializeFMUState(state)
    rolling.call("FreeFMUState" if fmi == 3 else "FreeFMUstate", ctypes.byref(state))
    (kappa,) = rolling.get("kappa_lagged")
    position = content.index(struct.pack("d", kappa))  # the state is located before the variable that reports it
    bad = content[:position] + struct.pack("d", np.nan) + content[position + 8 :]
    kind = ctypes.c_uint8 if fmi == 3 else ctypes.c_char
    buffer, slot = ctypes.cast(ctypes.create_string_buffer(bad, len(bad)), ctypes.POINTER(kind)), ctypes.c_void_p()
    name = "DeserializeFMUState" if fmi == 3 else "DeSerializeFMUstate"
    assert rolling.call(name, buffer, len(bad), ctypes.byref(slot)) == ERROR
    assert rolling.log[-1] == "the bytes are not a serialized state of this FMU"


def test_reset_clears_the_slips(rolling):
    rolling.set(**POINT)
    assert rolling.step(0.0, 0.5) == OK
    assert np.all(rolling.get(*SLIPS) != 0.0)
    assert rolling.call("Reset") == OK
    rolling.start()
    assert rolling.get(*SLIPS).tolist() == [0.0, 0.0]


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
