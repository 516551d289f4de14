#!/usr/bin/env bash
# A CAN database that goes through canmatrix's spreadsheet or sym file decodes other numbers.
#
# Expected:  a database of a car (.dbc) that is converted to .xlsx, to be read by people, or to .sym, and back decodes the same frame to the
#            same values, or the conversion is refused.
# Happens:   without a warning on it, signed signals come back from .xlsx without sign and with their minimum as offset, float signals as
#            integers: a steering angle of -123.4 deg is 5650.2 deg, a force of -876.25 N is 2294302208 N. After .sym the angle is right and
#            the force is -1000665088 N.
# Matters:   databases are passed on as spreadsheets, and logs are decoded with what comes back. Positive values of a signal whose
#            minimum is 0 are right, so that speed and engine look as before.
# Source:    canmatrix 1.3.3 on PyPI, decoded by cantools 45.1.0, run on 2026-11-29. Its page states for .xls(x) that it reads files
#            which it wrote.
# Guess written down before: every value is unchanged in all formats.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m pip install --quiet --target packages "canmatrix[xlsx]==1.3.3" cantools==45.1.0 2>/dev/null
export PYTHONPATH=$folder/packages
cat >car.dbc <<'END'
VERSION ""

NS_ :

BS_:

BU_: ECU Log

BO_ 256 Steering: 8 ECU
 SG_ Angle : 7|16@0- (0.1,0) [-780|780] "deg" Log
 SG_ Force : 16|32@1- (1,0) [-1E+09|1E+09] "N" Log

BO_ 257 Wheel: 8 ECU
 SG_ Speed : 0|16@1+ (0.01,0) [0|650] "km/h" Log

SIG_VALTYPE_ 256 Force : 1;
END
for kind in dbf xlsx sym; do
    packages/bin/canconvert car.dbc "car.$kind" >>convert.log 2>&1
    packages/bin/canconvert "car.$kind" "from_$kind.dbc" >>convert.log 2>&1
done
cat >decode.py <<'END'
import struct

import cantools

FRAMES = {"Steering": struct.pack(">h", -1234) + struct.pack("<f", -876.25) + bytes(2), "Wheel": struct.pack("<H", 9500) + bytes(6)}
SEEN = {"car": (-123.4, -876.25, 95.0), "from_dbf": (-123.4, -876.25, 95.0), "from_xlsx": (5650.2, 2294302208, 95.0),
        "from_sym": (-123.4, -1000665088, 95.0)}  # fmt: skip
for name, seen in SEEN.items():
    database = cantools.database.load_file(f"{name}.dbc")
    values = {}
    for message, frame in FRAMES.items():
        values |= database.get_message_by_name(message).decode(frame)
    print(f"{name}: " + ", ".join(f"{signal} {value:.10g}" for signal, value in values.items()))
    assert all(abs(values[signal] - value) < 1e-6 for signal, value in zip(("Angle", "Force", "Speed"), seen, strict=True))
END
python3 decode.py
