"""NULL pointers of a host, and finite inputs that no tire has: statuses instead of a crash or of results like NaN."""

from __future__ import annotations

import ctypes

import numpy as np
import pytest

from .test_model_exchange import Solver

OK, DISCARD, ERROR = 0, 2, 3
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
    known, unknown, n, values = host.references(["kappa"]), host.references(["Fx"]), 1, (ctypes.c_double * 1)(0.1)
    kind, size = ("Float64", (n,)) if fmi == 3 else ("Real", ())  # the number of values stands behind them in FMI 3
    either = ((None, values), (values, None))
    calls = [(f"{verb}{kind}", known, n, None, *size) for verb in ("Get", "Set")]
    calls += [(f"{verb}{kind}", None, n, values, *size) for verb in ("Get", "Set")]
    calls += [("GetDirectionalDerivative", unknown, n, known, n, a, *size, b, *size) for a, b in either]
    if fmi == 3:
        calls += [("GetAdjointDerivative", unknown, n, known, n, a, n, b, n) for a, b in either]
        calls += [("GetDirectionalDerivative", None, n, known, n, values, n, values, n)]
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
                    status, (found,) = host.read([shown])
                    assert status == (OK if np.isfinite(found) else DISCARD), (name, shown)
                    refusals += status == DISCARD
                status = host.step(time, 0.01)
                assert status in (OK, DISCARD)
                time += 0.01 if status == OK else 0.0
                status, found = host.derivative(["Fx", "Fy"], [name], [1.0])
                assert status == (OK if np.all(np.isfinite(found)) else DISCARD)
                assert host.set(**sane) == OK
                lagged = [each for each in ("kappa_lagged", "tan_alpha_lagged", "twist") if each in host.variables]
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
