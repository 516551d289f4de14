"""The options of a fit, each declared once: `tirefmu.fit`, ``tirefmu fit``, project, job list and window follow."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, fields
from math import inf, isfinite
from typing import TYPE_CHECKING, Any

from ..boundary.errors import FitError
from ..boundary.escaping import excerpt
from ..symbolic.contract import CONSTRAINT_KINDS

if TYPE_CHECKING:
    from ..tires import TireLike

#: Default weight of a slip stiffness that is read from the data: the study in docs/stiffness.md.
STIFFNESS_WEIGHT = 10.0
#: Versions of the files with options as keys: a new key increments the second number.
VERSIONS = {"project": "1.1", "jobs": "1.0"}


@dataclass(frozen=True)
class Declaration:
    """How an option is given.

    - `kind`: "text", "names", "name or file", "integer", "number", "pairs" (numbers by name), "weights" (factors by
      expression) or "flag" (the option of the command line sets it to false).
    - `flag`, `help`, `metavar`: of the command line.
    - `least`: smallest number.
    - `files`: those of `VERSIONS` that have it as a key.
    - `label`, `choices`: in the window: its name, and its values with their meanings.
    """

    kind: str
    flag: str
    help: str
    metavar: str | None = None
    least: int | None = None
    files: Collection[str] = ("project", "jobs")
    label: str = ""
    choices: Mapping[str, str] = field(default_factory=dict)


def _declared(kind: str, flag: str, help_text: str, **how: Any) -> dict[str, Declaration]:
    return {"declaration": Declaration(kind, flag, help_text, **how)}


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

    effects: Collection[str] | None = field(
        default=None,
        metadata=_declared("names", "--effects", "Exactly these effects in addition to the core, or 'none'."),
    )
    without: Collection[str] = field(default=(), metadata=_declared("names", "--without", "All effects except these."))
    family: TireLike | None = field(
        default=None,
        metadata=_declared(
            "name or file",
            "--family",
            "Prior of the coefficients: .tir files of similar tires, or a published tire.",
            metavar="FOLDER|NAME",
            files=(),
        ),
    )
    recipe: str | None = field(
        default=None,
        metadata=_declared(
            "name or file",
            "--recipe",
            "progressive, joint, trento, scaling (of --start), one of the model's own, or a TOML file  "
            "[default: the model's]",
        ),
    )
    method: str = field(
        default="ipopt",
        metadata=_declared(
            "text",
            "--method",
            "ipopt, or ioa: an evolutionary algorithm without derivatives, for comparison.",
            files=("jobs",),
        ),
    )
    iterations: int | None = field(
        default=None,
        metadata=_declared(
            "integer",
            "--iterations",
            "Iteration limit of a stage  [default: ipopt 300, ioa 10000]",
            least=1,
            files=("jobs",),
        ),
    )
    seed: int = field(
        default=0,
        metadata=_declared(
            "integer", "--seed", "Seed of the random numbers of ioa and --bootstrap.", least=0, files=("jobs",)
        ),
    )
    constraints: Collection[str] = field(
        default=(),
        metadata=_declared(
            "names",
            "--constraint",
            "Physical constraints in addition to the default ones: "
            f"{', '.join(f'{kind} ({more})' for kind, more in CONSTRAINT_KINDS.items() if more)}, or all.",
        ),
    )
    without_constraints: Collection[str] = field(
        default=(),
        metadata=_declared(
            "names",
            "--without-constraint",
            f"Physical constraints to remove: {', '.join(CONSTRAINT_KINDS)}, a single one (curvature:E_y), or all.",
        ),
    )
    loss: str = field(
        default="squares",
        metadata=_declared(
            "text",
            "--loss",
            "Loss function: squares; huber or cauchy for data with outliers.",
            label="Loss",
            choices={"squares": "squares", "huber": "huber", "cauchy": "cauchy"},
        ),
    )
    nominal: Mapping[str, float] | None = field(
        default=None, metadata=_declared("pairs", "--nominal", "Nominal values: Fz0 (N), R0 (m), p0 (Pa), V0 (m/s).")
    )
    size: str | None = field(
        default=None,
        metadata=_declared(
            "text",
            "--size",
            "Size of the tire, 245/45R18 or 16x7.5-10: radius, width and rim  [default: as recorded]",
            files=("project",),
        ),
    )
    screening: bool = field(
        default=True,
        metadata=_declared(
            "flag", "--all-rows", "Do not exclude rows (warm-up, transitions, outliers).", files=("jobs",)
        ),
    )
    rows: str = field(
        default="condition",
        metadata=_declared(
            "text",
            "--rows",
            "Weights of rows: condition (equal per operating condition), equal, independent (by effective sample "
            "size), or load (errors relative to the load).",
            label="Weights of rows",
            choices={
                "condition": "equal by condition",
                "equal": "equal",
                "independent": "by effective sample size",
                "load": "relative to the load",
            },
        ),
    )
    weights: Mapping[str, float] = field(
        default_factory=dict,
        metadata=_declared(
            "weights",
            "--weight",
            "Multiply the weights of rows by a factor: '2: Fz in 200..240 N'. Repeatable.",
            metavar="FACTOR:EXPRESSION",
            files=("project",),
        ),
    )
    fixed: Mapping[str, float] = field(
        default_factory=dict,
        metadata=_declared(
            "pairs",
            "--fix",
            "Coefficients that are not fitted, with their values in ISO-W: PCY1=1.3,PHY1=0.",
            files=("project",),
        ),
    )
    stiffness_weight: float = field(
        default=STIFFNESS_WEIGHT,
        metadata=_declared(
            "number",
            "--stiffness-weight",
            "Weight of the slip stiffness read from the data at each load, in rows; 0: not fitted.",
            least=0,
            files=("project",),
        ),
    )
    sensor_errors: bool = field(
        default=True,
        metadata=_declared(
            "flag", "--exact-sensors", "Intervals without offsets, drift and cross-talk of the sensors.", files=()
        ),
    )
    temperature: str | None = field(
        default=None,
        metadata=_declared(
            "text",
            "--temperature",
            "Also fit the effect temperature to this recorded temperature, deg C  [default: T, if --effects has "
            "temperature]",
            metavar="COLUMN",
            files=("project",),
        ),
    )

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


def declared_options(file: str = "") -> dict[str, tuple[Declaration, Any]]:
    """Return the declaration and the default of each option by its name.

    `file`: only those that this kind of file has as keys.

    >>> declared_options()["loss"][0].flag, "seed" in declared_options("project")
    ('--loss', False)
    """
    defaults = vars(FitOptions())
    declared = {part.name: (part.metadata["declaration"], defaults[part.name]) for part in fields(FitOptions)}
    return {name: option for name, option in declared.items() if not file or file in option[0].files}
