#!/usr/bin/env bash
# openrainflow finds hardly any large cycle in a road load, and fewer the faster the load is sampled: the largest range is 1 N of 280 N.
#
# Expected:  one wheel load (a swing of 100 N each second with one of 40 N on it, in steps of 1 N as a logger stores it) has about 60 cycles beyond
#            150 N in a minute, up to 280 N, at any sampling rate: rainflow counting sees the turning points only.
# Happens:   a load of whole steps stays at one value for some samples, and the end of each such rest is taken for a turning point, also on a
#            rising flank: 0, 1, 1, 2 has a range of 1. At 5 kHz the whole minute is of cycles of 1 N. Without steps the count is wrong,
#            too: 2.5 cycles, up to 175 N. typhoon counts 59.5, up to 280 N, throughout.
# Matters:   damage goes with the fifth power of a range or so: a longer life by a faster logger is of the counting only.
# Source:    openrainflow 1.0.0 (October 2025) and typhoon-rainflow 0.2.5 (February 2026) on PyPI, run on 2026-11-29. Its page: "ASTM E1049-85".
# Guess written down before: the same counts in both, at every rate.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m pip install --quiet --target packages openrainflow==1.0.0 typhoon-rainflow==0.2.5 numpy==2.3.5 numba==0.63.1 matplotlib==3.10.7 2>/dev/null
cat >count.py <<'END_OF_PYTHON'
import numpy as np
import typhoon
from openrainflow import rainflow_count


def counts(rate, step):
    """Return cycles beyond 150 N and the largest range in N, by openrainflow and by typhoon with its unclosed ranges as halves."""
    time = np.arange(0.0, 60.0, 1.0 / rate)
    load = 100.0 * np.sin(2.0 * np.pi * time) + 40.0 * np.sin(2.0 * np.pi * 7.3 * time)
    load = np.round(load / step) * step if step else load
    cycles = rainflow_count(load)
    closed, rest = typhoon.rainflow(load.astype(np.float32), bin_size=0.0)
    ranges = np.array([abs(a - b) for a, b in closed] + list(np.abs(np.diff(rest))))
    number = np.array([float(n) for n in closed.values()] + [0.5] * (len(rest) - 1))
    first = (float(cycles["count"][cycles["range"] > 150.0].sum()), round(float(cycles["range"].max())))
    return first, (float(number[ranges > 150.0].sum()), round(float(ranges.max())))


seen = {}
for rate, step in ((500, 0.0), (500, 1.0), (5000, 1.0)):
    seen[rate, step] = counts(rate, step)
    first, second = seen[rate, step]
    print(f"{rate} Hz, steps of {step} N: (cycles beyond 150 N, largest range in N) openrainflow {first}, typhoon {second}")
ramp = rainflow_count(np.array([0.0, 1.0, 1.0, 2.0]))["range"].tolist()
print("0, 1, 1, 2: ranges", ramp)
assert seen[500, 0.0][0] == (2.5, 175) and seen[5000, 1.0][0] == (0.0, 1)
assert ramp == [1.0] and all(56.0 <= second[0] <= 61.0 and second[1] == 280 for _, second in seen.values())
END_OF_PYTHON
PYTHONPATH=packages python3 count.py
