"""IPOPT through CasADi: cost with exact gradient and Gauss-Newton Hessian, constraints with exact derivatives.

Compiled code evaluates the cost over all rows, so it is a CasADi callback. The constraints are callbacks of the
generated CasADi functions. `convergence` decides at the point that IPOPT returns whether it is an optimum, whatever the
return status is.

These settings were found by experience:

- Second-order corrections and the watchdog reject good steps; both are off.
- The Gauss-Newton matrix is nearly singular. Without adaptive damping IPOPT does not converge.
- The barrier parameter has to be small, because the cost is 0.001 to 1.
- Steps that restore a constraint may increase the cost. Therefore the best feasible point is stored.
- CasADi's matrices take longer to make than most functions to compute: cost, derivatives and constraints read and
  write its memory.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from math import inf
from typing import Any

import casadi as ca
import numpy as np
import numpy.typing as npt

from ...numerics.arrays import FloatArray
from ...numerics.one_thread import one_blas_thread
from ..constraints.constraint_functions import ConstraintFunctions
from ..constraints.physical import Constraint
from ..problem.weighted_residuals import Problem, Ridge
from .convergence import GaussNewton

#: The cost decreases from about 1 to 0.001; IPOPT's barrier parameters are intended for larger values.
OBJECTIVE_SCALE = 1e3
#: Levenberg-Marquardt damping in scaled coefficients: first value, limits, and factors after a failure and a success.
DAMPING, MIN_DAMPING, MAX_DAMPING = 1e-3, 1e-7, 1.0
DAMPING_UP, DAMPING_DOWN = 10.0, 0.2
#: Stopping window and least gain by type of stage: IPOPT is stopped when that many iterations lower the best feasible
#: cost by less than that share of it. An intermediate stage on random rows is followed by another one, the
#: penultimate by a fit of the same coefficients to all rows. Three steps without a gain prove nothing: the cost still
#: decreases after them in a narrow valley.
MIN_GAIN = {"intermediate": (2, 1e-2), "penultimate": (4, 1e-5), "final": (10, 1e-5)}
#: Upper limit of Gauss-Newton steps after IPOPT.
LAST_STEPS = 20
#: Options of IPOPT and initial damping of each attempt; the next attempt follows if the point is not an optimum.
ATTEMPTS: tuple[tuple[dict[str, str | float], float], ...] = (
    ({}, DAMPING),
    ({"mu_strategy": "adaptive"}, MAX_DAMPING),
    ({"mu_init": 1e-2, "linear_system_scaling": "none"}, MAX_DAMPING),
)
#: Standard errors by which a coefficient of a stage that ends without an optimum may differ from it. The tire is then
#: within the noise of the optimum; bootstraps need a converged solution.
MAX_ERRORS = 1.0
#: Reasons: a stop was requested, the iteration limit was reached, or a later stage continues and needs no optimum.
INTERRUPTED, LIMIT, CONTINUED = "interrupted", "iteration limit", "little further gain before the next stage"
SUPERSEDED = "a later stage continues"
#: Called with (iteration, cost, scaled free values) in each iteration.
Progress = Callable[[int, float, FloatArray], None]


@dataclass(frozen=True)
class SolverResult:
    """The result of a solver.

    - `x`, shape (n_free,): scaled free values.
    - `converged`: by the criterion of `tirefmu.fitting.solvers.convergence` at x; in a stage that a later one continues
      with the same coefficients, also if further gains are small.
    - `reason`: why x is an optimum or not, as a text for the user.
    - `detail`: return status of the solver.
    - `errors`: most standard errors by which a coefficient differs from its optimum; infinite if it is not known.
    """

    x: FloatArray
    cost: float
    iterations: int
    converged: bool
    reason: str
    detail: str = ""
    errors: float = inf

    def accepted(self) -> SolverResult:
        """Return the same as converged if the noise does not distinguish it from the optimum (`MAX_ERRORS`)."""
        if self.converged or self.reason == INTERRUPTED or not self.errors <= MAX_ERRORS:
            return self
        return replace(
            self, converged=True, reason=f"{self.reason}, within {self.errors:.1g} standard errors of the optimum"
        )


class _Numeric(ca.Callback):  # type: ignore[misc]
    """A CasADi function that calls a Python function with nonzeros of arguments, which returns those of results.

    It uses the memory of CasADi: its matrices take longer to make than most of these functions take to compute.
    """

    def __init__(
        self, name: str, compute: Callable[..., Sequence[npt.ArrayLike]], into: list[Any], out: list[Any]
    ) -> None:
        ca.Callback.__init__(self)
        self._compute, self._into, self._out = compute, into, out
        self.construct(name, {})

    def get_n_in(self) -> int:
        return len(self._into)

    def get_n_out(self) -> int:
        return len(self._out)

    def get_sparsity_in(self, i: int) -> Any:
        return self._into[i]

    def get_sparsity_out(self, i: int) -> Any:
        return self._out[i]

    def has_eval_buffer(self) -> bool:
        return True

    def eval_buffer(self, arguments: Sequence[memoryview | None], results: Sequence[memoryview | None]) -> int:
        computed = self._compute(*(_numbers(argument) for argument in arguments))
        for result, values in zip(results, computed, strict=True):
            if result is not None and len(result):  # None: not requested
                np.frombuffer(result)[:] = values
        return 0


def _numbers(argument: memoryview | None) -> FloatArray:
    """Return a copy of the nonzeros of an argument; none if CasADi does not provide it."""
    return np.zeros(0) if argument is None else np.frombuffer(argument).copy()


class _IterationMonitor(ca.Callback):  # type: ignore[misc]
    """Stores the best feasible point, and stops IPOPT if the cost does not decrease in the stopping window."""

    def __init__(self, n: int, imposed: ConstraintFunctions, stop: Callable[[], bool], *, stage_type: str) -> None:
        ca.Callback.__init__(self)
        self._n, self._imposed, self._stop = n, imposed, stop
        self._window, self._least = MIN_GAIN[stage_type]
        self._costs: list[float] = []  # the best cost after each iteration
        self.x: FloatArray | None = None
        self.no_gain = self.stopped = False
        self.construct("watch", {})

    def get_n_in(self) -> int:
        return int(ca.nlpsol_n_out())

    def get_n_out(self) -> int:
        return 1

    def get_name_in(self, i: int) -> str:
        return str(ca.nlpsol_out(i))

    def get_sparsity_in(self, i: int) -> Any:
        sizes = {"f": 1, "x": self._n, "lam_x": self._n, "g": len(self._imposed), "lam_g": len(self._imposed)}
        name = ca.nlpsol_out(i)
        return ca.Sparsity.dense(sizes[name], 1) if name in sizes else ca.Sparsity.dense(0, 0)

    def has_eval_buffer(self) -> bool:
        return True

    def eval_buffer(self, arguments: Sequence[memoryview | None], results: Sequence[memoryview]) -> int:
        outputs = dict(zip((ca.nlpsol_out(i) for i in range(self.get_n_in())), arguments, strict=True))
        g, cost = _numbers(outputs["g"]), float(_numbers(outputs["f"])[0])
        if self._imposed.satisfied(g) and (self.x is None or cost < self._costs[-1]):
            self.x = _numbers(outputs["x"])
            self._costs.append(cost)
        elif self.x is not None:
            self._costs.append(self._costs[-1])
        if len(self._costs) > self._window:
            gain = self._costs[-1 - self._window] - self._costs[-1]
            self.no_gain = gain < self._least * abs(self._costs[-1])
        self.stopped = not self.no_gain and self._stop()
        np.frombuffer(results[0])[:] = float(self.no_gain or self.stopped)
        return 0


def solve(
    problem: Problem,
    start: FloatArray,
    lower: FloatArray,
    upper: FloatArray,
    constraints: list[tuple[Constraint, FloatArray]],
    *,
    ridge: float = 1e-9,
    stage_type: str = "final",
    refine: bool = False,
    local: bool = False,
    max_iterations: int = 300,
    progress: Progress | None = None,
    stop: Callable[[], bool] = lambda: False,
) -> SolverResult:
    """Minimize the cost within bounds and constraints.

    - `start`, `lower`, `upper`, shape (n_free,): scaled free values.
    - `constraints`, shape (n_inputs, n_points): constraints, each with the points at which it is imposed.
    - `ridge`: strength of the regularization towards the initial values, for directions that are not identifiable.
    - `stage_type`, one of "intermediate", "penultimate", "final": selects the stopping window and the least gain
      (`MIN_GAIN`).
    - `refine`: whether the start is the solution of the same problem with fewer constraint points. Gauss-Newton steps
      are then tried first: IPOPT needs many iterations if the constraints at two points are almost equal.
    - `local`: whether the start is the solution of a problem with other rows or residuals, to which Gauss-Newton steps
      lead faster: only they are taken, and the result has not converged if they find no optimum.
    - `stop`: called after every iteration; True ends the solver with the best feasible point, or with the start if
      there is none.

    If no optimum is found, `converged` is False and `reason` states why. A stage that is not final needs none: a later
    one frees its coefficients again.
    """
    imposed = ConstraintFunctions(problem, constraints)
    cached = _CachedCost(problem, start, ridge, progress)
    gauss_newton = GaussNewton(cached, lower, upper, imposed, stop)
    x, iterations, statuses = start, 0, list[str]()
    if local:
        steps = min(LAST_STEPS, max_iterations)
        end = gauss_newton.continued(start, steps)
        reason = INTERRUPTED if stop() else end.reason
        return SolverResult(end.x, problem.cost(end.x), end.steps, end.converged, reason, errors=end.errors)
    if refine:
        end = gauss_newton.refined(start, LAST_STEPS)
        if end.converged:
            return SolverResult(end.x, problem.cost(end.x), end.steps, True, end.reason, "")
    for options, damping in ATTEMPTS:
        cached.damping = damping
        monitor = _IterationMonitor(len(start), imposed, stop, stage_type=stage_type)
        options = {**options, "max_iter": max_iterations - iterations}
        last, status, taken = _ipopt(cached, x, lower, upper, imposed, monitor, options)
        if monitor.x is not None and (not statuses or cached.cost(monitor.x) < cached.cost(x)):
            x = np.clip(monitor.x, lower, upper)
        elif monitor.x is None and not monitor.stopped and np.isfinite(last).all():
            x = np.clip(last, lower, upper)
        iterations, statuses = iterations + taken, [*statuses, status]
        if monitor.stopped:
            return SolverResult(x, problem.cost(x), iterations, False, INTERRUPTED, "")
        if monitor.no_gain and stage_type != "final":
            return SolverResult(x, problem.cost(x), iterations, True, CONTINUED, ", ".join(statuses))
        steps = min(LAST_STEPS, max_iterations - iterations)
        last_point = gauss_newton.last(x, steps)
        x, iterations = last_point.x, iterations + last_point.steps
        if last_point.converged or iterations >= max_iterations or stop():
            break
    reason, converged = last_point.reason, last_point.converged
    if not converged and (stop() or iterations >= max_iterations):
        reason = INTERRUPTED if stop() else f"{LIMIT}: {reason}"
    if not converged and stage_type != "final" and not stop():
        converged, reason = True, f"{reason}, {SUPERSEDED}"
    return SolverResult(x, problem.cost(x), iterations, converged, reason, ", ".join(statuses), last_point.errors)


def _ipopt(
    cached: _CachedCost, start: FloatArray, lower: FloatArray, upper: FloatArray, imposed: ConstraintFunctions,
    monitor: _IterationMonitor, overrides: Mapping[str, str | float],
) -> tuple[FloatArray, str, int]:  # fmt: skip
    """Return the last point of IPOPT, its return status, and its iterations."""
    n, m = len(start), len(imposed)
    dense, none = ca.Sparsity.dense, ca.Sparsity.dense(0, 0)
    triangle = ca.Sparsity.upper(n)
    z = ca.MX.sym("x", n)
    lower_rows = np.tril_indices(n)  # row by row: the columns of the upper triangle of a symmetric matrix
    cost = _Numeric("f", lambda x: [cached.cost(x)], [dense(n, 1)], [dense(1, 1)])
    gradient = _Numeric(
        "grad_f", lambda x, p: cached.derivatives(x)[:2], [dense(n, 1), none], [dense(1, 1), dense(n, 1)]
    )
    hessian = _Numeric(
        "hess_lag",
        lambda x, p, of_cost, of_g: [of_cost.item() * cached.damped(x)[lower_rows]],
        [dense(n, 1), none, dense(1, 1), dense(m, 1)],
        [triangle],
    )
    constraint_values = _Numeric("g", lambda x: [imposed.values(x)], [dense(n, 1)], [dense(m, 1)])
    jacobian = _Numeric("jac_g", lambda x, p: imposed.at(x), [dense(n, 1), none], [dense(m, 1), imposed.sparsity])
    options = {
        "grad_f": gradient,
        "hess_lag": hessian,
        "jac_g": jacobian,
        "iteration_callback": monitor,
        "no_nlp_grad": True,
        "calc_lam_p": False,
        "print_time": False,
        "error_on_fail": False,
        "show_eval_warnings": False,  # a trial step without a value is shortened; of a start the reason is stated
        "ipopt": {
            "print_level": 0,
            "sb": "yes",
            # With large residuals Gauss-Newton steps converge linearly, and IPOPT's own criterion would take hundreds
            # of iterations without gain. The monitor stops such a fit.
            "tol": 1e-7,
            "acceptable_iter": 0,
            # Initial values are good: IPOPT should not move them far into the interior.
            "mu_init": 1e-4,
            "bound_push": 1e-4,
            "bound_frac": 1e-4,
            # The Hessian has no curvature of the constraints, so second-order corrections would step far away.
            "max_soc": 0,
            # Damping shortens the steps; full steps of the watchdog increase the cost.
            "watchdog_shortened_iter_trigger": 0,
            "nlp_scaling_method": "none",
            "obj_scaling_factor": OBJECTIVE_SCALE,
            "bound_relax_factor": 0.0,
            **overrides,
        },
    }
    g = constraint_values(z) if m else ca.MX(0, 1)
    solver = ca.nlpsol("solver", "ipopt", {"x": z, "f": cost(z), "g": g}, options)
    with one_blas_thread():
        result = solver(x0=start, lbx=lower, ubx=upper, lbg=imposed.low, ubg=imposed.high)
    stats = solver.stats()
    status = "No_Further_Gain" if monitor.no_gain else str(stats["return_status"])
    return np.array(result["x"]).ravel(), status, int(stats["iter_count"])


class _CachedCost(Ridge):
    """Cost and derivatives, cached for repeated calls at one point, and the damping, adapted to the last step."""

    def __init__(self, problem: Problem, start: FloatArray, strength: float, progress: Progress | None) -> None:
        super().__init__(problem, start, strength)
        self.damping, self._progress, self._count = DAMPING, progress, 0
        self._x: FloatArray | None = None
        self._derivatives: tuple[float, FloatArray, FloatArray] = (np.inf, np.zeros(0), np.zeros((0, 0)))

    def derivatives(self, x: FloatArray) -> tuple[float, FloatArray, FloatArray]:
        """Return cost, gradient and Gauss-Newton matrix."""
        if self._x is None or not np.array_equal(x, self._x):
            before = self._derivatives[0]
            self._derivatives, self._x = super().derivatives(x), x.copy()
            self._count += 1
            if np.isfinite(before):
                factor = DAMPING_UP if self._derivatives[0] > before * (1 + 1e-9) else DAMPING_DOWN
                self.damping = min(max(self.damping * factor, MIN_DAMPING), MAX_DAMPING)
            if self._progress is not None:
                self._progress(self._count, self._derivatives[0], self._x)
        return self._derivatives

    def damped(self, x: FloatArray) -> FloatArray:
        """Return the damped Gauss-Newton matrix."""
        return self.derivatives(x)[2] + self.damping * np.eye(x.size)
