"""Physical features for the regression of unexplained structure, and the model quantities that they act on.

A sparse regression on physical features replaces one on polynomials. Each product is a factor or a term of a named
quantity, so that it can be added to the model equations.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from ...numerics.arrays import FloatArray
from ...symbolic.model import Model
from ...tires.tire import Tire
from ..probing.candidates import excited, varies
from ..signals.signals import Signals
from ..signals.simulation import Simulator
from .past import Described, rates_and_memory

#: Inputs of the steady-state core. Structure in these alone is an error of the functional form, not a missing effect.
CORE_INPUTS = frozenset({"alpha", "kappa", "Fz"})


@dataclass(frozen=True, eq=False)
class Feature:
    """A physical feature over the compared rows.

    - `text`: formula in inputs and nominal values; a description for rates and memories.
    - `values`, shape (n,): dimensionless, of order 1.
    - `odd`: whether the sign changes under mirroring left to right. Odd features are terms; even ones are factors, or
      scale a term.
    - `expressible`: whether the text is a formula of inputs and nominal values.
    - `formula`: of a rate or memory: a formula that reads states and resembles it, or ''.
    - `states`: the states that this formula requires, of `past.STATES`.
    - `slips`: the slips that it contains other than as the magnitude of both.
    """

    text: str
    depends_on: frozenset[str]
    values: FloatArray
    odd: bool = False
    expressible: bool = True
    formula: str = ""
    states: tuple[str, ...] = ()
    slips: frozenset[str] = frozenset()

    @property
    def in_effect_file(self) -> str:
        """The formula in an effect file, or '' if none can contain it."""
        return self.text if self.expressible else self.formula

    def __mul__(self, other: Feature) -> Feature:
        formulas = self.in_effect_file, other.in_effect_file
        return Feature(
            f"{bracketed(self.text)}*{bracketed(other.text)}",
            self.depends_on | other.depends_on,
            self.values * other.values,
            self.odd != other.odd,
            self.expressible and other.expressible,
            "*".join(map(bracketed, formulas)) if all(formulas) else "",
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
    """

    name: str
    how: str
    quantities: tuple[str, ...]
    coefficients: tuple[str, ...]
    per: str = ""
    flips: bool = False
    slips: frozenset[str] = frozenset()

    @property
    def proportional_to(self) -> tuple[str, ...]:
        """The inputs that a term is proportional to."""
        return ("Fz",) if "Fz" in self.per.split("*") else ()


#: Places by name: how structure acts, and the roles of the quantities.
LOCATIONS = {
    "friction": ("factor", ("friction_x", "friction_y")),
    "slip stiffness": ("factor", ("stiffness_x", "stiffness_y")),
    "force": ("factor", ("friction_x", "friction_y", "stiffness_x", "stiffness_y")),
    "trail": ("factor", ("trail",)),
    "side force": ("term", ("offset_y",)),
    "slip angle": ("term", ("shift_y",)),
    "longitudinal slip": ("term", ("shift_x",)),
    "aligning moment": ("term", ("residual_moment",)),
}
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
            locations.append(Location(name, how, quantities, leading, per, flips, slips))
    return locations


def determined(location: Location, feature: Feature, signals: Signals, tire: Tire) -> bool:
    """Return whether a recording determines a formula with a feature at a location.

    A slip in the formula of a quantity that acts through the other slip requires combined slip: where there is none,
    noise of a slip that is zero has a large coefficient, with which the formula is far off elsewhere.
    """
    needed = feature.slips | location.slips if feature.slips else feature.slips
    return not feature.expressible or len(needed) < 2 or excited(signals, tire, sorted(needed))


def directions(simulator: Simulator, parameters: FloatArray) -> dict[str, FloatArray]:
    """Return the response of the forces to each location, N and N m, shape (n_channels, n), by name of location.

    `parameters`, shape (n_parameters,).
    """
    locations = locations_of(simulator.symbolic_model)
    names = [name for location in locations for name in location.coefficients]
    jacobian = simulator.jacobian(parameters, names)
    responses = {}
    for location in locations:
        parts = [
            jacobian[:, :, names.index(name)] * (parameters[simulator.index[name]] if location.how == "factor" else 1.0)
            for name in location.coefficients
        ]  # fmt: skip
        responses[location.name] = np.sum(parts, axis=0)
    return responses


def features(signals: Signals, tire: Tire) -> tuple[list[Feature], list[Feature]]:
    """Return even features (operating conditions, magnitudes of slip) and odd features (sign of a lateral input).

    An input that does not vary is in no formula; a memory of several inputs depends on those that vary.
    """
    named = signals.everywhere.named()
    even_ones: list[Feature] = []
    odd_ones: list[Feature] = []
    constant = frozenset(name for name in signals.names if not varies(signals, tire, name))
    past = rates_and_memory(signals.t, named) if signals.timed else ()
    for text, depends, every, odd, formula, states in (*_of_inputs(named, tire), *past):
        values, names = every[signals.rows], frozenset(depends.split())
        rates = {name[1:].partition("/")[0] for name in names if name.endswith("/dt")}
        if constant & (rates if states else names):
            continue
        names -= constant
        sources = signals.origin.recorded | {"dalpha/dt", "dkappa/dt", "dFz/dt", "memory"}
        if float(np.std(values)) > 1e-9 and names & sources:
            slips = names & {"alpha", "kappa"}
            slips = slips if len(slips) == 1 else frozenset()
            feature = Feature(text, names, values, odd, not states, formula, states, slips)
            (odd_ones if odd else even_ones).append(feature)
    return even_ones, odd_ones


def _of_inputs(named: Mapping[str, FloatArray], tire: Tire) -> Iterator[Described]:
    """Yield the features of inputs whose nominal values the tire has."""
    middle = str(round(float(named["T"].mean()))) if "T" in named else ""
    for text in (formula.replace("MIDDLE", middle) for formula in FORMULAS):
        read = set(re.findall(r"[A-Za-z]\w*", text)) - FUNCTIONS.keys()
        inputs = read & named.keys()
        if read - inputs <= tire.values.keys():
            values = eval(text, {**FUNCTIONS, **{name: named.get(name, tire.values.get(name)) for name in read}})
            yield text, " ".join(inputs), values, text in ODD, "", ()
