"""Valid and invalid calls of an instance of the FMU, in both versions."""

from __future__ import annotations

import ctypes
import struct
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from fmpy import extract, read_model_description
from fmpy.fmi1 import FMICallException
from fmpy.fmi2 import FMU2Model, FMU2Slave, fmi2CallbackFunctions, fmi2CallbackLoggerTYPE
from fmpy.fmi3 import FMU3Model, FMU3Slave
from hypothesis import given
from hypothesis import strategies as st

OK, DISCARD, ERROR = 0, 2, 3
INPUTS = ("kappa", "alpha", "gamma", "Fz")
OUTPUTS = ("Fx", "Fy", "Mz")
#: A point of a combined sweep, for tests that need an arbitrary point.
POINT = {"kappa": 0.05, "alpha": -0.08, "gamma": 0.03, "Fz": 900.0}
#: The same for a model with more inputs.
FULL_POINT = POINT | {"p": 2.1e5, "V": 21.0}


def direct(tire, **inputs):
    rows = {name: np.atleast_1d(value) for name, value in inputs.items()}  # as an array: no range is checked
    return np.array([force.item() for force in tire.forces(**rows).values()])


def distance(found, expected):
    return np.max(np.abs(found - expected) / (1.0 + np.abs(expected)))


# ------------------------------------------------------------------ values

#: Far beyond any tire's range, on both sides of standstill and of the load that lifts the wheel.
ANY_INPUTS = {
    "kappa": st.floats(-10.0, 10.0),
    "alpha": st.floats(-1.57, 1.57),
    "gamma": st.floats(-1.0, 1.0),
    "Fz": st.floats(-2000.0, 20000.0),
    "p": st.floats(1e4, 1e6),
    "V": st.floats(-80.0, 80.0),
    "phit": st.floats(-1.0, 1.0),
}


def test_output_is_the_direct_evaluation(hosts, tires, name, fmi):
    host = hosts(name, fmi)
    host.initialize()  # until its end every tire is in steady state

    @given(st.fixed_dictionaries({key: ANY_INPUTS[key] for key in host.inputs}))
    def holds(inputs):
        assert distance(host.forces(**inputs), direct(tires[name], **inputs)) < 1e-9

    holds()


def test_both_versions_give_the_same_digits(hosts):
    hosts_of_both = [hosts("first", fmi).start() for fmi in (2, 3)]
    draws = np.random.default_rng(1).uniform([-0.5, -0.5, -0.1, -100.0], [0.5, 0.5, 0.1, 3000.0], (500, 4))
    two, three = ([h.forces(**dict(zip(INPUTS, row, strict=True))) for row in draws] for h in hosts_of_both)
    assert np.array_equal(two, three)


def test_starts_at_the_nominal_point(hosts, tires, name, fmi):
    host, tire = hosts(name, fmi).start(time=3.0), tires[name]
    assert host.get(*host.inputs).tolist() == [tire.nominal(key) for key in host.inputs]
    assert distance(host.get(*host.outputs), direct(tire)) < 1e-9


def test_outputs_follow_inputs_before_any_step(host, tires):
    host.initialize()
    assert distance(host.forces(**POINT), direct(tires["first"], **POINT)) < 1e-9
    host.call("ExitInitializationMode")
    at_zero = POINT | {"kappa": 0.0}
    assert distance(host.forces(kappa=0.0), direct(tires["first"], **at_zero)) < 1e-9


def test_a_lifted_wheel_has_no_forces(hosts, name):
    running = hosts(name, 3).start()
    for load in (0.0, -0.0, -500.0):
        assert not np.any(running.forces(**POINT | {"Fz": load}))


def test_standstill_and_reverse(hosts, tires):
    host = hosts("mf61", 3).start()
    for speed in (0.0, -0.0, 1e-300, -1e-300, 0.3, -0.3, -20.0):
        for turn in (0.0, 0.2):
            point = FULL_POINT | {"V": speed, "phit": turn}
            found = host.forces(**point)
            assert np.all(np.isfinite(found))
            assert distance(found, direct(tires["mf61"], **point)) < 1e-9


