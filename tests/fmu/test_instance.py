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

from tirefmu.tires.evaluation import forces

from ..relatives import slow_but
from .conftest import DISCARD, ERROR, OK, PHYSICAL, TIRES, distance
from .solver import Solver

NO_REFERENCE = 4_000_000_000
#: A point of a combined sweep, for tests that need an arbitrary point.
POINT = {"kappa": 0.05, "alpha": -0.08, "gamma": 0.03, "Fz": 900.0}
#: The same for a model with more inputs.
FULL_POINT = POINT | {"p": 2.1e5, "V": 21.0}


def direct(tire, **inputs):
    return np.array([force.item() for force in forces(tire, inputs).values()])  # checks no range


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


@pytest.mark.parametrize("name", slow_but(["first", "mf61", "brush"], [*TIRES, *PHYSICAL]))
def test_output_is_the_direct_evaluation(hosts, tires, name, fmi):
    host = hosts(name, fmi)
    host.initialize()  # until its end every tire is in steady state

    @given(st.fixed_dictionaries({key: ANY_INPUTS[key] for key in host.inputs}))
    def holds(inputs):
        assert distance(host.forces(**inputs), direct(tires[name], **inputs)) < 1e-9

    holds()


def test_starts_at_the_nominal_point(hosts, tires, name, fmi):
    host, tire = hosts(name, fmi).start(time=3.0), tires[name]
    assert host.get(*host.inputs).tolist() == [tire.nominal(key) for key in host.inputs]
    assert distance(host.get(*host.outputs), direct(tire)) < 1e-9


