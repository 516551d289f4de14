"""The interface of a native FMU: its variables, in the order of the C code."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from ...boundary.errors import FmuError, UnknownName
from ...symbolic.added.state import State, rate_unit
from ...symbolic.declarations import Quantity
from ...symbolic.model import Model
from ...symbolic.model.extension import acting_name
from ...symbolic.quantities import ACTED_ON, KAPPA_LAGGED, TAN_ALPHA_LAGGED
from ...symbolic.wheel.quantities import SPIN
from ...tires import Tire
from ...tires.evaluation import quantities as quantities_of
from ...tires.property_file.names import not_given
from .hub_variables import BRAKE_EVENT, hub_inputs, hub_motion, hub_outputs, hub_parameters, with_damping
from .standstill import standstill_parameters, with_lengths
from .variables import (
    TIME,
    Variable,
    feedthrough,
    indicator,
    input_variable,
    is_indicator,
    option_variable,
    parameter_variable,
    read_inputs,
)

#: The kinds of inputs and the axes that an FMU can have.
INPUTS = ("slip", "wheel", "hub", "hub-torque")
#: Those with the motion of the wheel carrier.
HUB = ("hub", "hub-torque")
AXES = ("iso", "sae")
#: Axes of the FMU and the sign convention in which its tire is evaluated.
FORMULA = {"iso": "iso", "sae": "adapted-sae"}
#: Variables that SAE axes reverse in addition to the signs of the formula: z points down, y to the right.
REVERSED_IN_SAE = frozenset({"alpha", "Fz", "V_y", "psi_dot", "tan_alpha_lagged", "alpha_lagged", "twist"})

#: The motion of the wheel at its contact point, in the wheel's axes.
MOTION = (
    Quantity("V_x", "m/s", "velocity of the contact point along the wheel plane", typical=15.0),
    Quantity("V_y", "m/s", "velocity of the contact point across the wheel plane", typical=1.0),
    Quantity("omega", "rad/s", "angular speed of the wheel; positive when rolling forward", typical=50.0),
)
YAWING = Quantity("psi_dot", "rad/s", "yaw rate of the wheel", typical=1.0)
#: Default start value of the speed, m/s.
SPEED = 15.0
TWIST = Quantity("twist", "rad", "twist of the contact patch, by turning on the spot", typical=0.1)
DISTANCE = Quantity("distance", "m", "distance rolled", typical=1000.0)

LAGGED_SLIPS = frozenset({KAPPA_LAGGED.name, TAN_ALPHA_LAGGED.name})


@dataclass(frozen=True)
class Interface:
    """The interface of a native FMU of a tire.

    - `tire`: in the signs in which the FMU evaluates it.
    - `inputs`: one of `INPUTS`.
    - `axes`: one of `AXES`.
    - `variables`: in the order of their value references: ``time``, inputs, the motion of the wheel that hub inputs
      determine, forces, parameters, states, their derivatives, extra outputs.
    - `relaxation_note`: the relaxation lengths assumed for a tire that has none; empty if none are assumed.
    """

    tire: Tire
    inputs: str
    axes: str
    variables: tuple[Variable, ...]
    relaxation_note: str = ""

    def group(self, name: str) -> list[Variable]:
        """Return the variables of a group: input, motion, force, parameter, state, derivative or extra."""
        return [variable for variable in self.variables if variable.group == name]

    @property
    def wheel(self) -> bool:
        """True if the FMU computes slips from velocities."""
        return self.inputs != "slip"

    @property
    def hub(self) -> bool:
        """True if the inputs are the motion of the wheel carrier."""
        return self.inputs in HUB

    @property
    def spins(self) -> bool:
        """True if the spin of the wheel is a state."""
        return self.inputs == "hub-torque"

    @property
    def state_nominals(self) -> list[float]:
        """Typical sizes of the continuous states of Model Exchange, in the order of their derivatives."""
        return [self.variables[v.derivative_of].nominal for v in self.variables if v.derivative_of is not None]

    @property
    def contact_inputs(self) -> list[Variable]:
        """The variables that the contact kinematics reads: inputs, and the motion computed from those of a hub."""
        return [*self.group("input"), *self.group("motion")]

    @property
    def lags(self) -> bool:
        """True if kappa and tan(alpha) are states: the tire has relaxation, or its inputs are velocities."""
        return self.tire.lags or self.wheel

    @property
    def twists(self) -> bool:
        """True if the twist of the contact patch is a state."""
        return any(variable.name == TWIST.name for variable in self.group("state"))

    @property
    def memory(self) -> tuple[State, ...]:
        """The states of the tire's effects, in the order of their variables."""
        return tuple(self.tire.symbolic_model.states[name] for name in self.tire.states)

    @property
    def has_distance(self) -> bool:
        """True if the distance rolled is a state."""
        return any(variable.name == DISTANCE.name for variable in self.group("state"))


