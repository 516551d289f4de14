"""IPOPT through CasADi: our cost with exact gradient and Gauss-Newton Hessian, the book's constraints with AD.

The cost comes from compiled code over all rows, so CasADi sees it as a callback; so do the constraints, which
the generated CasADi functions give with exact derivatives.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np
import numpy.typing as npt
from threadpoolctl import threadpool_limits

from .constraints import Constraint
from .imposed import Imposed
from .problem import Problem

FloatArray = npt.NDArray[np.float64]
#: The cost is about 1 at the start and 0.001 at the end; IPOPT's barrier is made for larger numbers.
OBJECTIVE_SCALE = 1e3
#: Levenberg-Marquardt: what is added to the Gauss-Newton matrix, in scaled coefficients, and how it follows success.
DAMPING, LEAST_DAMPING, MOST_DAMPING = 1e-3, 1e-7, 1.0
DAMPING_UP, DAMPING_DOWN = 10.0, 0.2
#: A fit has converged when so many iterations have brought the best cost within the constraints down by less than such
#: a share of it: the less, the further there is to go. An approach is followed by another one, a passage by a fit of
#: the same coefficients to all rows. Three steps without any gain say nothing: narrow stages go on after them.
LEAST_GAIN = {"approach": (2, 1e-2), "passage": (4, 1e-5), "end": (10, 1e-5)}
#: Reasons to stop within the constraints that count as converged: the watch's, and steps below machine precision.
AT_REST = ("No_Further_Gain", "Search_Direction_Becomes_Too_Small")
#: The reason of a solution that somebody asked to end.
INTERRUPTED = "Interrupted"
#: Called with (iteration, cost) as the solver goes on.
Progress = Callable[[int, float], None]


@dataclass(frozen=True)
class Solution:
    """What IPOPT came back with.

    Attributes
    ----------
    x : ndarray, shape (n_free,)
        Scaled free values.
    cost : float
    iterations : int
    converged : bool
    reason : str
        IPOPT's own word for why it stopped, or ours: nothing more to gain, interrupted.
    """

    x: FloatArray
    cost: float
    iterations: int
    converged: bool
    reason: str


class _Numeric(ca.Callback):  # type: ignore[misc]
    """A CasADi function whose values a Python function computes."""

    def __init__(self, name: str, compute: Callable[..., list[Any]], into: list[Any], out: list[Any]) -> None:
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

    def eval(self, arguments: list[Any]) -> list[Any]:
        return self._compute(*(np.array(argument, dtype=float) for argument in arguments))


class _Watch(ca.Callback):  # type: ignore[misc]
    """Keep the best point within the constraints, and stop when there is nothing more to gain."""

    def __init__(self, n: int, imposed: Imposed, stop: Callable[[], bool], *, leg: str) -> None:
        ca.Callback.__init__(self)
        self._n, self._imposed, self._stop = n, imposed, stop
        self._patience, self._least = LEAST_GAIN[leg]
        self._costs: list[float] = []  # the best cost after each iteration
        self.x: FloatArray | None = None
        self.settled = self.stopped = False
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

    def eval(self, arguments: list[Any]) -> list[Any]:
        told = dict(zip((ca.nlpsol_out(i) for i in range(self.get_n_in())), arguments, strict=True))
        g, cost = np.array(told["g"]).ravel(), float(told["f"])
        if self._imposed.kept(g) and (self.x is None or cost < self._costs[-1]):
            self.x = np.array(told["x"]).ravel()
            self._costs.append(cost)
        elif self.x is not None:
            self._costs.append(self._costs[-1])
        if len(self._costs) > self._patience:
            gain = self._costs[-1 - self._patience] - self._costs[-1]
            self.settled = gain < self._least * abs(self._costs[-1])
        self.stopped = not self.settled and self._stop()
        return [int(self.settled or self.stopped)]


def solve(
    problem: Problem,
    start: FloatArray,
    lower: FloatArray,
    upper: FloatArray,
    constraints: list[tuple[Constraint, FloatArray]],
    *,
    ridge: float = 1e-9,
    leg: str = "end",
    max_iterations: int = 300,
    progress: Progress | None = None,
    stop: Callable[[], bool] = lambda: False,
) -> Solution:
    """Minimize the cost within bounds and constraints.

    Parameters
    ----------
    problem : Problem
    start, lower, upper : ndarray, shape (n_free,)
        Scaled free values.
    constraints : list of (Constraint, ndarray of shape (n_inputs, n_points))
        Conditions and the points at which they hold.
    ridge : float
        Pull of every scaled value towards its start, against directions that the data leave open.
    leg : {"approach", "passage", "end"}
        How little has to be gained to stop there: less before the end, where other fits go on.
    max_iterations : int
    progress : callable, optional
    stop : callable
        Asked after every iteration whether to end there, with the best point within the constraints, or the start
        where there was none.

    Returns
    -------
    Solution
        Also where IPOPT did not converge: then `converged` is False and `reason` says why.
    """
    n = len(start)
    dense, none = ca.Sparsity.dense, ca.Sparsity.dense(0, 0)
    triangle = ca.Sparsity.upper(n)
    memory = _Memory(problem, start, ridge, progress)
    z = ca.MX.sym("x", n)
    imposed = Imposed(problem, constraints)
    low, high, m = imposed.low, imposed.high, len(imposed)
    cost = _Numeric("f", lambda x: [memory.cost(x)], [dense(n, 1)], [dense(1, 1)])
    gradient = _Numeric("grad_f", lambda x, p: list(memory.at(x)[:2]), [dense(n, 1), none], [dense(1, 1), dense(n, 1)])
    hessian = _Numeric(
        "hess_lag",
        lambda x, p, of_cost, of_g: [ca.project(ca.DM(of_cost.item() * memory.matrix(x)), triangle)],
        [dense(n, 1), none, dense(1, 1), dense(m, 1)],
        [triangle],
    )
    conditions = _Numeric("g", lambda x: [imposed.values(x.ravel())], [dense(n, 1)], [dense(m, 1)])
    jacobian = _Numeric(
        "jac_g",
        lambda x, p: [imposed.values(x.ravel()), imposed.jacobian(x.ravel())],
        [dense(n, 1), none],
        [dense(m, 1), imposed.sparsity],
    )
    watch = _Watch(n, imposed, stop, leg=leg)
    options = {
        "grad_f": gradient,
        "hess_lag": hessian,
        "jac_g": jacobian,
        "iteration_callback": watch,
        "no_nlp_grad": True,
        "calc_lam_p": False,
        "print_time": False,
        "error_on_fail": False,
        "ipopt": {
            "print_level": 0,
            "sb": "yes",
            "max_iter": max_iterations,
            # Far from a perfect model Gauss-Newton steps close in linearly, and IPOPT's own criterion would take
            # hundreds of iterations that gain nothing; what stops a fit then is the watch.
            "tol": 1e-7,
            "acceptable_iter": 0,
            # Starting values are good ones: do not push them far into the interior.
            "mu_init": 1e-4,
            "bound_push": 1e-4,
            "bound_frac": 1e-4,
            # Second-order corrections step far away where the constraints bend, which our Hessian leaves out.
            "max_soc": 0,
            # Shortened steps are the damping's business; a watchdog's full ones leave the valley.
            "watchdog_shortened_iter_trigger": 0,
            "nlp_scaling_method": "none",
            "obj_scaling_factor": OBJECTIVE_SCALE,
            "bound_relax_factor": 0.0,
        },
    }
    g = conditions(z) if m else ca.MX(0, 1)
    solver = ca.nlpsol("solver", "ipopt", {"x": z, "f": cost(z), "g": g}, options)
    # Matrices of a few thousand rows by a hundred columns: BLAS threads would spend their time waiting.
    with threadpool_limits(limits=1, user_api="blas"):
        result = solver(x0=start, lbx=lower, ubx=upper, lbg=low, ubg=high)
    stats = solver.stats()
    ended = "No_Further_Gain" if watch.settled else INTERRUPTED if watch.stopped else ""
    reason = ended or str(stats["return_status"])
    converged = bool(stats["success"]) or (watch.x is not None and reason in AT_REST)
    last = start if watch.stopped else np.array(result["x"]).ravel()
    found = last if stats["success"] or watch.x is None else watch.x
    x = np.clip(found, lower, upper) if np.isfinite(found).all() else start
    return Solution(x, problem.cost(x), int(stats["iter_count"]), converged, reason)


class _Memory:
    """Cost and derivatives with the ridge, kept for the point at which IPOPT asks again, and the damping."""

    def __init__(self, problem: Problem, start: FloatArray, ridge: float, progress: Progress | None) -> None:
        self._problem, self._start, self._ridge, self._progress = problem, start.copy(), ridge, progress
        self._x: FloatArray | None = None
        self._kept: tuple[float, FloatArray, FloatArray] = (np.inf, start, start)
        self._damping = DAMPING
        self._count = 0

    def cost(self, x: FloatArray) -> float:
        away = x.ravel() - self._start
        return self._problem.cost(x.ravel()) + 0.5 * self._ridge * float(away @ away)

    def at(self, x: FloatArray) -> tuple[float, FloatArray, FloatArray]:
        """Return cost, gradient and Gauss-Newton matrix."""
        x = x.ravel()
        if self._x is None or not np.array_equal(x, self._x):
            before = self._kept[0]
            cost, gradient, matrix = self._problem.derivatives(x)
            away = x - self._start
            cost += 0.5 * self._ridge * float(away @ away)
            self._kept = (cost, gradient + self._ridge * away, matrix + self._ridge * np.eye(len(x)))
            self._x = x.copy()
            self._count += 1
            if np.isfinite(before):
                factor = DAMPING_UP if cost > before * (1 + 1e-9) else DAMPING_DOWN
                self._damping = min(max(self._damping * factor, LEAST_DAMPING), MOST_DAMPING)
            if self._progress is not None:
                self._progress(self._count, cost)
        return self._kept

    def matrix(self, x: FloatArray) -> FloatArray:
        """Return the damped Gauss-Newton matrix."""
        return self.at(x)[2] + self._damping * np.eye(x.size)
