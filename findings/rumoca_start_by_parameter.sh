#!/usr/bin/env bash
# A car that rumoca is told to start at 30 m/s starts at 20 m/s, if its model names a parameter as the initial speed.
#
# Expected:  a start value that is stated for a simulation is where the simulation begins, whether the model has a number or a parameter as
#            the start of the variable.
# Happens:   with a number, v(start = 20, fixed = true), both ways to state it (with_start, start=) act. With a parameter,
#            v(start = v0, fixed = true), neither does, without a word; an unknown name would be an error. Without "fixed" both act, too.
# Matters:   models of cars name their initial speed. A sweep of braking distances over speed has one distance, 25 m, for each of them.
#            Set the parameter instead, which acts.
# Source:    rumoca 0.10.2 (October 2026) on PyPI, run on 2026-11-30. The stub of its interface: "with_start(self, **overrides: float)";
#            its docstring: "start-value overrides".
# Guess written down before: the first value is the stated one whether the start is a number, a parameter, fixed or not.
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
python3 -m pip install --quiet --target packages rumoca==0.10.2 numpy==2.3.5 2>/dev/null
cat >car.py <<'END_OF_PYTHON'
import rumoca

MODEL = """model {name}
  parameter Real v0 = 20;
  Real v(start = {start}{fixed});
  Real x(start = 0, fixed = true);
equation
  der(v) = if v > 0.01 then -8 else 0;
  der(x) = v;
end {name};
"""

seen = {}
for name, start, fixed in (
    ("Number", "20", ", fixed = true"), ("Parameter", "v0", ", fixed = true"), ("Free", "v0", ""),
):
    car = rumoca.Session().loads(MODEL.format(name=name, start=start, fixed=fixed), model=name)
    time = {"t": (0.0, 5.0), "dt": 0.01}
    ways = {
        "as it is": car.simulate(**time), "with_start(v=30)": car.with_start(v=30.0).simulate(**time),
        "start={v: 30}": car.simulate(**time, start={"v": 30.0}), "with_params(v0=30)": car.with_params(v0=30.0).simulate(**time),
    }
    seen[name] = {way: (round(float(result["v"][0]), 1), round(float(result["x"][-1]))) for way, result in ways.items()}
    print(f"v(start = {start}{fixed}): first speed (m/s) and braking distance (m):", seen[name])
assert [seen["Number"][way] for way in ways] == [(20.0, 25), (30.0, 56), (30.0, 56), (20.0, 25)]
assert [seen["Parameter"][way] for way in ways] == [(20.0, 25), (20.0, 25), (20.0, 25), (30.0, 56)]
assert [seen["Free"][way] for way in ways] == [(20.0, 25), (30.0, 56), (30.0, 56), (30.0, 56)]
END_OF_PYTHON
PYTHONPATH=packages python3 car.py
