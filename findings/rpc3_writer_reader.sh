#!/usr/bin/env bash
# Road loads that rpc3-file writes are twice as long, one step late and a little smaller when rpc_reader reads them.
#
# Expected:  10 s of wheel loads at 100 Hz (RPC III, the format of road loads and of test rigs) come back as 1000 samples from 0 s on, within the
#            resolution of 16 bits (0.07 N).
# Happens:   2048 samples, 20.48 s: the rest of the last frame is the last value. The number of samples is in the header, under a key that the
#            reader does not know. Its times begin at 0.01 s, and its values are 32752/32768 of those written: it scales by the full scale
#            of the integers once more (2.2 N at 4345 N). rpc3-file itself reads its file as expected.
# Matters:   half of the recording is a constant: a mean of 1500 N becomes 2266 N, and a fit or a damage sum counts a state that was never
#            measured. A second channel recorded by another logger is shifted by one step.
# Source:    rpc3-file 1.0.0rc6 (November 2025, on pip by its version only) and rpc-reader 0.9 on PyPI, run on 2026-11-29. Neither page says
#            so; that of rpc-reader: "the full data structure of the RPC file is NOT supported".
# Guess written down before: the same samples at the same times.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m pip install --quiet --target packages rpc3-file==1.0.0rc6 rpc-reader==0.9 numpy==2.3.5 2>/dev/null
cat >loads.py <<'END_OF_PYTHON'
import contextlib
import io

import numpy as np
import rpc3
from rpc_reader.rpc_reader import ReadRPC

rpc3.rpc3.progressbar = False
STEP = 0.01
time = np.arange(1000) * STEP
fz, fy = 4000.0 + 345.0 * np.sin(2.0 * np.pi * time), np.linspace(0.0, 3000.0, len(time))
rpc3.write("loads.rsp", [rpc3.Channel("Fz", "N", STEP, fz), rpc3.Channel("Fy", "N", STEP, fy)])

own, _ = rpc3.read("loads.rsp")
error = max(np.abs(channel.data - values).max() for channel, values in zip(own, (fz, fy)))
print(f"written: {len(time)} samples from {time[0]} s on, mean of Fy {fy.mean():.0f} N")
print(f"rpc3-file: {len(own[0].data)} samples from {own[0].time()[0]} s on, within {error:.2f} N")

reader = ReadRPC("loads.rsp")
with contextlib.redirect_stdout(io.StringIO()):
    reader.import_rpc_data_from_file()
table, times = reader.get_data(), reader.get_time()[0]
scale = float(np.mean(table[: len(time), 0] / fz))
print(f"rpc_reader: {len(table)} samples from {times[0]:.2f} s on, mean of Fy {table[:, 1].mean():.0f} N, "
      f"Fz {scale:.6f} times, off by {np.abs(table[:len(time), 0] - fz).max():.1f} N, "
      f"Fy from 10 s on {np.unique(table[len(time):, 1]).round(1)} N")  # fmt: skip
assert (len(own[0].data), own[0].time()[0]) == (1000, 0.0) and error < 0.07
assert (len(table), round(float(times[0]), 6)) == (2048, 0.01)
assert abs(scale - 32752 / 32768) < 1e-5 and len(np.unique(table[len(time) :, 1])) == 1
END_OF_PYTHON
PYTHONPATH=packages python3 loads.py
