#!/usr/bin/env bash
# mopyregtest interpolates by the number of the row, not by time: one straight line, written at two sets of times, differs.
#
# Expected:  a reference and a result of Fz = 1000 N/s * t, one with a row more than the other, are equal with "interpolate": a straight line
#            is a straight line at any times.
# Happens:   they differ by up to 400 N. Times of both files are merged, and values that a file lacks are halfway between the rows before and
#            behind, whatever their times. With more rows at one place the error tends to the whole change between two rows.
# Matters:   results of solvers with a variable step, and FMUs with events, never have the times of their reference. A tolerance that is
#            made large enough for this error hides real ones: here it would be 40 % of the force.
# Source:    mopyregtest 0.6.0 on PyPI (May 2026), run on 2026-11-29. Its documentation: "uses linear interpolation".
# Guess written down before: equal within rounding.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m pip install --quiet --target packages mopyregtest==0.6.0 numpy==2.3.5 pandas==2.3.3 2>/dev/null
cat >compare.py <<'END_OF_PYTHON'
from mopyregtest import RegressionTest, metrics

REFERENCE = [0.0, 1.0, 2.0]
seen = []


def noted(reference, result):
    """Return the largest difference in N, and keep it."""
    seen.append(metrics.norm_infty_dist(reference, result))
    return seen[-1]


def write(name, times):
    with open(name, "w") as file:
        file.writelines(["time,Fz\n", *(f"{time},{1000.0 * time}\n" for time in times)])


write("reference.csv", REFERENCE)
for more in ([], [0.5], [0.1], [0.97, 0.98, 0.99]):
    write("result.csv", sorted(REFERENCE + more))
    try:
        RegressionTest.compare_csv_files("reference.csv", "result.csv", 1.0, ["Fz"], noted, True, "interpolate", False)
        verdict = "equal"
    except AssertionError:
        verdict = "different"
    print(f"a row more at {more or 'no'} s: {verdict}, largest difference {seen[-1]:.0f} N")
assert [round(difference) for difference in seen] == [0, 0, 400, 720]
END_OF_PYTHON
PYTHONPATH=packages python3 compare.py
