#!/usr/bin/env bash
# mf4-rs merges two measurements one minute apart into one whose time runs from 0 to 10 s twice.
#
# Expected:  each file has its start time in the header; merged, the second one begins 60 s after the first, or the
#            merger refuses.
# Happens:   the records are put one behind the other with their own times: 0 ... 9.99, 0 ... 9.99 s, whatever the
#            start times and the order; the header is that of the file named first. Its own reader gives 12:00:00 twice.
#            asammdf's MDF.concatenate of the same files gives 60 ... 69.99 s for the second.
# Matters:   loggers split a drive into files. What sorts or interpolates by time then mixes two parts of the drive
#            sample by sample, with the right number of rows and no message.
# Source:    mf4-rs 3.7.0 (files written and checked by asammdf 8.8.28) on PyPI, run on 2026-11-28.
# Guess written down before: the second file's times are shifted by 60 s.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m pip install --quiet --target packages mf4-rs==3.7.0 asammdf==8.8.28 2>/dev/null
cat >merge.py <<'END'
from datetime import datetime, timezone

import mf4_rs
import numpy as np
from asammdf import MDF, Signal

TIMES = np.arange(1000) / 100
for minute in (0, 1):
    file = MDF(version="4.10")
    file.start_time = datetime(2026, 11, 1, 12, minute, tzinfo=timezone.utc)
    file.append([Signal(np.sin(TIMES), TIMES, name="Fy", unit="N")])
    file.save(f"{minute}.mf4")
for first, second in ("01", "10"):
    mf4_rs.merge_files("merged.mf4", f"{first}.mf4", f"{second}.mf4")
    with MDF("merged.mf4") as merged:
        start, times = merged.start_time, merged.get("Fy").timestamps
    print(f"mf4-rs, {first} then {second}: start {start:%H:%M}, times", times[[0, 999, 1000, 1999]])
    assert (times == np.tile(TIMES, 2)).all() and start.minute == int(first)
times = MDF.concatenate(["0.mf4", "1.mf4"]).get("Fy").timestamps
print("asammdf, 0 then 1: times", times[[0, 999, 1000, 1999]])
assert abs(times[1000] - 60) < 1e-9
END
PYTHONPATH=packages python3 merge.py
