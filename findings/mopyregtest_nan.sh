#!/usr/bin/env bash
# A simulation whose force is not a number passes the regression test of mopyregtest, with every metric.
#
# Expected:  a reference of Fy in N, and a result in which Fy is nan from half of the time on: different.
# Happens:   exit status 0 with all five metrics, also if every sample is nan. The distance is nan, and the test asks whether it is at least
#            the tolerance, which is false. A result of zeros, or of inf, fails as it should.
# Matters:   nan is what a tire gives out of its range, a solver after a step too large, and an FMU on an error of its own: it is the fault
#            that a regression test of such models meets first, and the build stays green.
# Source:    mopyregtest 0.6.0 on PyPI (May 2026), run on 2026-11-29. Its documentation has no word on nan.
# Guess written down before: a result that is not a number is reported as different.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m pip install --quiet --target packages mopyregtest==0.6.0 numpy==2.3.5 pandas==2.3.3 2>/dev/null
cat >compare.py <<'END_OF_PYTHON'
import subprocess
import sys
from math import nan, inf, sin

METRICS = ("norm_p_dist", "norm_infty_dist", "Lp_dist", "Linfty_dist", "abs_dist_ptwise")
TIMES = [row / 10 for row in range(11)]


def force(time):
    """Return a side force in N."""
    return 4000.0 * sin(time)


RESULTS = {
    "the same": force,
    "zero from 0.5 s on": lambda time: force(time) if time < 0.5 else 0.0,
    "inf from 0.5 s on": lambda time: force(time) if time < 0.5 else inf,
    "nan from 0.5 s on": lambda time: force(time) if time < 0.5 else nan,
    "nan": lambda time: nan,
}
ACCEPTED = {"the same", "nan from 0.5 s on", "nan"}


def write(name, function):
    with open(name, "w") as file:
        file.writelines(["time,Fy\n", *(f"{time},{function(time)}\n" for time in TIMES)])


write("reference.csv", force)
for name, function in RESULTS.items():
    write("result.csv", function)
    codes = []
    for metric in METRICS:
        arguments = ["compare", "--metric", metric, "--tol", "1e-7", "reference.csv", "result.csv"]
        program = f"from mopyregtest.cli import parse_args; parse_args({arguments!r})"
        codes.append(subprocess.run([sys.executable, "-c", program], capture_output=True).returncode)
    print(f"result {name}: exit status {codes}")
    assert codes == [0 if name in ACCEPTED else 1] * len(METRICS)
END_OF_PYTHON
PYTHONPATH=packages python3 compare.py
