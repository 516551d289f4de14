#!/usr/bin/env bash
# A recording that sdypy-io-tdms writes and reads has wheel loads of one name, and times in steps of 128 s.
#
# Expected:  the channels Fz FL/N, Fz FR/N, v [km/h] and time have their names and numbers after writing and reading, and sensors their starts.
# Happens:   its reader cuts names two letters before the first slash: "Fz " twice, "v [". All numbers are stored in single precision: seconds
#            since 1970 come back in steps of 128 s. The start of a signal is not written; in files of others it is cut to whole
#            seconds: two sensors 0.4 s apart are 1 s apart. npTDMS reads the names of the same file.
# Matters:   loggers put units into the names of channels, and most units of a car have a slash. A table by name keeps the last of the
#            channels that have become one, and lateral acceleration is late against the steering.
# Source:    sdypy-io-tdms 0.1.2 with npTDMS 1.13.0 on PyPI, run on 2026-11-29. Its page: "TDMS file read and write functions".
# Guess written down before: the same names, numbers and starts.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m pip install --quiet --target packages sdypy-io-tdms==0.1.2 nptdms==1.13.0 numpy==2.3.5 2>/dev/null
cat >names.py <<'END_OF_PYTHON'
import numpy as np
from nptdms import ChannelObject, TdmsFile, TdmsWriter
from sdypy_io_tdms.tdms import read_tdms, write_tdms

times = 1764000000.0 + np.arange(100000) / 100.0
common = {"group": "run", "unit_str": "", "data": times, "fs": 100.0, "start_timestamp": "2026-11-01 12:00:00.700"}
signals = [{"name": name, **common} for name in ("Fz FL/N", "Fz FR/N", "v [km/h]", "time")]
write_tdms(signals, "written.tdms")
read = read_tdms("written.tdms")
kept = TdmsFile("written.tdms")["run"].channels()
names, steps = [signal["name"] for signal in read], np.unique(np.diff(read[-1]["data"].astype(float)))
print("written:", [signal["name"] for signal in signals], "- npTDMS:", [channel.name for channel in kept], "- read:", names)
print(f"steps of time: {steps} s of 0.01 s; start in the file: {'start_timestamp' in read[0]}")

with TdmsWriter("logger.tdms") as writer:
    for name, late in (("steer", 700), ("ay", 1100)):
        begin = np.datetime64("2026-11-01T12:00:00") + np.timedelta64(late, "ms")
        writer.write_segment([ChannelObject("run", name, np.zeros(10), {"wf_increment": 0.01, "wf_start_time": begin})])
starts = [str(signal["start_timestamp"]) for signal in read_tdms("logger.tdms")]
print("starts of two sensors 0.4 s apart:", starts)
assert [channel.name for channel in kept] == [signal["name"] for signal in signals] and names == ["Fz ", "Fz ", "v [", "time"]
assert list(steps) == [0.0, 128.0] and "start_timestamp" not in read[0]
assert starts == ["2026-11-01T12:00:00", "2026-11-01T12:00:01"]
END_OF_PYTHON
PYTHONPATH=packages python3 names.py
