#!/usr/bin/env bash
# mdfr exports the raw integers of an MDF file under the unit of the physical values.
#
# Expected:  a channel stored as integers with a linear conversion (steering in counts of 0.01 deg) is the same in get_channel_data, CSV and
#            Parquet.
# Happens:   get_channel_data returns -0.61 deg. export_to_csv and export_to_parquet of the same object write -61; the Parquet
#            file states the unit deg for it, the CSV none. Channels without conversion are right beside it. After
#            convert_all_channels() both exports are physical.
# Matters:   most CAN signals and sensors are stored so. A reader of the Parquet file has a number and its declared unit, and
#            a steering angle that is 100 times too large; with a factor near 1 nothing looks wrong.
# Source:    mdfr 0.7.3 on PyPI (project mdfr, ASAM MDF in Rust), run on 2026-11-29. Its page shows the export to
#            Parquet directly after loading.
# Guess written down before: physical values with their unit in the Parquet file, as get_channel_data has them.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m pip install --quiet --target packages asammdf==8.8.28 pyarrow==26.0.1 2>/dev/null
python3 -m pip install --quiet --target packages --no-deps mdfr==0.7.3 2>/dev/null
cat >export.py <<'END'
import numpy as np
import pyarrow.parquet
from asammdf import MDF, Signal
from asammdf.blocks.conversion_utils import from_dict
from mdfr import Mdfr

times = np.arange(100) * 0.1
counts = (100 * np.sin(times)).astype("int16")
steer = Signal(counts, times, name="steer", unit="deg", conversion=from_dict({"a": 0.01, "b": 0.0}))
with MDF(version="4.10") as file:
    file.append([steer, Signal(np.cos(times), times, name="yaw_rate", unit="rad/s")])
    file.save("drive.mf4")
ROW, COUNTS = 38, int(counts[38])


def drive():
    file = Mdfr("drive.mf4")
    file.load_all_channels_data_in_memory()
    return file


def exported(file, name):
    """Return steer and yaw_rate in CSV and Parquet, and the unit of the Parquet file."""
    file.export_to_csv(name)
    file.export_to_parquet(name, None)
    lines = [line.strip().split(",") for line in open(f"{name}_time.csv")]
    table = pyarrow.parquet.read_table(f"{name}_time.parquet")
    unit = table.schema.field("steer").metadata[b"unit"].decode()
    in_csv = dict(zip(lines[0], map(float, lines[1 + ROW])))
    return in_csv["steer"], table["steer"][ROW].as_py(), unit, table["yaw_rate"][ROW].as_py()


physical = float(drive().get_channel_data("steer")[ROW])
csv, parquet, unit, yaw_rate = exported(drive(), "raw")
print(f"steer: get_channel_data {physical:g}, CSV {csv:g}, Parquet {parquet:g} in {unit}")
converted = drive()
converted.convert_all_channels()
csv_converted, parquet_converted, *_ = exported(converted, "converted")
print(f"after convert_all_channels: CSV {csv_converted:g}, Parquet {parquet_converted:g}")
assert abs(physical - 0.01 * COUNTS) < 1e-12 and abs(yaw_rate - np.cos(times[ROW])) < 1e-12
assert (csv, parquet, unit) == (COUNTS, COUNTS, "deg")
assert abs(csv_converted - 0.01 * COUNTS) < 1e-12 and abs(parquet_converted - 0.01 * COUNTS) < 1e-12
END
PYTHONPATH=packages python3 export.py
