"""The options of a fit: which effects, which recipe and solver, which rows with which weights, which constraints."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from math import inf, isfinite

from ..boundary.errors import FitError
from ..boundary.escaping import excerpt
from ..tires import TireLike

#: Default weight of a slip stiffness that is read from the data: the study in docs/stiffness.md.
STIFFNESS_WEIGHT = 10.0


@dataclass(frozen=True)
class FitOptions:
    """What a fit determines and how, apart from the data, the model and the start tire.

    Attributes
    ----------
    effects : collection of str, optional
        Exactly these effects in addition to the model's core; by default all effects of the model.
    without : collection of str
        Effects to exclude.
    recipe : str, optional
        "progressive", "joint", "trento", "scaling" (of the start tire), a recipe that the model defines, or the path of
        a TOML file; by default the recipe of the model.
    loss : {"squares", "huber", "cauchy"}
        Cost of a residual. "huber" (linear) and "cauchy" (logarithmic) reduce the influence of outliers. They apply
        above 1.3 and 2.4 standard deviations of the noise of the channel.
    method : {"ipopt", "ioa"}
        IPOPT with exact derivatives, or the UNICAMP paper's evolutionary algorithm
        (`tirefmu.fitting.solvers.evolution`).
    iterations : int, optional
        Upper limit for each stage; by default the limit of the method (300, 10,000).
    seed : int
        Seed of a random method.
    nominal : mapping of str to float, optional
        Fz0 (N), R0 (m), p0 (Pa), V0 (m/s), as far as the model has them; by default the medians of the data, and the
        radius that `size` or the recordings show.
    size : str, optional
        Designation of the tire's size, "245/45R18" or "16x7.5-10": radius, width and rim radius. By default that in the
        title of a recording.
    screening : bool
        Whether to exclude outliers and rows of a cold tread, of transitions between levels, and of a lifted or
        stationary wheel (`FitResult.excluded_rows`). Goodness of fit is computed over all rows.
    rows : str
        Weights of rows: "condition" (equal weight of every operating condition of a recording, independent of its
        number of rows), "equal" (equal weight of every row), "independent" (as "condition", and each channel of a
        recording by its effective sample size), or "load" (as "condition", with errors relative to the load).
    weights : mapping of str to float
        Factors of the weights of rows that satisfy an expression, as in ``--where``:
        ``{"Fz in 200..240 N": 2.0}``. The mean weight of a recording remains 1.
    fixed : mapping of str to float
        Coefficients that are not fitted, with their values in ISO-W.
    stiffness_weight : float
        Weight of the slip stiffness that is read from the data at each load, as a number of independent rows; 0: it is
        not fitted (`docs/stiffness.md`).
    family : path or Tire, optional
        A folder of .tir files of similar tires, a tire or the name of a published tire: the prior of the coefficients
        (`tirefmu.fitting.family`). Its mean is the start tire unless one is given.
    temperature : str, optional
        The recorded temperature of the tread, deg C, to which the effect ``temperature`` is fitted after the forces; by
        default ``T`` if `effects` has this effect (`tirefmu.fitting.temperature`).
    sensor_errors : bool
        Whether intervals contain slow errors of the sensors of a test bench: offsets, drift, cross-talk
        (`tirefmu.fitting.uncertainty.sensor_errors`).
    constraints, without_constraints : collection of str
        Physical constraints to enforce in addition to the default ones, and constraints not to enforce, by name or kind
        (`tirefmu.fitting.constraints.physical`); "all" means all constraints.
    """

    effects: Collection[str] | None = None
    without: Collection[str] = ()
    recipe: str | None = None
    loss: str = "squares"
    method: str = "ipopt"
    iterations: int | None = None
    seed: int = 0
    nominal: Mapping[str, float] | None = None
    size: str | None = None
    screening: bool = True
    rows: str = "condition"
    weights: Mapping[str, float] = field(default_factory=dict)
    fixed: Mapping[str, float] = field(default_factory=dict)
    stiffness_weight: float = STIFFNESS_WEIGHT
    family: TireLike | None = None
    temperature: str | None = None
    sensor_errors: bool = True
    constraints: Collection[str] = ()
    without_constraints: Collection[str] = ()

    def __post_init__(self) -> None:
        if not 0.0 <= self.stiffness_weight < inf:
            raise FitError(f"stiffness weight {self.stiffness_weight:g} is not a number of rows")
        for expression, factor in self.weights.items():
            if not 0.0 < factor < inf:
                raise FitError(f"weight {factor:g} of rows with {excerpt(expression)} is not positive and finite")
        for name, value in self.fixed.items():
            if not isfinite(value):
                raise FitError(f"fixed {name} is not finite")
        if self.method != "ipopt" and self.loss != "squares":
            raise FitError(f"loss {self.loss} is for method ipopt: {self.method} minimizes squares")
        if self.method != "ipopt" and self.family is not None:
            raise FitError(f"a family is for method ipopt, not for {self.method}")
