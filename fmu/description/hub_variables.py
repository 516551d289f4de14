"""The variables of a native FMU with hub inputs: motion of the carrier, road, forces at the wheel centre."""

from __future__ import annotations

from dataclasses import replace
from math import inf

from ...symbolic.declarations import Quantity
from ...symbolic.quantities import FZ
from ...symbolic.wheel import quantities as hub
from ...tires import Tire
from ...tires.evaluation import quantities as quantities_of
from ...tires.property_file.text import number_and_rest
from .variables import Variable, input_variable

#: The smallest friction of a road relative to that of the tire: the formulas divide by it.
MIN_FRICTION = 0.01
#: Deflection by the nominal load, per free radius, of a tire without equations of deflection.
DEFAULT_DEFLECTION = 0.06
#: Vertical damping, N s/m, and the loaded radius at which the rim touches the road, per free radius.
DEFAULT_DAMPING, DEFAULT_BOTTOM = 50.0, 0.5

DEFLECTION = Quantity("deflection", "m", "free radius UNLOADED_RADIUS less loaded radius", typical=0.02)
BRAKE = Quantity(
    "brake_torque",
    "N m",
    "torque of the brake on the wheel about its axis; in Co-Simulation its mean in the last step",
    typical=100.0,
)
BRAKE_EVENT = Variable(
    "brake_event",
    "local",
    "1",
    "event indicator: the spin, rad/s, or the torque that a holding brake could still apply, N m",
    nominal=1.0,
    group="extra",
    source="BRAKE_EVENT",
)
#: Inputs of a wheel that spins inside the FMU.
TORQUES = (
    Variable("T_drive", "input", "N m", "drive torque on the wheel about its axis", 0.0, nominal=100.0, group="input"),
    Variable("T_brake", "input", "N m", "largest torque of the brake", 0.0, 0.0, nominal=100.0, group="input"),
)
WHEEL_INERTIA = Variable(
    "WHEEL_INERTIA", "parameter", "kg m^2", "moment of inertia of the wheel about its axis", 1.0, 1e-6, inf
)
#: The results of the C code for the hub, in its order; see hub.h.
RESULTS = (
    *hub.MOTION,
    hub.LOADED_RADIUS,
    hub.RADIUS_RATE,
    *hub.CONTACT_POINT,
    FZ,
    DEFLECTION,
    *hub.WRENCH,
    *hub.GLOBAL_WRENCH,
    BRAKE,
)
#: The results that are inputs of the contact kinematics.
READ = (*hub.MOTION, FZ)


def hub_inputs(tire: Tire, read: set[str], speed: float, spin: float, *, spins: bool) -> list[Variable]:
    """Return the inputs: a freely rolling wheel with its nominal load at the start.

    `read`: the inputs of the model that the tire needs. `speed`, `spin`: at the start, m/s and rad/s. `spins`: whether
    the spin of the wheel is a state. It then is an output, whose start value can be set. Returns: the arguments of the
    generated function ``wheel_motion``, then the friction of the road, torques, and the inputs of the model that are no
    motion.

    >>> from tirefmu.tires import published
    >>> [variable.name for variable in hub_inputs(published("trento_hoosier"), {"Fz"}, 10.0, 40.0, spins=False)][-3:]
    ['road_vz', 'omega', 'road_mu']
    """
    starts = {"r_z": _nominal_radius(tire), "v_x": speed, "omega": spin}
    starts |= {"R_11": 1.0, "R_22": 1.0, "R_33": 1.0, "road_nz": 1.0}
    moved = {"kappa", "alpha", "V", "phit", "distance", *(q.name for q in READ), *tire.symbolic_model.states}
    inputs = [input_variable(q, starts.get(q.name, 0.0)) for q in (*hub.CARRIER, *hub.ROAD, hub.SPIN)]
    if spins:
        inputs = [*inputs[:-1], replace(inputs[-1], causality="output"), *TORQUES]
    if tire.symbolic_model.motion.friction_scales:
        described = (hub.FRICTION.name, "input", hub.FRICTION.unit, hub.FRICTION.description)
        inputs.append(Variable(*described, start=1.0, lower=MIN_FRICTION, nominal=1.0, group="input"))
    return inputs + [
        input_variable(q, tire.nominal(q.name)) for q in tire.symbolic_model.inputs if q.name in read - moved
    ]


