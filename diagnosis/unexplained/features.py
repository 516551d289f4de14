"""Physical features for the regression of unexplained structure, and the model quantities that they act on.

A sparse regression on physical features replaces one on polynomials. Each product is a factor or a term of a named
quantity, so that it can be added to the model equations. Rates and memories are computed from a recording at once. A
tire needs equations: a direction of change becomes the hysteresis of a lagged slip, a rate the difference between an
input and its lag.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.ndimage import uniform_filter1d

from ...numerics.arrays import FloatArray
from ...numerics.smoothing import rate_of
from ...symbolic.model import Model
from ...tires.states.transient import recursion
from ...tires.tire import Tire
from ..probing.candidates import excited, varies
from ..signals.signals import Signals
from ..signals.simulation import Simulator
from ..thresholds import SIDE

#: Inputs of the steady-state core. Structure in these alone is an error of the functional form, not a missing effect.
CORE_INPUTS = frozenset({"alpha", "kappa", "Fz"})


@dataclass(frozen=True, eq=False)
class Feature:
    """A physical feature over the compared rows.

    - `text`: formula in inputs and nominal values; a description for rates and memories.
    - `values`, shape (n,): dimensionless, of order 1.
    - `odd`: whether the sign changes under mirroring left to right. Odd features are terms; even ones are factors, or
      scale a term.
    - `formula`: the same as in an effect file: of a rate or memory, it reads states and resembles it.
    - `states`: the states that this formula requires, of `STATES`.
    - `slips`: the slips that it contains other than as the magnitude of both.
    """

    text: str
    depends_on: frozenset[str]
    values: FloatArray
    odd: bool = False
    formula: str = ""
    states: tuple[str, ...] = ()
    slips: frozenset[str] = frozenset()

    @property
    def inclined(self) -> bool:
        """Whether it is 0 at an upright wheel, since the inclination is a factor of it."""
        return "gamma" in self.depends_on

    def __mul__(self, other: Feature) -> Feature:
        return Feature(
            f"{bracketed(self.text)}*{bracketed(other.text)}",
            self.depends_on | other.depends_on,
            self.values * other.values,
            self.odd != other.odd,
            f"{bracketed(self.formula)}*{bracketed(other.formula)}",
            tuple(dict.fromkeys((*self.states, *other.states))),
            self.slips | other.slips,
        )


def bracketed(text: str) -> str:
    """Return a formula as a factor of a product."""
    return f"({text})" if " " in text else text


@dataclass(frozen=True)
class Location:
    """A part of the model in which structure can act.

    - `name`: friction, slip stiffness, ...
    - `how`: "factor" or "term".
    - `quantities`: named quantities of the model that change.
    - `coefficients`: coefficients whose derivatives (for a factor: times their values) are the response of the forces.
    - `per`: multiplier of a term that makes its coefficient dimensionless; '' if none.
    - `flips`: whether such a term changes its sign between adapted SAE and ISO.
    - `slips`: without these slips it changes nothing.
    - `upright`: coefficients through which the aligning moment follows the upright wheel, for which the book repeats
      the lines of the side force. The small arm of Fx, which inclination may change, is neglected.
    """

    name: str
    how: str
    quantities: tuple[str, ...]
    coefficients: tuple[str, ...]
    per: str = ""
    flips: bool = False
    slips: frozenset[str] = frozenset()
    upright: frozenset[str] = frozenset()

    @property
    def sideways(self) -> bool:
        """Whether its terms change their sign under mirroring left to right."""
        return self.name in SIDEWAYS

    @property
    def proportional_to(self) -> tuple[str, ...]:
        """The inputs that a term is proportional to."""
        return ("Fz",) if "Fz" in self.per.split("*") else ()


#: Places by name: how structure acts, and the roles of the quantities.
LOCATIONS = {
    "friction": ("factor", ("friction_x", "friction_y")),
    "slip stiffness": ("factor", ("stiffness_x", "stiffness_y")),
    "force": ("factor", ("friction_x", "friction_y", "stiffness_x", "stiffness_y")),
    "force and trail": ("factor", ("friction_x", "friction_y", "stiffness_x", "stiffness_y", "trail")),
    "trail": ("factor", ("trail",)),
    "side force": ("term", ("offset_y",)),
    "slip angle": ("term", ("shift_y",)),
    "longitudinal slip": ("term", ("shift_x",)),
    "aligning moment": ("term", ("residual_moment",)),
}
#: Those whose terms change their sign under mirroring left to right.
SIDEWAYS = ("side force", "slip angle", "aligning moment")
#: Roles of the aligning moment itself.
OF_MOMENT = frozenset({"trail", "residual_moment"})
#: Formulas of features in inputs and nominal values, dimensionless and of order 1. The heat of sliding is there with
#: speed and without it, as speed would stand for the load otherwise. MIDDLE is the mean temperature.
FORMULAS = (
    "Fz/FNOMIN - 1", "3*(p/NOMPRES - 1)", "2*absolute(phit)*UNLOADED_RADIUS", "(T - MIDDLE)/20", "distance/1000",
    "5*absolute(tan(alpha))*absolute(V)/LONGVL", "3*(absolute(V)/LONGVL - 1)", "10*absolute(gamma)",
    "5*absolute(tan(alpha))", "5*absolute(kappa)", "5*sqrt(tan(alpha)**2 + kappa**2)",
    "5*sqrt(tan(alpha)**2 + kappa**2)*Fz/FNOMIN", "5*sqrt(tan(alpha)**2 + kappa**2)*absolute(V)/LONGVL*Fz/FNOMIN",
    "5*absolute(tan(alpha))*Fz/FNOMIN", "5*absolute(tan(alpha))*absolute(V)/LONGVL*Fz/FNOMIN",
    "10*gamma", "5*tan(alpha)", "5*kappa",
)  # fmt: skip
#: Those that change their sign under mirroring left to right.
ODD = ("10*gamma", "5*tan(alpha)")
FUNCTIONS = {"absolute": np.absolute, "sqrt": np.sqrt, "tan": np.tan}
#: Time constant of the lag whose difference from its input replaces a rate, s.
RATE_LAG = 0.1
#: The states of proposed effects by name, which no effect of the library has: the keys of their tables in an effect
#: file. Each stands behind those that it reads.
#: Length and widths are those with which a diagnosis starts the effects of the library.
STATES: Mapping[str, Mapping[str, str | tuple[str, ...]]] = {
    "found_followed_kappa": {"kind": "lag", "drive": "kappa", "length": "0.05"},
    "found_followed_alpha": {"kind": "lag", "drive": "tan(alpha)", "length": "0.05"},
    "found_alpha_direction": {"kind": "hysteresis", "drive": "found_followed_alpha", "width": "0.02"},
    "found_kappa_direction": {"kind": "hysteresis", "drive": "found_followed_kappa", "width": "0.02"},
    "found_recent_alpha": {"kind": "lag", "drive": "alpha", "rate": "1/0.3"},
    "found_late_alpha": {"kind": "lag", "drive": "alpha", "rate": f"1/{RATE_LAG}"},
    "found_late_load": {"kind": "lag", "drive": "Fz", "rate": f"1/{RATE_LAG}"},
    "found_recent_slip_1": {"kind": "lag", "drive": "absolute(tan(alpha)) + absolute(kappa)", "rate": "1.0"},
    "found_recent_slip_5": {"kind": "lag", "drive": "absolute(tan(alpha)) + absolute(kappa)", "rate": "0.2"},
}
#: The slip without which the quantity of a role changes nothing.
SLIP_OF_ROLE = {
    "friction_x": "kappa",
    "stiffness_x": "kappa",
    "friction_y": "alpha",
    "stiffness_y": "alpha",
    "trail": "alpha",
}


def locations_of(model: Model) -> list[Location]:
    """Return the locations of a model in which structure can act: those whose roles it declares.

    >>> from tirefmu.symbolic.models import model_named
    >>> locations_of(model_named("mf96"))[0].coefficients
    ('PDX1', 'PDY1')
    """
    declarations, locations = model.coefficients, []
    for name, (how, roles) in LOCATIONS.items():
        acting = [role for role in roles if model.leading(role) in declarations]
        available = [model.roles[role] for role in acting]
        if available:
            quantities = tuple(dict.fromkeys(role.quantity for role in available))
            leading = tuple(dict.fromkeys(role.leading for role in available))
            flips = how == "term" and declarations[leading[0]].flips
            slips = frozenset(SLIP_OF_ROLE[role] for role in acting if role in SLIP_OF_ROLE)
            per = available[0].per if how == "term" else ""
            upright = frozenset(
                model.leading(role) for role in acting if model.structure.upright and role not in OF_MOMENT
            )
            locations.append(Location(name, how, quantities, leading, per, flips, slips, upright))
    return locations


def placed(
    simulator: Simulator, factors: Sequence[Feature], terms: Sequence[Feature]
) -> Iterator[tuple[Location, Feature]]:
    """Yield each location with the features that act there: factors or terms which the recording determines.

    A slip in the formula of a quantity that acts through the other slip requires combined slip: where there is none,
    noise of a slip that is zero has a large coefficient, with which the formula is far off elsewhere.
    """
    for location in locations_of(simulator.symbolic_model):
        for feature in factors if location.how == "factor" else terms:
            needed = feature.slips | location.slips if feature.slips and not feature.states else frozenset()
            if len(needed) < 2 or excited(simulator.signals, simulator.tire, sorted(needed)):
                yield location, feature


def directions(simulator: Simulator, parameters: FloatArray) -> dict[tuple[str, bool], FloatArray]:
    """Return the response of the forces to each location, N and N m, shape (n_channels, n).

    By name of location and whether a feature that acts there is inclined: such a one does not change the upright wheel.

    `parameters`, shape (n_parameters,).
    """
    locations = locations_of(simulator.symbolic_model)
    names = [name for location in locations for name in location.coefficients]
    jacobian = simulator.jacobian(parameters, names)
    follows = np.array([channel == "Mz" for channel in simulator.signals.channels])[:, None]
    responses = {}
    for location in locations:
        for inclined in (False, True):
            parts = [
                np.where(follows & (inclined and name in location.upright), 0.0, jacobian[:, :, names.index(name)])
                * (parameters[simulator.index[name]] if location.how == "factor" else 1.0)
                for name in location.coefficients
            ]
            responses[location.name, inclined] = np.sum(parts, axis=0)
    return responses


def features(signals: Signals, tire: Tire) -> tuple[list[Feature], list[Feature]]:
    """Return even features (operating conditions, magnitudes of slip) and odd features (sign of a lateral input).

    An input that does not vary is in no formula; a memory of several inputs depends on those that vary.
    """
    named = signals.everywhere.named()
    even_ones: list[Feature] = []
    odd_ones: list[Feature] = []
    constant = frozenset(name for name in signals.names if not varies(signals, tire, name))
    sources = signals.origin.recorded | {"dalpha/dt", "dkappa/dt", "dFz/dt", "memory"}
    past = _of_the_past(signals.t, named) if signals.timed else ()
    for feature in (*_of_inputs(named, tire), *past):
        values, read = feature.values[signals.rows], feature.depends_on
        rates = {name[1:].partition("/")[0] for name in read if name.endswith("/dt")}
        depends_on = read - constant
        if constant & (rates if feature.states else read) or not depends_on & sources or float(np.std(values)) <= 1e-9:
            continue
        slips = depends_on & {"alpha", "kappa"}
        slips = slips if len(slips) == 1 else frozenset()
        (odd_ones if feature.odd else even_ones).append(
            replace(feature, depends_on=depends_on, values=values, slips=slips)
        )
    return even_ones, odd_ones


def _of_inputs(named: Mapping[str, FloatArray], tire: Tire) -> Iterator[Feature]:
    """Yield the features of inputs whose nominal values the tire has."""
    middle = str(round(float(named["T"].mean()))) if "T" in named else ""
    for text in (formula.replace("MIDDLE", middle) for formula in FORMULAS):
        read = set(re.findall(r"[A-Za-z]\w*", text)) - FUNCTIONS.keys()
        inputs = read & named.keys()
        if read - inputs <= tire.values.keys():
            values = eval(text, {**FUNCTIONS, **{name: named.get(name, tire.values.get(name)) for name in read}})
            yield Feature(text, frozenset(inputs), values, text in ODD, text)


def _of_the_past(t: FloatArray, named: Mapping[str, FloatArray]) -> Iterator[Feature]:
    """Yield features of rates of change and of memory: first-order lags of the inputs.

    `t`, shape (m,), s. `named`, shape (m,): inputs.
    """
    steps = np.diff(t)
    step = float(np.median(steps[steps > 0.0]))
    width = max(3, round(0.1 / step))

    def rate(name: str) -> FloatArray:
        return np.asarray(uniform_filter1d(rate_of(named[name], t), width, mode="nearest"))

    def in_units(name: str, state: str, unit: float, odd: bool) -> Feature:
        """Return a rate in multiples of a unit: the difference between an input and its lag."""
        formula = f"{1.0 / (RATE_LAG * unit):.4g}*({name} - {state})"
        return Feature(f"rate of {name}", frozenset({f"d{name}/dt"}), rate(name) / unit, odd, formula, (state,))

    for slip, odd in (("alpha", True), ("kappa", False)):
        turning, changing = rate(slip), frozenset({f"d{slip}/dt", "memory"})
        typical = 0.3 * float(np.sqrt(np.mean(turning**2))) + 1e-9
        direction, state = np.tanh(turning / typical), f"found_{slip}_direction"
        states = (f"found_followed_{slip}", state)
        if odd:
            yield in_units("alpha", "found_late_alpha", 3.3 * typical, odd)
        yield Feature(f"direction of {slip}'s change", changing, direction, odd, state, states)
        signed, formula = direction * np.tanh(named[slip] / SIDE), f"{state}*tanh({slip}/{SIDE})"
        yield Feature(f"{slip} growing or falling", changing | {slip}, signed, False, formula, states)
    yield in_units("Fz", "found_late_load", float(np.std(rate("Fz"))) + 1e-9, False)
    slide, slips = np.abs(np.tan(named["alpha"])) + np.abs(named["kappa"]), frozenset({"memory", "alpha", "kappa"})
    for seconds in (1.0, 5.0):
        name, values = f"found_recent_slip_{seconds:g}", 5.0 * _low_pass(slide, step / seconds)
        yield Feature(f"slip of the last {seconds:g} s", slips, values, False, f"5*{name}", (name,))
    values, name = 5.0 * _low_pass(named["alpha"], step / 0.3), "found_recent_alpha"
    yield Feature("alpha of the last 0.3 s", frozenset({"dalpha/dt", "memory"}), values, True, f"5*{name}", (name,))


def _low_pass(values: FloatArray, share: float) -> FloatArray:
    """Return a signal behind a first-order lag; `share` is the ratio of time step and time constant."""
    decay = float(np.exp(-share))
    return recursion(float(values[0]), np.full(len(values) - 1, decay), (1.0 - decay) * values[1:])
