"""FMUs in CasADi's DaeBuilder, Model Exchange: functions with derivatives, and one integrator for all."""

import json
import sys

import casadi
import numpy as np

tires, outputs = json.loads(sys.argv[1]), sys.argv[3].split(",")
models = {name: casadi.DaeBuilder(name, path) for name, (path, _) in tires.items()}
functions = {name: model.create(name, ["x", "u"], ["ode", "y"]) for name, model in models.items()}
u, x = {}, {}
for name, model in models.items():
    u[name] = np.array([tires[name][1].get(key, float(model.start(key)[0])) for key in model.u()])
    x[name] = np.array([float(model.start(key)[0]) for key in model.x()])
ends = np.cumsum([0, *map(len, x.values())]).tolist()
states = casadi.MX.sym("x", ends[-1])
parts = dict(zip(tires, casadi.vertsplit(states, ends) if ends[-1] else [[]] * len(tires), strict=True))
if ends[-1]:
    problem = {"x": states, "ode": casadi.vertcat(*(functions[name](parts[name], u[name])[0] for name in tires))}
    integrator = casadi.integrator("F", "cvodes", problem, 0.0, [1.0], {"reltol": 1e-9, "abstol": 1e-9})
    settled = integrator(x0=np.concatenate(list(x.values())))["xf"].full().ravel()
    x = dict(zip(tires, np.split(settled, ends[1:-1]), strict=True))
found = {}
for name, model in models.items():
    y = dict(zip(model.y(), functions[name](x[name], u[name])[1].full().ravel().tolist(), strict=True))
    found[name] = {key: y[key] for key in outputs}
print(json.dumps(found))