def interface(tire: Tire, *, inputs: str = "slip", axes: str = "iso", quantities: bool = False) -> Interface:
    """Return the interface of a native FMU of a tire.

    - `tire`: in any signs.
    - `inputs`, one of "slip", "wheel", "hub", "hub-torque": slips, the velocities from which the FMU computes them, or
      the motion of the wheel carrier and the road, with the spin of the wheel or with the torques that it follows from.
    - `axes`, one of "iso", "sae": TYDEX W (z up), or SAE (z down, y to the right).
    - `quantities`: whether every named quantity of the model is an output.

    Returns: the input of an on-demand or added effect is present if the tire has an effect that reads it. With wheel
    inputs a tire without relaxation has the lengths of `with_lengths`: at standstill slip is 0/0, and a lagged slip is
    a deflection. Raises `UnknownName` if inputs or axes do not exist. Raises `FmuError` if hub inputs have other axes
    than ISO, or the radius of a wheel or the nominal load at a hub is not positive.

    >>> from tirefmu.tires import published
    >>> [variable.name for variable in interface(published("trento_hoosier"), inputs="wheel").group("input")]
    ['V_x', 'V_y', 'omega', 'psi_dot', 'gamma', 'Fz']
    """
    for what, given, allowed in (("kind of inputs", inputs, INPUTS), ("kind of axes", axes, AXES)):
        if given not in allowed:
            raise UnknownName(what, given, allowed)
    hub, spins = inputs in HUB, inputs == "hub-torque"
    if hub and axes != "iso":
        raise FmuError("hub inputs have ISO axes only")
    tire = tire.in_signs(FORMULA[axes])
    model, wheel = tire.symbolic_model, inputs != "slip"
    if wheel and "UNLOADED_RADIUS" in not_given(tire):
        raise FmuError(
            f"{inputs} inputs need the radius of the wheel, which the fit of this tire did not know "
            f"({tire.values['UNLOADED_RADIUS']:g} m is assumed): fit it with --size 205/55R16 or --nominal R0=0.31"
        )
    tire, note = with_lengths(tire) if wheel else (tire, "")
    tire = with_damping(tire) if hub else tire
    read = read_inputs(tire)
    twists = wheel and ("phit" in read or bool(model.quantity("trail")))
    states = [
        *(_state(slip) for slip in ((KAPPA_LAGGED, TAN_ALPHA_LAGGED) if tire.lags or wheel else ())),
        *((_state(TWIST),) if twists else ()),
        *(_memory_state(tire, name) for name in tire.states),
        *((_state(DISTANCE),) if "distance" in read else ()),
    ]
    if hub:
        hosts = [*hub_inputs(tire, read, *free_rolling(tire), spins=spins), *hub_motion()]
    else:
        hosts = _wheel_inputs(tire, read, twists) if wheel else _slip_inputs(tire, read, bool(states))
    values = dict(zip(model.parameters, tire.parameters().tolist(), strict=True))
    extras = _extras(tire, inputs, quantities)
    parameters = [
        *(parameter_variable(declared, values[name], tire.signs) for name, declared in model.coefficients.items()),
        *(option_variable(option, values[option.parameter]) for option in model.options),
        *(standstill_parameters(tire) if wheel else ()),
        *(hub_parameters(tire, spins) if hub else ()),
    ]
    plain = (
        TIME,
        *hosts,
        *(Variable(q.name, "output", q.unit, q.description, nominal=q.typical, group="force") for q in model.outputs),
        *(replace(parameter, group="parameter") for parameter in parameters),
        *states,
        *(_derivative(state) for state in states),
        *((_derivative(next(v for v in hosts if v.name == SPIN.name)),) if spins else ()),
        *extras,
    )
    reverse = REVERSED_IN_SAE if axes == "sae" else frozenset()
    turned = tuple(
        replace(v, reversed=True, start=None if v.start is None else -v.start) if _stem(v.name) in reverse else v
        for v in plain
    )
    return Interface(tire, inputs, axes, _with_structure(turned, tire, inputs), note)


