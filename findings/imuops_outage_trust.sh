#!/usr/bin/env bash
# A recording of an IMU without a third of its samples has the full trust score, one at 833 Hz without a gap has a warning of dropouts.
#
# Expected:  each fault of a recording takes from its trust score, and none takes from one without: 60 s at 100 Hz; the same without the samples from
#            25 to 45 s; the same with a gyroscope 57 times too large; 60 s at 833 Hz, a rate of common sensors.
# Happens:   complete: 1.0, pass. An outage of 20 s: 1.0, pass, no reason, since steps are counted: one of 4000 is long. A
#            yaw rate of 28 rad/s, of a log in deg/s: 0.997, pass. Complete at 833 Hz: 0.72, "dropout", since times are rounded
#            to whole ms, and a step of 2 ms is a gap where most have 1 ms.
# Matters:   the score decides in a pipeline (audit --fail-below 0.80) which recordings are kept: the wrong ones. Whoever integrates the first one
#            has a car that is 20 s of turning off.
# Source:    imuops 0.4.1 (March 2026) on PyPI, run on 2026-11-30: "turns timestamp jitter, packet loss, unit mismatch into named reasons".
# Guess written down before: outage and wrong unit each lower the score clearly, below that of a complete recording.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m pip install --quiet --target packages imuops==0.4.1 numpy==2.3.5 pandas==2.3.3 2>/dev/null
cat >recordings.py <<'END'
import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pandas as pd

Path("columns.yaml").write_text(
    "imu: {timestamp_col: t, timestamp_unit: s, accel_cols: [ax, ay, az], gyro_cols: [gx, gy, gz]}\n"
)


def recording(rate):
    """Return 60 s of a car that stands for 15 s and then drives through turns."""
    random = np.random.default_rng(3)
    t = np.arange(round(60 * rate)) / rate
    moving, yaw_rate = t > 15.0, np.where(t > 15.0, 0.5 * np.sin(0.8 * t), 0.0)
    truth = {"ax": moving * 1.5 * np.sin(0.3 * t), "ay": 15.0 * yaw_rate, "az": 9.81 + 0.0 * t,
             "gx": 0.0 * t, "gy": 0.0 * t, "gz": yaw_rate}
    noise = {"a": 0.05, "g": 0.005}
    return pd.DataFrame({"t": t, **{name: values + random.normal(0.0, noise[name[0]], len(t)) for name, values in truth.items()}})


def audited(name, table):
    """Return score, status and reasons of a recording."""
    table.to_csv(f"{name}.csv", index=False)
    imuops = [sys.executable, "-m", "imuops"]
    ingest = [*imuops, "ingest", "tabular", f"{name}.csv", "--config", "columns.yaml", "--out", name]
    for command in (ingest, [*imuops, "audit", name]):
        subprocess.run(command, check=True, capture_output=True)
    summary = json.loads(Path(name, "audit_summary.json").read_text())
    seen = (round(summary["trust_score"], 3), summary["status"], summary["reason_codes"])
    print(f"{name}: {len(table)} samples, score {seen[0]}, {seen[1]}, reasons {seen[2]}")
    return seen


table = recording(100.0)
assert audited("complete", table) == (1.0, "pass", [])
assert audited("outage_of_20_s", table[(table["t"] < 25.0) | (table["t"] > 45.0)]) == (1.0, "pass", [])
degrees = {name: np.degrees(table[name]) for name in ("gx", "gy", "gz")}
assert audited("deg_s_as_rad_s", table.assign(**degrees))[:2] == (0.997, "pass")
score, status, reasons = audited("complete_833_Hz", recording(833.0))
assert score < 0.8 and status == "warning" and reasons == ["dropout"]
END
PYTHONPATH=packages python3 recordings.py
