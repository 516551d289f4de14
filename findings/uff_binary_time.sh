#!/usr/bin/env bash
# A binary universal file (dataset 58b) keeps its samples in double precision and its time step in six digits of text.
#
# Expected:  a binary file returns what was written, times included.
# Happens:   the samples come back exactly. The step of evenly spaced data stands in the header, which is text in a
#            binary file, too, as 3.33333e-04 for 1/3000 s: times drift by 1e-6 of the duration, 3.6 ms after
#            an hour. With abscissa_spacing=0 (a time for each sample, three times the size) they are exact.
# Matters:   two recordings of a bench at 3000 and 2048 Hz that began together, or force and CAN data, drift apart by whole
#            samples in a day of endurance running; the first looks fine when plotted.
# Source:    pyuff 2.5.8 on PyPI, run on 2026-11-28. The field of 13 characters is that of the format.
# Guess written down before: exact in the binary file, rounded in the one of text only.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m pip install --quiet --target packages pyuff==2.5.8 2>/dev/null
cat >file.py <<'END'
import numpy as np
import pyuff

TIMES = np.arange(30000) / 3000
FORCE = np.sin(7 * TIMES)
for spacing in (1, 0):
    record = {"type": 58, "binary": 1, "func_type": 1, "data": FORCE, "x": TIMES, "abscissa_spacing": spacing,
              "id1": "Fy", "rsp_node": 1, "rsp_dir": 1, "ref_node": 1, "ref_dir": 1, "rsp_ent_name": "a",
              "ref_ent_name": "a", "abscissa_spec_data_type": 17, "ordinate_spec_data_type": 9,
              "orddenom_spec_data_type": 0}  # fmt: skip
    pyuff.UFF(f"{spacing}.uff").write_sets(record)
    read = pyuff.UFF(f"{spacing}.uff").read_sets()
    drift = (read["x"][-1] - TIMES[-1]) / TIMES[-1]
    print(f"abscissa_spacing {spacing}: samples differ by {abs(read['data'] - FORCE).max():g}, "
          f"time after an hour by {3.6e6 * drift:.2f} ms")
    assert (read["data"] == FORCE).all()
    assert abs(drift + 1e-6) < 1e-9 if spacing else drift == 0
END
PYTHONPATH=packages python3 file.py
