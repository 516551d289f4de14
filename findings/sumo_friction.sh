#!/usr/bin/env bash
# SUMO's friction of a lane lowers the speed of its vehicles, but not how hard they brake or accelerate.
#
# Expected:  on a lane of friction 0.2 no vehicle brakes or accelerates by more than 0.2 g = 2 m/s2.
# Happens:   vehicles with the friction device still accelerate by 8 m/s2 and brake by 9 m/s2, what their type allows. Only
#            their highest speed falls, from 30 to 18 m/s; with the model EIDM not even that.
# Matters:   a study of safety on ice has stopping distances of a dry road: 18 m from 18 m/s where friction gives 83 m.
# Source:    libsumo 1.28.0 (2026) on PyPI, run on 2026-11-28. The manual says that the device lowers speeds, not that forces stay.
# Guess written down before: the deceleration is limited by friction times g, or is scaled.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m venv packages
packages/bin/pip install --quiet libsumo==1.28.0 2>/dev/null
cat >ice.py <<'END'
import pathlib

import libsumo

NET = """<net version="1.20"><location netOffset="0,0" convBoundary="0,0,3000,0" origBoundary="0,0,3000,0"
 projParameter="!"/><edge id="road" from="a" to="b" priority="1"><lane id="road_0" index="0" speed="30"
 friction="{friction}" length="3000" shape="0,-1.6 3000,-1.6"/></edge>
<junction id="a" type="dead_end" x="0" y="0" incLanes="" intLanes="" shape="0,0 0,-3.2"/>
<junction id="b" type="dead_end" x="3000" y="0" incLanes="road_0" intLanes="" shape="3000,-3.2 3000,0"/></net>"""
ROUTES = """<routes><vType id="car" carFollowModel="{model}" accel="8" decel="9" sigma="0" speedDev="0"/>
<route id="r" edges="road"/><vehicle id="car" type="car" route="r" depart="0" departSpeed="0"/></routes>"""
STEP = 0.1


def drive(model, friction):
    """Return the speed after 30 s, and the highest acceleration and deceleration, of a car that speeds up and then brakes."""
    pathlib.Path("net.xml").write_text(NET.format(friction=friction))
    pathlib.Path("routes.xml").write_text(ROUTES.format(model=model))
    options = ["-n", "net.xml", "-r", "routes.xml", "--step-length", str(STEP), "--device.friction.probability", "1"]
    options += ["--device.friction.stdDev", "0"]
    libsumo.start(["sumo", *options, "--no-step-log", "--no-warnings"])
    speeds = []
    for step in range(400):
        libsumo.simulationStep()
        speeds.append(libsumo.vehicle.getSpeed("car"))
        if step == 300:
            libsumo.vehicle.setSpeed("car", 0.0)
    libsumo.close()
    changes = [(after - before) / STEP for before, after in zip(speeds, speeds[1:])]
    return speeds[300], max(changes), -min(changes)


for model in ("Krauss", "EIDM"):
    dry, ice = drive(model, 1.0), drive(model, 0.2)
    for name, seen in (("friction 1.0", dry), ("friction 0.2", ice)):
        print(f"{model}, {name}: to {seen[0]:.0f} m/s, accelerates by {seen[1]:.1f} m/s2, brakes by {seen[2]:.1f} m/s2")
    assert min(ice[1:]) > 7.5
    assert (ice[0] < 0.8 * dry[0]) == (model == "Krauss")
END
packages/bin/python ice.py