@pytest.mark.parametrize(
    ("name", "coefficient"),
    [
        ("first", "PDY1"),
        ("first", "LMUX"),
        ("first", "FNOMIN"),
        ("first", "QDZ1"),
        ("mf52", "PKY1"),
        ("mf61", "LMUY"),
        ("mf61", "PDXP1"),
        ("mf62", "NOMPRES"),
    ],
)
def test_coefficients_are_tunable_at_any_time(hosts, tires, fmi, name, coefficient):
    host, tire = hosts(name, fmi), tires[name]
    point = POINT if name == "first" else FULL_POINT | ({"phit": 0.05} if name == "mf61" else {})
    for moment in ("instantiated", "initializing", "stepping"):
        if moment == "initializing":
            host.initialize()
        elif moment == "stepping":
            host.call("ExitInitializationMode")
            assert host.step(0.0, 0.1) == OK
        before = host.forces(**point)
        value = host.get(coefficient)[0] * 1.1
        assert host.set(**{coefficient: value}) == OK
        tire = replace(tire, values={**tire.values, coefficient: value})
        assert distance(host.get(*host.outputs), direct(tire, **point)) < 1e-9
        assert np.any(host.get(*host.outputs) != before)


@pytest.mark.parametrize(
    ("parameter", "options"),
    [("CONVENTION", {"convention": "book"}), ("SLIP_ANGLE", {"slip_angle": "angle"}), ("LIMITS", {"limits": True})],
)
def test_conventions_are_parameters(hosts, tires, parameter, options):
    host = hosts("mf61", 3).start()
    tire = replace(tires["mf61"], values={**tires["mf61"].values, "LMUY": 0.8})
    point = FULL_POINT | {"alpha": 0.4, "gamma": 0.3, "kappa": -0.2}
    host.set(LMUY=0.8)
    for value, reported in ((0.0, {}), (1.0, options), (0.0, {})):
        assert host.set(**{parameter: value}) == OK
        row = tire.evaluate(pd.DataFrame([point]), **reported).iloc[0]
        assert distance(host.forces(**point), row[host.outputs].to_numpy()) < 1e-9
    assert host.set(**{parameter: 2.0}) == DISCARD
    plain, other = (tire.evaluate(pd.DataFrame([point]), **reported)["Fy"][0] for reported in ({}, options))
    assert plain != other


def test_hidden_variables_are_not_accessible(hosts, tires, fmi):
    host = hosts("mf52", fmi).start()
    assert not {"phit", "SIGNS"} & host.variables.keys()
    references = {variable.valueReference for variable in host.variables.values()}
    (hidden,) = set(range(1, max(references))) - references
    assert host.set_references([hidden], [1.0]) == ERROR
    assert host.read([hidden])[0] == ERROR
    assert host.log[-1] == f"there is no value reference {hidden}"


def test_two_instances_are_independent(hosts, tires, fmi):
    first, second = hosts("first", fmi).start(), hosts("second", fmi).start()
    for load in (300.0, 800.0, 1200.0):  # alternately
        point = POINT | {"Fz": load}
        found = [first.forces(**point), second.forces(**point)]
        assert distance(found[0], direct(tires["first"], **point)) < 1e-9
        assert distance(found[1], direct(tires["second"], **point)) < 1e-9
        assert np.all(found[0] != found[1])


# ------------------------------------------------------------------ invalid calls


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("name", ["alpha", "Fz", "PKY1"])
def test_a_value_that_is_not_finite_changes_nothing(running, name, bad):
    running.set(**POINT)
    before = running.everything()
    assert running.set(kappa=0.2, **{name: bad}) == DISCARD
    assert np.array_equal(running.everything(), before)
    assert running.log[-1].startswith(f"{name} must be finite")


def test_a_coefficient_outside_its_limits_changes_nothing(running):
    bounded = [v for v in running.variables.values() if v.causality == "parameter" and v.max is not None]
    assert bounded
    before = running.everything()
    for variable in bounded:
        assert running.set(kappa=0.2, **{variable.name: 2.0 * abs(float(variable.max)) + 1.0}) == DISCARD
        assert running.set(**{variable.name: float(variable.max)}) == OK
        assert running.set(**{variable.name: float(variable.start)}) == OK
    assert np.array_equal(running.everything(), before)
    assert " is outside " in running.log[-1]


@pytest.mark.parametrize("size", [0.0, -0.0, -0.1, np.nan, np.inf, -np.inf])
def test_a_step_size_must_be_positive_and_finite(running, size):
    before = running.everything()
    assert running.step(0.0, size) == ERROR
    assert running.log[-1].startswith("the step size must be positive and finite")
    assert np.array_equal(running.everything(), before)
    assert running.step(0.0, 0.1) == OK


@pytest.mark.parametrize("point", [0.2, 0.0, -0.1, 0.11, np.nan, np.inf])
def test_a_step_starts_where_the_last_one_ended(running, point):
    assert running.step(0.0, 0.1) == OK
    assert running.step(point, 0.1) == ERROR
    assert "the last one ended at" in running.log[-1]
    assert running.step(0.1, 0.1) == OK


