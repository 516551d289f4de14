"""Modelica packages, compiled and simulated by rumoca: self-test, block with states, derivatives."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from tirefmu.boundary.errors import TirefmuError
from tirefmu.symbolic.printers.languages.program import FUNCTIONS, TOLERANCE
from tirefmu.tires import Tire

from .self_tests import differences

rumoca = pytest.importorskip("rumoca")

RUN = Path(__file__).with_name("run_modelica.py")


def command(name):
    return [sys.executable, str(RUN), f"{name}_selftest.mo"]


def assert_agree(folder, name, functions):
    code, largest = differences(command(name), folder)
    assert code == 0
    assert set(largest) == set(functions)
    for function, difference in largest.items():
        assert 0.0 <= difference <= TOLERANCE[function], (function, difference)


def test_all_functions_with_coefficients_in_a_record(printout):
    """The brush model is small: the compiler repeats the lines for every result. A wrong stored result is found."""
    brush = Tire("brush", {"FNOMIN": 3000.0, "UNLOADED_RADIUS": 0.3})
    folder = printout(brush, "modelica", "brush", functions=FUNCTIONS[:4], values="struct", rows=13)
    assert_agree(folder, "brush", FUNCTIONS[:4])
    path = folder / "brush_selftest.mo"
    head, expected = path.read_text().split("expected[", 1)
    first = expected.split("{")[2].split(",")[0]
    path.write_text(f"{head}expected[{expected.replace(first, '1e9', 1)}")
    run = subprocess.run(command("brush"), cwd=folder, capture_output=True, text=True, check=False)
    assert run.returncode == 1
    assert "forces differ" in run.stderr


@pytest.mark.skipif("TIREFMU_HOSTS" not in os.environ, reason="half a minute: make hosts")
def test_states_derivatives_and_hostile_texts(wet, printout):
    functions = ["forces", "jacobian_inputs", "states"]
    folder = printout(wet, "modelica", "wet", functions=functions, rows=13)
    assert_agree(folder, "mf96", functions)


#: A signal is connected as one of Modelica.Blocks; the other inputs have their values in the declaration.
PROBE = """block Source
  mf61.RealOutput y;
equation
  y = -0.1;
end Source;
model probe
  Source steer;
  mf61.WheelContact wheel(kappa = 0.05, gamma = 0.0, V = 10.0, Fz = 4000.0, p = {p}, phit = 0.0);
  Real Fx; Real Fy; Real rate;
equation
  connect(steer.y, wheel.alpha);
  (Fx, Fy) = mf61.forces(kappa = 0.1*time, alpha = 0.2*time);
  rate = der(Fy);
end probe;
"""


def test_the_block_lags_and_forces_have_a_derivative(mf61, printout):
    late = replace(
        mf61, values={**mf61.values, "SIGX": 0.2, "SIGY": 0.4}, effects={*mf61.has, "relax_lat", "relax_lon"}
    )
    folder = printout(
        late, "modelica", "late", functions=["forces", "jacobian_inputs", "states"], only=["Fx", "Fy"], rows=1
    )
    (folder / "probe.mo").write_text(PROBE.format(p=late.nominal("p")))
    result = rumoca.Session().load(str(folder / "probe.mo"), model="probe").simulate(t=(0.0, 0.2), dt=0.05)
    t = np.array(result.time)
    motion = pd.DataFrame({"t": [-1.0, *t], "kappa": 0.05, "alpha": -0.1, "V": 10.0, "Fz": 4000.0})
    motion.loc[0, ["kappa", "alpha"]] = 0.0
    course = late.evaluate(motion, hold=True).iloc[1:]
    for name in ("kappa_lagged", "Fx", "Fy"):
        np.testing.assert_allclose(result[f"wheel.{name}"], course[name], atol=1e-4 * np.abs(course[name]).max())
    h = 1e-5
    later, earlier = (late.forces(kappa=0.1 * x, alpha=0.2 * x)["Fy"] for x in (t + h, t - h))
    np.testing.assert_allclose(result["rate"], (later - earlier) / (2 * h), rtol=1e-6)


def test_quantities_have_si_types_and_the_block_has_connectors_and_an_icon(mf61, printout):
    """Types and signals are like those of the Modelica standard library, which the package does not need."""
    text = (printout(mf61, "modelica", "types", functions=["forces"], values="struct", rows=1) / "mf61.mo").read_text()
    assert 'type Force = Real(final quantity = "Force", final unit = "N");' in text
    assert "Types.Pressure NOMPRES = " in text
    used = set(re.findall(r"Types\.(\w+)", text))
    assert used <= set(re.findall(r"^    type (\w+) = Real", text, re.MULTILINE))
    function = text[text.index("  function forces") : text.index("  end forces;")]
    assert re.findall(r"^    (?:input|output) Types\.(\w+) (\w+)", function, re.MULTILINE) == [
        ("Angle", "alpha"), ("Angle", "gamma"), ("Force", "Fz"), ("Pressure", "p"), ("Velocity", "V"),
        ("Force", "Fx"), ("Force", "Fy"), ("Torque", "Mz"), ("Torque", "Mx"), ("Torque", "My"),
    ]  # fmt: skip
    assert not re.search(r"^ +(\w+) := (?:\w+\.)?\1;", function, re.MULTILINE)
    block = text[text.index("  block WheelContact") : text.index("  end WheelContact;")]
    assert re.findall(r"^    RealInput (\w+)\(", block, re.MULTILINE) == list(mf61.inputs)
    assert re.findall(r"^    RealOutput (\w+)\(", block, re.MULTILINE) == list(mf61.outputs)
    assert 'RealInput Fz(quantity = "Force", unit = "N")' in block
    assert "annotation(Icon(" in block
    places = re.findall(r"extent = \{\{(-?\d+), (-?\d+)\}", block)
    assert len(set(places)) == len(places) > len(mf61.inputs) + len(mf61.outputs)


def test_coefficients_in_a_file_are_refused(trento, printout):
    with pytest.raises(TirefmuError, match="use --values inline or struct"):
        printout(trento, "modelica", "file", values="file", rows=1)