def _memory_state(tire: Tire, name: str) -> Variable:
    """Return the state of an effect: in equilibrium at the start, or at a value that the host can set.

    A temperature is an output.
    """
    state = tire.symbolic_model.states[name]
    start = None
    if state.has_start_value or not state.settles:
        start = float(quantities_of(tire, {})[f"{name}_start"])
    what = state.description or f"state {name}"
    causality, typical = ("output", 300.0) if state.is_temperature else ("local", 1.0)
    return Variable(name, causality, state.unit, what, start=start, nominal=typical, group="state")


def _slip_inputs(tire: Tire, read: set[str], rolls: bool) -> list[Variable]:
    """Return the model's inputs, and the speed if only a state needs it."""
    computed = {"distance", *tire.symbolic_model.states}
    shown = [input_variable(q, tire.nominal(q.name)) for q in tire.symbolic_model.inputs if q.name in read - computed]
    if rolls and "V" not in tire.inputs:
        shown.append(input_variable(Quantity("V", "m/s", "forward speed of the contact point", typical=SPEED), 0.0))
    return shown


def _wheel_inputs(tire: Tire, read: set[str], twists: bool) -> list[Variable]:
    """Return the wheel's motion, free rolling at the start, and the remaining inputs of the model."""
    speed, spin = free_rolling(tire)
    starts = {"V_x": speed, "V_y": 0.0, "omega": spin}
    moved = {"kappa", "alpha", "V", "phit", "distance", *tire.symbolic_model.states}
    return [
        *(input_variable(quantity, starts[quantity.name]) for quantity in MOTION),
        *((input_variable(YAWING, 0.0),) if twists else ()),
        *(input_variable(q, tire.nominal(q.name)) for q in tire.symbolic_model.inputs if q.name in read - moved),
    ]


def free_rolling(tire: Tire) -> tuple[float, float]:
    """Return speed, m/s, and spin, rad/s, of the freely rolling wheel at the nominal operating condition."""
    nominal = quantities_of(tire.in_signs("iso"), {"kappa": 0.0})
    speed = tire.nominal("V") if "V" in tire.inputs else SPEED
    return speed, speed / float(
        nominal.get(tire.symbolic_model.quantity("rolling_radius"), tire.values["UNLOADED_RADIUS"])
    )


def _state(state: Quantity) -> Variable:
    """Return a state: slips start in steady state, the distance at a value that the host can set."""
    start = 0.0 if state is DISTANCE else None
    return Variable(
        state.name, "local", state.unit, state.description, start=start, nominal=state.typical, group="state"
    )


def _derivative(state: Variable) -> Variable:
    unit = rate_unit(state.unit)
    return Variable(f"der({state.name})", "local", unit, f"rate of {state.name}", group="derivative")


def _stem(name: str) -> str:
    """Return the state's name of a derivative, or the name itself."""
    return name.removeprefix("der(").removesuffix(")")


def _extras(tire: Tire, inputs: str, quantities: bool) -> list[Variable]:
    """Return the outputs in addition to the forces; `source` is their source in the C code."""
    model, wheel = tire.symbolic_model, inputs != "slip"
    named = model.structure.quantities
    at_hub = hub_outputs(inputs == "hub-torque") if inputs in HUB else []
    taken = {*model.parameters, *(q.name for q in (*model.inputs, *model.outputs, *(MOTION if wheel else ()), *at_hub))}
    # Radii and inputs as they act are first: without the other quantities, variables have the same value references.
    radii = [name for name in map(model.quantity, ("rolling_radius", "loaded_radius")) if name]
    effects = [effect for effect in model.added if effect.name in tire.has]
    first = [*radii, *(acting_name(name) for effect in effects for name in effect.acts_on if name in ACTED_ON)]
    chosen = dict.fromkeys([*first, *named] if quantities else first)
    extras = [Variable("friction_use", "output", "1", "force as a share of the friction ellipse",
                      nominal=1.0, group="extra", source="FRICTION_USE")]  # fmt: skip
    if wheel:
        extras += [
            Variable("kappa", "output", "1", "longitudinal slip from the wheel's motion", nominal=0.1, group="extra",
                     source="KAPPA_GIVEN"),
            Variable("alpha", "output", "rad", "side slip angle from the wheel's motion", nominal=0.1, group="extra",
                     source="ALPHA_GIVEN"),
        ]  # fmt: skip
    extras += at_hub
    if tire.lags or wheel:
        extras.append(Variable("alpha_lagged", "local", "rad", "side slip angle from its lagged tangent",
                              group="extra", source="ALPHA_LAGGED"))  # fmt: skip
    extras += [
        indicator(model.states[name], i) for i, name in enumerate(tire.states) if model.states[name].follows_a_path
    ]
    if inputs == "hub-torque":
        extras.append(BRAKE_EVENT)
    return extras + [
        Variable(name, "output", *named[name], group="extra", source=f"FIRST_QUANTITY + {name}")
        for name in chosen
        if name not in taken
    ]