def hub_motion() -> list[Variable]:
    """Return the motion of the wheel at its contact point and its load, which are outputs."""
    return [_output(quantity, "motion") for quantity in READ]


def hub_outputs(spins: bool) -> list[Variable]:
    """Return the remaining results: radii, contact point, forces at the wheel centre."""
    shown = [(i, q) for i, q in enumerate(RESULTS) if q not in READ and (spins or q is not BRAKE)]
    return [_output(quantity, "extra", f"FIRST_HUB + {i}") for i, quantity in shown]


def hub_parameters(tire: Tire, spins: bool) -> list[Variable]:
    """Return the parameters of the vertical force that the tire's model does not have, and of the spin.

    `spins`: as for `hub_inputs`. Returns: values come from the entries of the tire's file, if it has them.

    >>> from tirefmu.tires import published
    >>> [variable.name for variable in hub_parameters(published("trento_hoosier"), False)]
    ['VERTICAL_STIFFNESS', 'VERTICAL_DAMPING', 'BOTTOM_STIFF', 'BOTTOM_RADIUS']
    """
    rim = known_value(tire, "RIM_RADIUS", 0.0)
    radius = (
        rim + known_value(tire, "BOTTOM_OFFST", 0.0) if rim > 0.0 else DEFAULT_BOTTOM * tire.values["UNLOADED_RADIUS"]
    )
    bottom = known_value(tire, "BOTTOM_RADIUS", radius)
    entries = [
        ("VERTICAL_STIFFNESS", "N/m", "vertical stiffness", _stiffness(tire)),
        ("VERTICAL_DAMPING", "N s/m", "vertical damping", known_value(tire, "VERTICAL_DAMPING", DEFAULT_DAMPING)),
        ("BOTTOM_STIFF", "N/m", "stiffness of the rim on the road", known_value(tire, "BOTTOM_STIFF", 0.0)),
        ("BOTTOM_RADIUS", "m", "loaded radius at which the rim touches the road", bottom),
    ]
    if tire.symbolic_model.quantity("loaded_radius"):
        del entries[0]
    parameters = [
        Variable(name, "parameter", unit, description, start, 0.0, inf)
        for name, unit, description, start in entries
        if name not in tire.symbolic_model.coefficients
    ]
    inertia = known_value(tire, WHEEL_INERTIA.name, 0.0) or WHEEL_INERTIA.start
    return [*parameters, replace(WHEEL_INERTIA, start=inertia)] if spins else parameters


def with_damping(tire: Tire) -> Tire:
    """Return a tire with the assumed vertical damping if its model has vertical damping and its file has no value."""
    if "VERTICAL_DAMPING" not in tire.defaulted:
        return tire
    given = {name: value for name, value in tire.values.items() if name not in tire.defaulted}
    return replace(tire, values={**given, "VERTICAL_DAMPING": DEFAULT_DAMPING})


def _stiffness(tire: Tire) -> float:
    """Return the vertical stiffness of a tire whose model has none, N/m; a file without a value may state 0."""
    default = tire.values["FNOMIN"] / (DEFAULT_DEFLECTION * tire.values["UNLOADED_RADIUS"])
    return known_value(tire, "VERTICAL_STIFFNESS", default) or default


def _nominal_radius(tire: Tire) -> float:
    """Return the loaded radius of the freely rolling wheel at its nominal load."""
    role = tire.symbolic_model.quantity("loaded_radius")
    if role:
        return float(quantities_of(tire.in_signs("iso"), {"kappa": 0.0})[role])
    return tire.values["UNLOADED_RADIUS"] - tire.nominal("Fz") / _stiffness(tire)


def known_value(tire: Tire, name: str, default: float) -> float:
    """Return a value of the tire, or of the entries of its file that the model does not use.

    `name`: a key of property files. `default`: if there is no number, or a negative one.

    >>> from tirefmu.tires import published
    >>> known_value(published("trento_hoosier"), "RIM_RADIUS", 0.2)
    0.2
    """
    if name in tire.values:
        return tire.values[name]
    for _, key, text in tire.other_entries:
        if key == name:
            value, _ = number_and_rest(text)
            return value if value >= 0.0 else default
    return default


def _output(quantity: Quantity, group: str, source: str = "") -> Variable:
    described = (quantity.name, "output", quantity.unit, quantity.description)
    return Variable(*described, nominal=quantity.typical, group=group, source=source)
