#!/usr/bin/env bash
# A container that FMU Manipulation Toolbox makes of an SSP has none of its unit conversions and parameters.
#
# Expected:  a system structure (SSP 1.0) gives its first component the parameter k = 3 and converts rad to deg on the connection to the
#            second one. The container computes with both, or is refused.
# Happens:   it is built without a word on either: 0.1 rad becomes 0.1 instead of 17.19 (k = 3, 57.3 deg/rad), whether the system
#            has the parameter, the conversion, both or none.
# Matters:   an SSP is how a car with four tires states which tire has which friction or radius: all of them have the start values of
#            their FMUs, and an angle reaches a model in the other unit. The container runs and looks right.
# Source:    fmu-manipulation-toolbox 2.0 on PyPI, run on 2026-11-29; FMUs by pythonfmu 0.6.9, simulated by fmpy 0.3.32. It calls reading
#            SSP "ALPHA stage" and names no limit.
# Guess written down before: both are applied, or the container is refused.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m pip install --quiet --target packages fmu-manipulation-toolbox==2.0 pythonfmu==0.6.9 fmpy==0.3.32 2>/dev/null
export PYTHONPATH=$folder/packages
cat >gain.py <<'END'
from pythonfmu import Fmi2Causality, Fmi2Slave, Fmi2Variability, Real


class Gain(Fmi2Slave):
    def __init__(self, **options):
        super().__init__(**options)
        self.x, self.y, self.k = 0.0, 0.0, 1.0
        self.register_variable(Real("x", causality=Fmi2Causality.input, start=0.0))
        self.register_variable(Real("k", causality=Fmi2Causality.parameter, variability=Fmi2Variability.tunable, start=1.0))
        self.register_variable(Real("y", causality=Fmi2Causality.output))

    def do_step(self, time, step):
        self.y = self.k * self.x
        return True
END
python3 -m pythonfmu build -f gain.py >build.log 2>&1
cat >systems.py <<'END'
import zipfile

import fmpy
import numpy as np

NAMES = "".join(f' xmlns:{short}="http://ssp-standard.org/SSP1/SystemStructure{name}"' for short, name in
                (("ssd", "Description"), ("ssc", "Common"), ("ssv", "ParameterValues")))
PARAMETER = '<ssv:Parameter name="k"><ssv:Real value="3"/></ssv:Parameter>'
SET = f'<ssv:ParameterSet version="1.0" name="first"><ssv:Parameters>{PARAMETER}</ssv:Parameters></ssv:ParameterSet>'
BINDING = (f"<ssd:ParameterBindings><ssd:ParameterBinding><ssd:ParameterValues>{SET}</ssd:ParameterValues>"
           "</ssd:ParameterBinding></ssd:ParameterBindings>")
FACTOR = '<ssc:LinearTransformation factor="57.29577951308232" offset="0"/>'


def connectors(**kinds):
    texts = [f'<ssd:Connector name="{name}" kind="{kind}"><ssc:Real/></ssd:Connector>' for name, kind in kinds.items()]
    return f"<ssd:Connectors>{''.join(texts)}</ssd:Connectors>"


def component(name, binding=""):
    inside = connectors(x="input", y="output", k="parameter") + binding
    source = 'type="application/x-fmu-sharedlibrary" source="resources/Gain.fmu"'
    return f'<ssd:Component name="{name}" {source}>{inside}</ssd:Component>'


def write(name, binding, factor):
    system = f"""<?xml version="1.0" encoding="UTF-8"?>
<ssd:SystemStructureDescription name="car" version="1.0"{NAMES}><ssd:System name="root">{connectors(angle="input", result="output")}
<ssd:Elements>{component("first", binding)}{component("second")}</ssd:Elements>
<ssd:Connections><ssd:Connection startConnector="angle" endElement="first" endConnector="x"/>
<ssd:Connection startElement="first" startConnector="y" endElement="second" endConnector="x">{factor}</ssd:Connection>
<ssd:Connection startElement="second" startConnector="y" endConnector="result"/></ssd:Connections>
</ssd:System></ssd:SystemStructureDescription>"""
    with zipfile.ZipFile(f"{name}.ssp", "w") as archive:
        archive.writestr("SystemStructure.ssd", system)
        archive.write("Gain.fmu", "resources/Gain.fmu")


def simulated(name):
    angle = np.array([(0.0, 0.1), (1.0, 0.1)], dtype=[("time", float), ("angle", float)])
    result = fmpy.simulate_fmu(f"{name}.fmu", stop_time=0.1, output_interval=0.01, input=angle, output=["result"])
    return float(result["result"][-1])


CASES = {"none": ("", "", 0.1), "parameter": (BINDING, "", 0.3), "conversion": ("", FACTOR, 5.7296),
         "both": (BINDING, FACTOR, 17.1887)}  # fmt: skip
if __name__ == "__main__":
    import sys

    for name, (binding, factor, right) in CASES.items():
        if sys.argv[1] == "write":
            write(name, binding, factor)
        else:
            result = simulated(name)
            print(f"{name}: 0.1 rad becomes {result:.4g}; right is {right:.4g}")
            assert abs(result - 0.1) < 1e-9
END
python3 systems.py write
for name in none parameter conversion both; do
    packages/bin/fmucontainer -container "$name.ssp:0.01" >>containers.log 2>&1
done
python3 systems.py simulate 2>/dev/null | grep becomes
