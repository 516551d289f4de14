#!/usr/bin/env bash
# An FMU of component-model declares radian and m/s and takes degrees and km/h.
#
# Expected:  FMI exchanges values in `unit`; `displayUnit` is for the screen, with display = factor * value + offset. A
#            slip angle with start "10 deg" is 0.1745 rad at the border, and setting 0.1 means 0.1 rad.
# Happens:   unit="radian" displayUnit="degree" start="10.0": start values, values set and values read are
#            in display units. A host that sets 0.1 for alpha gives the model 0.1 degree; 36 "meter / second" is
#            36 km/h; 20 "kelvin" is 20 degrees Celsius. The factor of the display unit is inverted, too (0.01745 for degrees).
#            fmpy's validation reports no problem.
# Matters:   a tire, whose slip angle is in rad in every file, gets angles 57 times too small, and still gives a plausible force.
# Source:    component-model 0.4.0 (2026-03) and fmpy 0.3.32 on PyPI, run on 2026-11-28.
# Guess written down before: start 10 with the unit deg, and values converted consistently.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m pip install --quiet --target packages component-model==0.4.0 fmpy==0.3.32 2>/dev/null
cat >wheel.py <<'END'
from component_model.model import Model
from component_model.variable import Variable


class Wheel(Model):
    def __init__(self, **options):
        super().__init__("Wheel", "shows what the model gets", "nobody", **options)
        kind = {"causality": "input", "variability": "continuous", "rng": ()}
        self._alpha = Variable(self, "alpha", "slip angle", start="10 deg", **kind)
        self._V = Variable(self, "V", "speed", start="36 km/h", **kind)
        self._T = Variable(self, "T", "temperature", start="20 degC", **kind)
        shown = {"causality": "output", "variability": "continuous", "start": 0.0, "rng": ()}
        self._alpha_got = Variable(self, "alpha_got", "slip angle in the model", **shown)
        self._V_got = Variable(self, "V_got", "speed in the model", **shown)

    def do_step(self, time, step):
        super().do_step(time, step)
        self.alpha_got, self.V_got = self.alpha, self.V
        return True
END
cat >host.py <<'END'
from pathlib import Path

from component_model.model import Model
from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave
from fmpy.validation import validate_fmu

path = str(Model.build("wheel.py"))
description = read_model_description(path)
variables = {variable.name: variable for variable in description.modelVariables}
for name in ("alpha", "V", "T"):
    variable = variables[name]
    print(f"{name}: start {float(variable.start):g}, unit {variable.unit}, display unit {variable.displayUnit}")
fmu = FMU2Slave(guid=description.guid, unzipDirectory=extract(path, str(Path("unzipped").absolute())),
                instanceName="wheel", modelIdentifier=description.coSimulation.modelIdentifier)  # fmt: skip
fmu.instantiate()
fmu.setupExperiment(startTime=0.0)
fmu.enterInitializationMode()
fmu.exitInitializationMode()
fmu.setReal([variables[name].valueReference for name in ("alpha", "V")], [0.1, 36.0])
fmu.doStep(0.0, 0.01)
alpha, speed = fmu.getReal([variables[name].valueReference for name in ("alpha_got", "V_got")])
print(f"set 0.1 and 36; the model has alpha = {alpha:.6f} rad and V = {speed:.3f} m/s")
print("problems by fmpy:", validate_fmu(path))
assert variables["alpha"].unit == "radian" and float(variables["alpha"].start) == 10
assert abs(alpha - 0.001745329) < 1e-8 and abs(speed - 10) < 1e-9
END
PYTHONPATH=packages python3 host.py
