#!/usr/bin/env bash
# A sensor that fails for 10 s has values in all rows of rosbag-resurrector's synchronized table, whatever tolerance is stated.
#
# Expected:  with tolerance_ms=50 rows further than 50 ms from a sample of the sensor have no value, by each of the three methods: tolerance_ms
#            is used "by all methods for 'no match' detection".
# Happens:   so with nearest only. interpolate puts a straight line through the gap, sample_and_hold the last value, both without
#            missing values; tolerance_ms=1 changes nothing, and both engines agree.
# Matters:   10 s of wheel speed that was never measured, at the full rate of the IMU and without a NaN. A fit weights them as measurements, and
#            no check for gaps sees them: the times have none. State nearest, or drop rows by the times of the sensor itself.
# Source:    rosbag-resurrector 0.8.7 on PyPI (October 2026; the bag written by mcap-ros2-support 0.6.0), run on 2026-11-29. The sentence above
#            is of its synchronize().
# Guess written down before: no values inside the gap.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m pip install --quiet --target packages rosbag-resurrector==0.8.7 mcap==1.6.0 mcap-ros2-support==0.6.0 numpy==2.3.5 2>/dev/null
cat >gap.py <<'END_OF_PYTHON'
import numpy as np
from mcap_ros2.writer import Writer
from resurrector import BagFrame

SCHEMA = ("\n" + "=" * 80 + "\n").join((
    "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort",
    "MSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id",
    "MSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec",
))  # fmt: skip
fast, slow = np.arange(0, 2000) * 10, np.arange(0, 200) * 100
slow = slow[(slow <= 5000) | (slow >= 15000)]
events = sorted([(time, "/steer", np.sin(time / 700)) for time in fast] + [(time, "/wheel", 20.0 + 5.0 * np.sin(time / 3000)) for time in slow])
with open("drive.mcap", "wb") as file:
    writer = Writer(file)
    schema = writer.register_msgdef("sensor_msgs/msg/JointState", SCHEMA)
    for milliseconds, topic, value in events:
        time = 1_000_000_000_000 + int(milliseconds) * 1_000_000
        header = {"stamp": {"sec": time // 10**9, "nanosec": time % 10**9}, "frame_id": ""}
        message = {"header": header, "name": ["a"], "position": [], "velocity": [float(value)], "effort": []}
        writer.write_message(topic=topic, schema=schema, message=message, log_time=time, publish_time=time)
    writer.finish()

seen = {}
for method in ("nearest", "interpolate", "sample_and_hold"):
    for engine in ("eager", "streaming"):
        for tolerance in (1.0, 50.0):
            table = BagFrame("drive.mcap").sync(["/steer", "/wheel"], method=method, tolerance_ms=tolerance, anchor="/steer", engine=engine)
            inside = table["wheel__velocity.0"].to_numpy()[(fast > 5050) & (fast < 14950)]
            seen[method, engine, tolerance] = int(np.isfinite(inside).sum())
    values = inside[[0, len(inside) // 2, -1]].round(2)
    print(f"{method}: {seen[method, 'eager', 50.0]} of {len(inside)} rows inside the gap have a value: {values}")
assert all(count == (0 if key[0] == "nearest" else 989) for key, count in seen.items())
END_OF_PYTHON
PYTHONPATH=packages python3 gap.py 2>/dev/null