def test_rounding_of_the_host_is_not_a_gap(running):
    for i in range(1000):
        assert running.step(i / 1000, 1 / 1000) == OK


def test_no_step_passes_the_stop_time(host):
    host.start(1.0, stop=2.0)
    assert host.step(1.0, 1.5) == ERROR
    assert "stop time" in host.log[-1]
    assert host.step(1.0, 1.0) == OK


def test_unknown_references_and_outputs_cannot_be_set(running):
    before = running.everything()
    for reference in (len(running.variables) + 1, 4_000_000_000):
        assert running.set_references(["kappa", reference], [0.1, 1.0]) == ERROR
        assert running.read([reference])[0] == ERROR
        assert running.log[-1] == f"there is no value reference {reference}"
    for name in ("Fx", "Mz", 0):
        assert running.set_references(["kappa", name], [0.1, 1.0]) == ERROR
        assert running.log[-1].endswith(" cannot be set")
    assert np.array_equal(running.everything(), before)


def test_calls_out_of_order_are_refused(host):
    assert host.step(0.0, 0.1) == ERROR
    assert host.call("ExitInitializationMode") == ERROR
    assert host.call("Terminate") == ERROR
    host.initialize()
    assert host.step(0.0, 0.1) == ERROR
    assert host.log[-1] == "a step is allowed while stepping, not while initializing"
    host.call("ExitInitializationMode")
    assert host.call("Terminate") == OK
    assert host.step(0.0, 0.1) == ERROR
    assert host.set(kappa=0.1) == ERROR
    assert np.all(np.isfinite(host.get(*OUTPUTS)))  # results can still be read


def test_types_that_the_fmu_lacks(running):
    kind, extra = ("Int32", (1,)) if running.version == 3 else ("Integer", ())
    one, value = running.references(["kappa"]), (ctypes.c_int * 1)(1)
    for access in ("Get", "Set"):
        assert running.call(f"{access}{kind}", one, 1, value, *extra) == ERROR
        assert running.log[-1] == f"this FMU has no variables of type {kind}"
        assert running.call(f"{access}{kind}", one, 0, value, *[0 for _ in extra]) == OK


def test_the_log_can_be_chosen(running):
    def choose(on, *categories):
        names = (ctypes.c_char_p * len(categories))(*[name.encode() for name in categories])
        return running.call("SetDebugLogging", on, len(categories), names)

    assert choose(False, "logStatusDiscard") == OK
    running.set(kappa=np.nan)
    assert running.log == []
    running.step(0.0, -1.0)
    assert len(running.log) == 1
    assert choose(True, "logStatusDiscard", "no such category") == ERROR
    running.set(kappa=np.nan)
    assert running.log[1:] == ["unknown log category"]
    assert choose(True) == OK
    running.set(kappa=np.nan)
    assert len(running.log) == 3


# ------------------------------------------------------------------ reset, saved states


def play(host):
    """Return the results of a run: a sweep with a coefficient changed midway."""
    host.start(0.5)
    found = []
    for i, alpha in enumerate(np.linspace(-0.2, 0.2, 21)):
        if i == 10:
            assert host.set(PDY1=host.get("PDY1")[0] * 1.05) == OK
        found.append(host.forces(kappa=0.1 * alpha, alpha=alpha, gamma=0.02, Fz=600.0 + 20.0 * i))
        assert host.step(0.5 + 0.1 * i, 0.1) == OK
    return np.array(found)


def test_reset_runs_again_identically(host):
    once = play(host)
    assert host.step(99.0, 0.1) == ERROR
    assert host.set(alpha=np.nan) == DISCARD
    assert host.call("Reset") == OK
    assert np.array_equal(play(host), once)


def saved(host):
    state = ctypes.c_void_p()
    name = "GetFMUState" if host.version == 3 else "GetFMUstate"
    assert host.call(name, ctypes.byref(state)) == OK
    return state


def restore(host, state):
    return host.call("SetFMUState" if host.version == 3 else "SetFMUstate", state)


def free(host, state):
    name = "FreeFMUState" if host.version == 3 else "FreeFMUstate"
    assert host.call(name, ctypes.byref(state)) == OK
    assert state.value is None