@pytest.mark.parametrize(
    ("name", "coefficient"),
    [("first", "FNOMIN"), ("mf52", "PKY1"), ("mf61", "PDXP1"), ("mf62", "NOMPRES")],
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


# ------------------------------------------------------------------ invalid calls


#: `robust.c` has more of them, for a tire whose slips lag.
@pytest.mark.parametrize(
    ("call", "status", "line"),
    [
        (lambda host: host.set(kappa=0.2, alpha=np.nan), DISCARD, "alpha must be finite"),
        (lambda host: host.set(PKY1=np.inf), DISCARD, "PKY1 must be finite"),
        (lambda host: host.step(0.1, -0.1), ERROR, "the step size must be positive and finite"),
        (lambda host: host.step(0.2, 0.1), ERROR, "the last one ended at"),
        (lambda host: host.step(0.1, 2.0), ERROR, "stop time"),
        (lambda host: host.set_references(["kappa", NO_REFERENCE], [0.1, 1.0]), ERROR, f"reference {NO_REFERENCE}"),
        (lambda host: host.read([NO_REFERENCE])[0], ERROR, f"reference {NO_REFERENCE}"),
        (lambda host: host.set_references(["kappa", "Fx"], [0.1, 1.0]), ERROR, "Fx cannot be set"),
        (lambda host: host.set_references(["kappa", 0], [0.1, 1.0]), ERROR, " cannot be set"),
        (lambda host: host.call("ExitInitializationMode"), ERROR, "not while stepping"),
    ],
)
def test_a_refused_call_changes_nothing_and_is_explained(host, call, status, line):
    host.start(stop=2.0)
    assert host.set(**POINT) == host.step(0.0, 0.1) == OK
    before = host.everything()
    assert call(host) == status
    assert line in host.log[-1]
    assert np.array_equal(host.everything(), before)
    assert host.step(0.1, 1.9) == OK


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


def test_rounding_of_the_host_is_not_a_gap(running):
    for i in range(1000):
        assert running.step(i / 1000, 1 / 1000) == OK


def test_types_that_the_fmu_lacks(running):
    kind, extra = ("Int32", (1,)) if running.version == 3 else ("Integer", ())
    reference, value = running.references(["kappa"]), (ctypes.c_int * 1)(1)
    for access in ("Get", "Set"):
        assert running.call(f"{access}{kind}", reference, 1, value, *extra) == ERROR
        assert running.log[-1] == f"this FMU has no variables of type {kind}"
        assert running.call(f"{access}{kind}", reference, 0, value, *[0 for _ in extra]) == OK


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


def test_a_serialized_state_restores_everything_in_another_instance(hosts, fmi):
    instance, other = hosts("first", fmi).start(), hosts("first", fmi)
    instance.set(PDX1=instance.get("PDX1")[0] * 1.02, **POINT)
    assert instance.step(0.0, 0.25) == OK
    content = instance.serialized()
    other.start().set(PKX1=other.get("PKX1")[0] * 0.9, kappa=-0.3, Fz=100.0)
    force = struct.pack("d", *instance.get("Fx"))
    assert force in content
    status, state = other.deserialize(content.replace(force, bytes(8)))  # computed values are computed again
    assert status == other.restore(state) == OK
    assert np.array_equal(other.everything(), instance.everything())
    assert other.step(0.25, 0.25) == instance.step(0.25, 0.25) == OK  # the time is restored, too
    assert other.serialized() == instance.serialized()
    other.free(state)
    assert other.restore(state) == ERROR
    assert hosts("second", fmi).deserialize(content)[0] == ERROR


@pytest.mark.parametrize("way", [-1.0, 1.0])
def test_a_serialized_value_outside_its_limits_is_rejected(hosts, fmi, way):
    host = hosts("first", fmi)
    variable, start = host.variables["PCY1"], 1.2345678
    assert host.set(PCY1=start) == OK
    content = host.start().serialized()
    position = content.index(struct.pack("d", start))
    limit = float(variable.max if way > 0 else variable.min)
    for value, status in ((limit, OK), (limit + way * 1e-9, ERROR)):
        answer, state = host.deserialize(content[:position] + struct.pack("d", value) + content[position + 8 :])
        assert answer == status
        assert (state.value is None) == (status == ERROR)
        host.free(state)


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


# ----- NULL pointers of a host, and finite inputs that no tire has: statuses instead of a crash or of results like NaN


SPEEDS = {"V_x": 14.0, "V_y": 0.4, "omega": 40.0}


# ------------------------------------------------------------------ NULL


def refused(host, before, *calls):
    """Check that each call is an error with a reason and changes nothing."""
    for name, *arguments in calls:
        logged = len(host.log)
        assert host.call(name, *arguments) == ERROR, (name, arguments)
        assert "NULL" in host.log[logged], name
    np.testing.assert_array_equal(host.everything(), before)


def test_null_pointers_are_errors(hosts, fmi):
    host = hosts("rolling", fmi).start()
    slip, force, n, values = host.references(["kappa"]), host.references(["Fx"]), 1, (ctypes.c_double * 1)(0.1)
    kind, size = ("Float64", (n,)) if fmi == 3 else ("Real", ())  # the number of values stands behind them in FMI 3
    either = ((None, values), (values, None))
    calls = [(f"{verb}{kind}", slip, n, None, *size) for verb in ("Get", "Set")]
    calls += [(f"{verb}{kind}", None, n, values, *size) for verb in ("Get", "Set")]
    calls += [("GetDirectionalDerivative", force, n, slip, n, a, *size, b, *size) for a, b in either]
    if fmi == 3:
        calls += [("GetAdjointDerivative", force, n, slip, n, a, n, b, n) for a, b in either]
        calls += [("GetDirectionalDerivative", None, n, slip, n, values, n, values, n)]
        calls += [("GetNumberOfContinuousStates", None), ("GetNumberOfEventIndicators", None)]
    else:
        calls += [("GetRealStatus", 2, None), ("GetBooleanStatus", 3, None), ("GetStatus", 0, None)]
    refused(host, host.everything(), *calls, ("SetDebugLogging", True, n, None))
    assert host.call("GetFMUState" if fmi == 3 else "GetFMUstate", None) == ERROR
    assert host.step(0.0, 0.1) == OK


def test_null_pointers_are_errors_in_model_exchange(fmus, fmi, tmp_path):
    solver = Solver(fmus["rolling", fmi], tmp_path).start()
    fmu, version = solver.fmu, f"fmi{fmi}"

    def status(name, *arguments):
        return solver.call(f"{version}{name}", fmu.component, *arguments)

    if fmi == 3:
        assert status("UpdateDiscreteStates", None, None, None, None, None, None) == ERROR
        rates = "GetContinuousStateDerivatives"
    else:
        assert status("NewDiscreteStates", None) == ERROR
        rates = "GetDerivatives"
    solver.update()
    assert solver.call("enterContinuousTimeMode") == OK
    for name in ("GetContinuousStates", "SetContinuousStates", "GetNominalsOfContinuousStates", rates):
        assert status(name, None, 2) == ERROR, name
    assert status("CompletedIntegratorStep", True, None, None) == ERROR
    assert solver.set_states(0.01, 0.02) == OK
    fmu.freeInstance()


# ------------------------------------------------------------------ huge


@pytest.mark.parametrize("huge", [1e100, 1e150, 1e300, 1.7e308])
def test_huge_inputs_have_finite_results_or_are_refused(hosts, wheels, fmi, huge):
    for host in (wheels("mf61", fmi).start(), hosts("rolling", fmi).start(), hosts("first", fmi).start()):
        sane = {name: host.get(name)[0] for name in host.inputs}
        time, refusals = 0.0, 0
        for name in host.inputs:
            for value in (huge, -huge):
                assert host.set(**{name: value}) in (OK, DISCARD)
                for shown in (*host.outputs, *host.extras):
                    status, (value_shown,) = host.read([shown])
                    assert status == (OK if np.isfinite(value_shown) else DISCARD), (name, shown)
                    refusals += status == DISCARD
                status = host.step(time, 0.01)
                assert status in (OK, DISCARD)
                time += 0.01 if status == OK else 0.0
                status, slopes = host.derivative(["Fx", "Fy"], [name], [1.0])
                assert status == (OK if np.all(np.isfinite(slopes)) else DISCARD)
                assert host.set(**sane) == OK
                lagged = host.variables.keys() & {"kappa_lagged", "tan_alpha_lagged", "twist"}
                assert np.all(np.isfinite(host.get(*lagged)))
        assert (refusals > 0) == any("would be" in line for line in host.log)
        assert refusals > 0 or huge < 1e150


def test_a_refused_result_leaves_the_tire_usable(wheels, fmi):
    host = wheels("mf61", fmi).start()
    host.set(**SPEEDS)
    assert host.step(0.0, 0.05) == OK
    before = host.everything()
    assert host.set(omega=1e150) == OK
    assert host.read(["kappa"])[0] == DISCARD
    assert host.step(0.05, 0.05) == DISCARD
    assert host.set(**SPEEDS) == OK
    np.testing.assert_array_equal(host.everything(), before)
