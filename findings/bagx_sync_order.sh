#!/usr/bin/env bash
# Two sensors are in perfect synchrony or seconds apart, depending on which of them is named first to bagx.
#
# Expected:  the synchrony of steering (100 Hz) and GNSS (1 Hz), whose times are equal wherever both exist, is the same in both orders; an
#            outage of 10 s is worse than none, in both orders.
# Happens:   for each message of the first topic the distance to the nearest of the second is taken. Steering, GNSS: mean 260 ms, which is a
#            quarter of the period of the slower one; GNSS, steering: 0.0 ms. With the outage 1.4 s, and again 0.0 ms. A delay of
#            120 ms that a sensor states in its own stamps is 0.0 ms in both orders: times are those of the recorder.
# Matters:   "Are my sensors synchronized?" is what it is asked before a log is fitted. 0.0 ms says nothing of an outage or a delay, 260 ms not
#            that anything is late; in a comparison of all pairs the order is that of the file.
# Source:    bagx 0.6.0 on PyPI (June 2026; bags written by mcap-ros2-support 0.6.0), run on 2026-11-29. The question is of its page.
# Guess written down before: the same figures in both orders; the outage and the delay in the largest one.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m pip install --quiet --target packages bagx==0.6.0 mcap==1.6.0 mcap-ros2-support==0.6.0 numpy==2.3.5 2>/dev/null
cat >order.py <<'END_OF_PYTHON'
import numpy as np
from bagx.sync import analyze_sync
from mcap_ros2.writer import Writer

SCHEMA = ("\n" + "=" * 80 + "\n").join((
    "std_msgs/Header header\nstring[] name\nfloat64[] position\nfloat64[] velocity\nfloat64[] effort",
    "MSG: std_msgs/Header\nbuiltin_interfaces/Time stamp\nstring frame_id",
    "MSG: builtin_interfaces/Time\nint32 sec\nuint32 nanosec",
))  # fmt: skip
STEER, GNSS = np.arange(0, 2000) * 10, np.arange(0, 20) * 1000


def delays(slow, stamp=0):
    """Return mean delays in ms of both orders; the second sensor states a measurement so many ms before the recorder's time."""
    with open("drive.mcap", "wb") as file:
        writer = Writer(file)
        schema = writer.register_msgdef("sensor_msgs/msg/JointState", SCHEMA)
        for milliseconds, topic in sorted([(time, "/steer") for time in STEER] + [(time, "/gnss") for time in slow]):
            time = 1_000_000_000_000 + int(milliseconds) * 1_000_000
            own = time - stamp * 1_000_000 * (topic == "/gnss")
            header = {"stamp": {"sec": own // 10**9, "nanosec": own % 10**9}, "frame_id": ""}
            message = {"header": header, "name": [], "position": [], "velocity": [], "effort": []}
            writer.write_message(topic=topic, schema=schema, message=message, log_time=time, publish_time=time)
        writer.finish()
    return [round(analyze_sync("drive.mcap", *pair).pairs[0].mean_delay_ms, 1) for pair in (("/steer", "/gnss"), ("/gnss", "/steer"))]


seen = {
    "equal times": delays(GNSS),
    "outage of 10 s": delays(GNSS[(GNSS <= 5000) | (GNSS >= 15000)]),
    "GNSS 120 ms late by its stamps": delays(STEER, 120),
}
for name, (forward, backward) in seen.items():
    print(f"{name}: mean delay {forward} ms named steering first, {backward} ms named GNSS first")
assert seen["equal times"][0] > 250.0 and seen["outage of 10 s"][0] > 1200.0
assert [values[1] for values in seen.values()] == [0.0, 0.0, 0.0] and seen["GNSS 120 ms late by its stamps"][0] == 0.0
END_OF_PYTHON
PYTHONPATH=packages python3 order.py