def _with_structure(variables: tuple[Variable, ...], tire: Tire, kind: str) -> tuple[Variable, ...]:
    """Return the variables with the dependencies of computed ones, and the state of each derivative.

    `kind`: of the inputs, one of `INPUTS`.
    """
    model = tire.symbolic_model
    references = {variable.name: reference for reference, variable in enumerate(variables)}
    inputs = {variable.name for variable in variables if variable.causality == "input"}
    spin = {SPIN.name} if kind == "hub-torque" else set()
    states = spin | {variable.name for variable in variables if variable.group == "state"}

    def causes(variable: Variable) -> set[str]:
        if variable.group == "state":
            return {variable.name}
        if variable.name in spin:
            return spin
        if kind in HUB or is_indicator(variable):  # at a hub the load depends on the slips, and all else on the load
            return inputs | states
        if variable.group == "derivative":
            return _causes_of_rate(_stem(variable.name), model, inputs, states)
        read = _model_inputs_of(variable.name, model)
        acting = {state for state in states if _acts(state, variable.name, read, model)}
        return acting | (inputs if kind == "wheel" else inputs & read)

    def initial_causes(variable: Variable) -> tuple[int, ...] | None:
        if kind != "slip" or tire.states:
            return None
        if variable.group == "state":
            return (references["kappa" if variable.name == KAPPA_LAGGED.name else "alpha"],)
        if variable.group == "derivative":  # slips start in steady state
            return (references["V"],) if _stem(variable.name) == DISTANCE.name else ()
        reached = model.reached(_quantities_behind(variable.name, model), tire.has)
        return tuple(r for name, r in references.items() if name in reached and variables[r].causality != "hidden")

    computed = [
        variable
        for variable in variables
        if variable.group in ("motion", "force", "extra", "derivative")
        or (variable.group == "input" and variable.causality == "output")
        or variable.group == "state"
    ]
    with_causes = {
        variable.name: replace(
            variable,
            depends=tuple(sorted(references[name] for name in causes(variable))),
            initially=initial_causes(variable),
            derivative_of=references[_stem(variable.name)] if variable.group == "derivative" else None,
        )
        for variable in computed
    }
    return tuple(with_causes.get(variable.name, variable) for variable in variables)


def _causes_of_rate(state: str, model: Model, inputs: set[str], states: set[str]) -> set[str]:
    """Return the inputs and states that the rate of a state depends on, for slip and wheel inputs."""
    if state in model.states:
        return inputs | states
    speed = inputs & {"V", "V_x"}
    if state == DISTANCE.name:
        return speed
    return {*speed, YAWING.name, state} if state == TWIST.name else {*inputs, state}


def _model_inputs_of(name: str, model: Model) -> set[str]:
    """Return the inputs of the model that an output depends on; the slips if the model does not compute it."""
    if name not in model.structure.quantities and name not in {q.name for q in model.outputs} | {"friction_use"}:
        return {"kappa", "alpha"}
    return set().union(*feedthrough(model, _quantities_behind(name, model)).values())


def _quantities_behind(name: str, model: Model) -> list[str]:
    """Return the outputs and quantities of the model from which an output follows."""
    if name == "friction_use":
        return ["Fx", "Fy", model.quantity("friction_x"), model.quantity("friction_y")]
    return [name]


def _acts(state: str, output: str, read: set[str], model: Model) -> bool:
    """Return whether an output that reads some inputs of the model depends on a state."""
    if state in LAGGED_SLIPS:
        return bool(read & {"kappa", "alpha"})
    if state == TWIST.name:
        return output == "Mz"
    return state in read if state == DISTANCE.name else state in model.states


def host_input_indices(shown: Interface) -> list[int]:
    """Return for every input of the model the index of the variable with its value; -1 if there is none."""
    indices: Mapping[str, int] = {variable.name: i for i, variable in enumerate(shown.contact_inputs)}
    computed = {"omega"} if shown.wheel else set()
    return [indices[name] if name in indices.keys() - computed else -1 for name in shown.tire.inputs]
