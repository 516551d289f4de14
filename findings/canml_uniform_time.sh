#!/usr/bin/env bash
# A CAN log of 10 s lasts 30 s in canml's table with uniform times, as three messages were on the bus.
#
# Expected:  steering, yaw rate and speed, each at 100 Hz, in a table whose rows are 0.01 s apart: 10 s; missing values interpolated on
#            request.
# Happens:   each frame is a row of its own, and "uniform" numbers the rows: 0.01 s times the number of frames, 30 s. Every signal has
#            values in one of three rows; interpolate_missing fills none of them, it concerns signals that the log lacks altogether.
# Matters:   frequencies and rates are a third: a steering at 1 Hz is one at 0.33 Hz, lags are three times as long, and the yaw rate
#            contradicts the speed. With messages of different rates the factor differs along the log. Keep its own times.
# Source:    canml 0.1.14 on PyPI (May 2025), run on 2026-11-29. Its page: "uniform timestamp spacing (with raw
#            backup), missing-signal injection (dtype-safe), linear interpolation".
# Guess written down before, from its page: 1000 rows, 10 s.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m pip install --quiet --target packages canml==0.1.14 2>/dev/null
cat >uniform.py <<'END_OF_PYTHON'
import logging

import can
import canml
import cantools
import numpy as np

DATABASE = "".join(
    f'BO_ {number} M{number}: 8 A\n SG_ {name} : 0|16@1- (0.01,0) [0|0] "{unit}" A\n\n'
    for number, name, unit in ((256, "steer", "deg"), (257, "yaw_rate", "deg/s"), (258, "v", "m/s"))
)
with open("car.dbc", "w") as file:
    file.write(f'VERSION ""\n\nNS_ :\n\nBS_:\n\nBU_: A\n\n{DATABASE}')
database = cantools.database.load_file("car.dbc")
with can.BLFWriter("drive.blf") as writer:
    for step in range(1000):
        swing = 10.0 * np.sin(2.0 * np.pi * step * 0.01)
        for number, value in ((256, swing), (257, 2.0 * swing), (258, 20.0)):
            message = database.get_message_by_frame_id(number)
            data = message.encode({message.signals[0].name: value})
            writer.on_message_received(can.Message(timestamp=step * 0.01, arbitration_id=number, is_extended_id=False, data=data))

logging.disable(logging.CRITICAL)
seen = []
for options in ({}, {"force_uniform_timing": True, "interval_seconds": 0.01, "interpolate_missing": True}):
    table = canml.load_blf("drive.blf", ["car.dbc"], canml.CanmlConfig(progress_bar=False, **options))
    steer = table.dropna(subset="steer")
    turns = steer.timestamp.to_numpy()[1:][(steer.steer.to_numpy()[1:] > 0) & (steer.steer.to_numpy()[:-1] <= 0)]
    seen.append((len(table), round(float(table.timestamp.max()), 2), int(table.steer.isna().sum()), round(float(1.0 / np.diff(turns).mean()), 2)))
    print(f"{options}: {seen[-1][0]} rows to {seen[-1][1]} s, {seen[-1][2]} without steering, which swings at {seen[-1][3]} Hz")
assert seen == [(3000, 9.99, 2000, 1.0), (3000, 29.99, 2000, 0.33)]
END_OF_PYTHON
PYTHONPATH=packages python3 uniform.py
