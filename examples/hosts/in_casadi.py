"""An FMU in CasADi's DaeBuilder, Model Exchange: functions with derivatives, and its integrators."""

import json
import sys

import casadi
import numpy as np

path, inputs, outputs = sys.argv[1], json.loads(sys.argv[3]), sys.argv[4].split(",")
tire = casadi.DaeBuilder("tire", path)
function = tire.create("f", ["x", "u"], ["ode", "y"])
u = np.array([inputs.get(name, float(tire.start(name)[0])) for name in tire.u()])
x = np.array([float(tire.start(name)[0]) for name in tire.x()])
if tire.x():
    states, given = casadi.MX.sym("x", len(x)), casadi.MX.sym("u", len(u))
    problem = {"x": states, "p": given, "ode": function(states, given)[0]}
    x = casadi.integrator("F", "cvodes", problem, 0.0, [1.0], {"reltol": 1e-9, "abstol": 1e-9})(x0=x, p=u)["xf"]
found = dict(zip(tire.y(), function(x, u)[1].full().ravel().tolist(), strict=True))
print(json.dumps({name: found[name] for name in outputs}))