def test_a_saved_state_restores_everything(running):
    running.set(PDY1=running.get("PDY1")[0] * 1.02, **POINT)
    assert running.step(0.0, 0.25) == OK
    before = running.everything()
    state = saved(running)
    running.set(PKX1=running.get("PKX1")[0] * 0.9, kappa=-0.3, Fz=100.0)
    assert running.step(0.25, 0.25) == OK
    assert np.any(running.everything() != before)
    assert restore(running, state) == OK
    assert np.array_equal(running.everything(), before)
    assert running.step(0.25, 0.1) == OK  # including the time
    free(running, state)
    assert restore(running, ctypes.c_void_p()) == ERROR


def test_a_serialized_state_moves_to_another_instance(hosts, fmi):
    one, other = hosts("first", fmi).start(), hosts("first", fmi)
    one.set(PDX1=one.get("PDX1")[0] * 1.02, **POINT)
    assert one.step(0.0, 0.25) == OK
    state = saved(one)
    content = one.fmu.serializeFMUState(state)
    copy = other.fmu.deserializeFMUState(content)
    assert restore(other, copy) == OK
    assert np.array_equal(other.everything(), one.everything())
    assert other.step(0.25, 0.25) == OK
    again = saved(one)
    assert one.fmu.serializeFMUState(again) == content
    for owner, stored in ((one, state), (one, again), (other, copy)):
        free(owner, stored)


def test_arbitrary_bytes_are_rejected_as_a_state(hosts, fmi):
    one, stranger = hosts("first", fmi).start(), hosts("second", fmi).start()
    state = saved(one)
    content = one.fmu.serializeFMUState(state)
    free(one, state)
    before = stranger.everything()
    name = "DeserializeFMUState" if fmi == 3 else "DeSerializeFMUstate"
    kind = ctypes.c_uint8 if fmi == 3 else ctypes.c_char
    for bad in (content, content[:-1], b"", b"\xff" * len(content)):
        buffer = ctypes.cast(ctypes.create_string_buffer(bad, len(bad) + 1), ctypes.POINTER(kind))
        slot = ctypes.c_void_p()
        assert stranger.call(name, buffer, len(bad), ctypes.byref(slot)) == ERROR
        assert slot.value is None
    assert np.array_equal(stranger.everything(), before)


@pytest.mark.parametrize("way", [-1.0, 1.0])
def test_a_serialized_value_outside_its_limits_is_rejected(hosts, fmi, way):
    host = hosts("first", fmi)
    known, start = host.variables["PCY1"], 1.2345678
    assert host.set(PCY1=start) == OK
    host.start()
    state = saved(host)
    content = host.fmu.serializeFMUState(state)
    free(host, state)
    position = content.index(struct.pack("d", start))
    limit = float(known.max if way > 0 else known.min)
    name = "DeserializeFMUState" if fmi == 3 else "DeSerializeFMUstate"
    kind = ctypes.c_uint8 if fmi == 3 else ctypes.c_char
    for value, status in ((limit, OK), (limit + way * 1e-9, ERROR)):
        changed = content[:position] + struct.pack("d", value) + content[position + 8 :]
        buffer = ctypes.cast(ctypes.create_string_buffer(changed, len(changed)), ctypes.POINTER(kind))
        slot = ctypes.c_void_p()
        assert host.call(name, buffer, len(changed), ctypes.byref(slot)) == status
        free(host, slot)


@pytest.mark.parametrize("exchange", [False, True])
@pytest.mark.parametrize("on", [False, True])
def test_the_note_at_the_start_is_logged_on_request_only(fmus, tmp_path, fmi, exchange, on):
    path = str(fmus["first", fmi, "wheel"])
    description = read_model_description(path)
    kinds = {2: (FMU2Slave, FMU2Model), 3: (FMU3Slave, FMU3Model)}[fmi]
    fmu = kinds[exchange](guid=description.guid, unzipDirectory=extract(path, str(tmp_path)),
                          modelIdentifier=description.coSimulation.modelIdentifier, instanceName="wheel")  # fmt: skip
    log = []
    if fmi == 3:
        fmu.instantiate(loggingOn=on, logMessage=lambda _environment, _status, _category, line: log.append(line))
    else:
        callbacks = fmi2CallbackFunctions()
        callbacks.logger = fmi2CallbackLoggerTYPE(
            lambda _environment, _name, _status, _category, line: log.append(line)
        )
        fmu.instantiate(callbacks=callbacks, loggingOn=on)
        fmu.setupExperiment()
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()
    assert [line.startswith(b"the tire has no relaxation") for line in log] == [True] * on
    # A rejected call is logged in any case.
    with pytest.raises(FMICallException):
        fmu.exitInitializationMode()
    assert len(log) == on + 1
    fmu.freeInstance()
