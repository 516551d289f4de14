#!/usr/bin/env bash
# A CAN log whose header says "timestamps relative" loses its clock: dbckit returns steps as times.
#
# Expected:  Vector's ASC format has two kinds of times, which its second line states: "absolute" since the start of the measurement, "relative"
#            to the line before. Both logs below are one recording, and decode to the same times.
# Happens:   the times of the relative log are its steps: 0.01, 0.01, 0.01, 0.02 s instead of 0.01, 0.02, 0.03, 0.05 s, without an
#            error; the signals are right. If capkit, of the same authors, is installed beside dbckit, the same call on the same
#            file is refused with a clear line.
# Matters:   a yaw rate or a wheel speed over such times is a cloud at one instant; sorted by time, as before a merge with
#            another log, the order of the samples is lost, too. What a script makes of a log depends on what else is installed.
# Source:    dbckit 1.1.1 and capkit 0.3.0 on PyPI, run on 2026-11-29. The page of dbckit has logs of .asc "built in".
# Guess written down before: the steps are added up.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m pip install --quiet --target packages dbckit==1.1.1 2>/dev/null
python3 -m pip install --quiet --target beside --no-deps capkit==0.3.0 2>/dev/null
cat >car.dbc <<'END'
VERSION ""

NS_ :

BS_:

BU_: Box

BO_ 775 Motion: 2 Box
 SG_ Yaw_rate : 7|16@0- (0.01,0) [0|0] "deg/s" Box

END
cat >times.py <<'END'
import sys

import dbckit

DATE = "Sat Nov 28 10:00:00 2026"
HEADER = f"date {DATE}\nbase hex  timestamps {{}}\nno internal events logged\nBegin Triggerblock {DATE}\n"
TIMES, STEPS = [0.01, 0.02, 0.03, 0.05], [0.01, 0.01, 0.01, 0.02]
for kind, stamps in (("absolute", TIMES), ("relative", STEPS)):
    frames = [f"   {stamp:.6f} 1  307             Rx   d 2 0{row} 00\n" for row, stamp in enumerate(stamps, 1)]
    with open(f"{kind}.asc", "w") as file:
        file.writelines([HEADER.format(kind), *frames, "End TriggerBlock\n"])


def decoded(kind):
    """Return times and yaw rates of a log, or the error."""
    try:
        frames = list(dbckit.decode_log(dbckit.load("car.dbc"), f"{kind}.asc"))
    except ValueError as error:
        return str(error)
    return [frame.timestamp for frame in frames], [frame.signals["Yaw_rate"] for frame in frames]


RATES = [2.56, 5.12, 7.68, 10.24]
absolute, relative = decoded("absolute"), decoded("relative")
print(f"{sys.argv[1]}: absolute {absolute}")
print(f"{sys.argv[1]}: relative {relative}")
assert absolute == (TIMES, RATES)
assert relative == (STEPS, RATES) if sys.argv[1] == "alone" else "not supported" in relative
END
PYTHONPATH=packages python3 times.py alone
PYTHONPATH=packages:beside python3 times.py "with capkit"
