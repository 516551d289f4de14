#!/usr/bin/env bash
# A system (SSP) that pyssp-standard only renames loses the transformations of its connections: it steers to the other side.
#
# Expected:  a system structure is opened for a change and gets another name; everything else of the file stays as it is.
# Happens:   all connections are written without LinearTransformation and suppressUnitConversion. Steering with another sign and an offset,
#            in place of the conversion of its unit, has the conversion only; a load that was not to be converted is converted. The units
#            follow the default experiment, so that the package's own check of the standard refuses the file that it has written.
# Matters:   programs that do not check read it without a word: -0.1645 rad of slip angle at 10 deg of steering become +0.1745 rad. A
#            system that was checked before a parameter or a name was changed is another one afterwards. Compare the connections
#            of both files, or change the text of the file.
# Source:    pyssp-standard 0.9.1 (June 2026) on PyPI, run on 2026-11-30. Its page: "reading, modifying and creating files,
#            specified in the SSP Standard".
# Guess written down before: the linear transformation of a connection survives reading and writing.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m pip install --quiet --target packages pyssp-standard==0.9.1 lxml==6.0.2 xmlschema==4.1.0 pint==0.25.2 2>/dev/null
cat >rename.py <<'END_OF_PYTHON'
import math
import xml.etree.ElementTree as ElementTree

from pyssp_standard.ssd import SSD

NAMESPACES = "".join(
    f' xmlns:{short}="http://ssp-standard.org/SSP1/SystemStructure{name}"' for short, name in (("ssd", "Description"), ("ssc", "Common"))
)


def connector(name, unit):
    return f'<ssd:Connector name="{name}" kind="input"><ssc:Real unit="{unit}"/></ssd:Connector>'


SYSTEM = f"""<?xml version="1.0" encoding="UTF-8"?>
<ssd:SystemStructureDescription{NAMESPACES} name="car" version="1.0">
  <ssd:System name="car">
    <ssd:Connectors>{connector("steer", "deg")}{connector("load", "kN")}</ssd:Connectors>
    <ssd:Elements>
      <ssd:Component name="tire" source="resources/tire.fmu">
        <ssd:Connectors>{connector("alpha", "rad")}{connector("Fz", "N")}</ssd:Connectors>
      </ssd:Component>
    </ssd:Elements>
    <ssd:Connections>
      <ssd:Connection startConnector="steer" endElement="tire" endConnector="alpha" suppressUnitConversion="true">
        <ssc:LinearTransformation factor="{-math.radians(1.0)!r}" offset="0.01"/>
      </ssd:Connection>
      <ssd:Connection startConnector="load" endElement="tire" endConnector="Fz" suppressUnitConversion="true"/>
    </ssd:Connections>
  </ssd:System>
  <ssd:Units>
    <ssc:Unit name="deg"><ssc:BaseUnit rad="1" factor="{math.radians(1.0)!r}"/></ssc:Unit>
    <ssc:Unit name="rad"><ssc:BaseUnit rad="1"/></ssc:Unit>
    <ssc:Unit name="N"><ssc:BaseUnit kg="1" m="1" s="-2"/></ssc:Unit>
    <ssc:Unit name="kN"><ssc:BaseUnit kg="1" m="1" s="-2" factor="1000"/></ssc:Unit>
  </ssd:Units>
  <ssd:DefaultExperiment startTime="0" stopTime="10"/>
</ssd:SystemStructureDescription>
"""
PREFIX = "{http://ssp-standard.org/SSP1/SystemStructure%s}"


def received(path, sent):
    """Return what the inputs of the tire receive, by the standard."""
    root, values = ElementTree.parse(path).getroot(), {}
    factors = {unit.get("name"): float(unit[0].get("factor", 1.0)) for unit in root.iter(PREFIX % "Common" + "Unit")}
    units = {c.get("name"): factors[c[0].get("unit")] for c in root.iter(PREFIX % "Description" + "Connector")}
    for connection in root.iter(PREFIX % "Description" + "Connection"):
        begin, end = connection.get("startConnector"), connection.get("endConnector")
        linear = connection.find(PREFIX % "Common" + "LinearTransformation")
        converted = connection.get("suppressUnitConversion") != "true"
        value = sent[begin] * (units[begin] / units[end] if converted else 1.0)
        if linear is not None:  # instead of the conversion, or in addition to it
            value = float(linear.get("factor", 1.0)) * value + float(linear.get("offset", 0.0))
        values[end] = round(value, 4)
    return values


def by_the_standard(path):
    try:
        with SSD(path) as system:
            system.__check_compliance__()
    except Exception as error:
        return f"refused ({type(error).__name__})"
    return "accepted"


with open("system.ssd", "w") as file:
    file.write(SYSTEM)
seen = []
for change in ("as it was", "renamed"):
    if change == "renamed":
        with SSD("system.ssd", mode="a") as system:
            system.name = "other car"
    seen.append((received("system.ssd", {"steer": 10.0, "load": 4.0}), by_the_standard("system.ssd")))
    print(f"{change}: 10 deg and 4 kN reach the tire as {seen[-1][0]}; the package's check of the file: {seen[-1][1]}")
assert seen[0] == ({"alpha": -0.1645, "Fz": 4.0}, "accepted")
assert seen[1][0] == {"alpha": 0.1745, "Fz": 4000.0} and seen[1][1].startswith("refused")
END_OF_PYTHON
PYTHONPATH=packages python3 rename.py
