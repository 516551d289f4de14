"""The variables of a tire's FMU: one list from which the XML, the C code and the documentation are generated."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from functools import lru_cache
from math import inf, isfinite

from ...symbolic.added.state import State
from ...symbolic.declarations import Coefficient, Option, Quantity
from ...symbolic.model import Model
from ...symbolic.models import model_named
from ...symbolic.options import signs
from ...tires import Tire
from ...tires.property_file.names import unmeasured_coefficients, unmeasured_outputs


@dataclass(frozen=True)
class Variable:
    """A variable of the FMU; its value reference is its index in the list.

    - `name`: as in the tables and in the .tir file.
    - `causality`: ``independent``, ``input``, ``output``, ``parameter`` or ``local``, as in FMI; ``hidden`` for a value
      that the model reads but that is not visible to the host.
    - `unit`, `description`: SI unit; "1" for a dimensionless variable.
    - `start`: none for a computed variable.
    - `lower`, `upper`: limits that the FMU enforces; infinite without limits.
    - `nominal`: typical magnitude; 0 if unknown.
    - `depends`: of an output or a derivative: the value references of the inputs and states that it depends on
      directly.
    - `initially`: of a computed variable: the value references of what it depends on during initialization: inputs,
      parameters, and states with a start value; None for all of them.
    - `group`: of a native FMU: its group in the C code; see `tirefmu.fmu.description.interface`.
    - `reversed`: of a native FMU: host and formula use opposite signs.
    - `derivative_of`: value reference of the state whose derivative it is.
    - `source`: of an extra output: its source in the C code.
    """

    name: str
    causality: str
    unit: str
    description: str
    start: float | None = None
    lower: float = -inf
    upper: float = inf
    nominal: float = 0.0
    depends: tuple[int, ...] = ()
    initially: tuple[int, ...] | None = None
    group: str = ""
    reversed: bool = False
    derivative_of: int | None = None
    source: str = ""


#: Roles of the relaxation lengths.
LENGTHS = ("relaxation_x", "relaxation_y")
TIME = Variable("time", "independent", "s", "simulation time")
#: Additional variables of a tire with relaxation, named as in the result of `Tire.evaluate`.
LAGGED = (
    Variable("kappa_lagged", "local", "1", "lagged longitudinal slip"),
    Variable("alpha_lagged", "local", "rad", "side slip angle from its lagged tangent"),
)


def variables(tire: Tire) -> tuple[Variable, ...]:
    """Return the variables of a tire's FMU in the order of their value references.

    `tire`: in ISO signs. Returns: ``time``, the inputs, the outputs, every coefficient and option as a parameter, and
    the lagged slips of a tire with relaxation. Inputs and parameters are in the order of the generated code's arrays.
    An input that no effect of the tire reads is hidden and 0.

    >>> from tirefmu.tires import published
    >>> [variable.name for variable in variables(published("trento_hoosier").in_signs("iso"))][:8]
    ['time', 'kappa', 'alpha', 'gamma', 'Fz', 'Fx', 'Fy', 'Mz']
    """
    model = tire.symbolic_model
    values = dict(zip(model.parameters, tire.parameters().tolist(), strict=True))
    feedthrough = direct_feedthrough(model)
    silent = (set(tire.inputs) - read_inputs(tire)) | {"distance"}  # the FMU computes the distance
    return (
        TIME,
        *(_hidden(quantity) if quantity.name in silent else _input(quantity, tire) for quantity in model.inputs),
        *(
            Variable(
                quantity.name,
                "output",
                quantity.unit,
                quantity.description,
                nominal=quantity.typical,
                depends=tuple(
                    1 + i for i, given in enumerate(model.inputs) if given.name in feedthrough[quantity.name] - silent
                ),
            )
            for quantity in model.outputs
        ),
        *(parameter_variable(declared, values[name], tire.signs) for name, declared in model.coefficients.items()),
        *(option_variable(option, values[option.parameter]) for option in model.options),
        *(LAGGED if tire.lags else ()),
    )


def with_remarks(listed: Iterable[Variable], tire: Tire) -> tuple[Variable, ...]:
    """Return variables with what is to be known of this tire: valid ranges of inputs, what its data did not determine.

    The range is not declared as minimum and maximum: a host could refuse values that the FMU accepts with a warning.

    `tire`: in the signs of the FMU's formula.

    >>> from tirefmu.tires import published
    >>> tire = published("trento_hoosier")
    >>> with_remarks([Variable("Fz", "input", "N", "vertical load")], tire)[0].description
    'vertical load; valid from 120 to 1220 N'
    """
    outputs, coefficients = unmeasured_outputs(tire), unmeasured_coefficients(tire)

    def shown(variable: Variable) -> Variable:
        if variable.causality == "output" and variable.name in outputs:
            return replace(variable, description=f"{variable.description}; not measured: computed with start values")
        if variable.causality == "parameter" and variable.name in coefficients:
            return replace(variable, description=f"{variable.description}; not measured: start value")
        low, high = tire.ranges.get(variable.name, (-inf, inf))
        if variable.causality != "input" or not (isfinite(low) and isfinite(high)):
            return variable
        if variable.reversed:
            low, high = 0.0 - high, 0.0 - low
        unit = "" if variable.unit == "1" else f" {variable.unit}"
        return replace(variable, description=f"{variable.description}; valid from {low:g} to {high:g}{unit}")

    return tuple(map(shown, listed))


def read_inputs(tire: Tire) -> set[str]:
    """Return the model inputs that the FMU of a tire needs.

    Returns: inputs of on-demand effects (phit) and added inputs (T, distance) only if the tire has an effect that reads
    them; all others for every tire of a model, so that FMUs of the same model are interchangeable.

    >>> from tirefmu.tires import Tire
    >>> values = {"FNOMIN": 4000.0, "UNLOADED_RADIUS": 0.3}
    >>> sorted(read_inputs(Tire("mf61", values, effects=["turn_slip"])) - read_inputs(Tire("mf61", values, effects=[])))
    ['phit']
    """
    reached = tire.symbolic_model.reached({*tire.outputs, *map(tire.symbolic_model.quantity, LENGTHS)}, tire.has)
    declared = {quantity.name for quantity in model_named(tire.model).inputs}
    unread = {name for effect, name in tire.symbolic_model.on_demand if effect not in tire.has}
    return {name for name in tire.inputs if name in declared | reached} - unread


def direct_feedthrough(model: Model) -> dict[str, set[str]]:
    """Return for every output of a model the inputs that it depends on.

    >>> from tirefmu.symbolic.models import model_named
    >>> sorted(direct_feedthrough(model_named("mf96"))["Fx"])
    ['Fz', 'alpha', 'gamma', 'kappa']
    """
    return feedthrough(model, [quantity.name for quantity in model.outputs])


def feedthrough(model: Model, names: Iterable[str]) -> dict[str, set[str]]:
    """Return for named quantities and outputs of a model the inputs that they depend on."""
    inputs = {quantity.name for quantity in model.inputs}
    return {name: inputs & _reached(model, name) for name in names}


@lru_cache(maxsize=1024)
def _reached(model: Model, name: str) -> frozenset[str]:
    return frozenset(model.reached([name]))


def indicator(state: State, index: int) -> Variable:
    """Return the event indicator of a state along a path: its sign changes where the derivative jumps."""
    ending, unit, what = "velocity", "1/s", f"velocity of {state.name} along its path, with an event at 0"
    if state.kind == "play":
        ending, unit, what = "event", "1", f"margin of {state.name} in its direction, -1 at its limit, event at 0"
    name = f"{state.name}_{ending}"
    return Variable(name, "local", unit, what, nominal=1.0, group="extra", source=f"FIRST_PATH + {index}")


def is_indicator(variable: Variable) -> bool:
    """Return whether a variable is an event indicator: of a state along a path, or of a brake."""
    return variable.source.startswith("FIRST_PATH") or variable.source == "BRAKE_EVENT"


def _input(quantity: Quantity, tire: Tire) -> Variable:
    """Return an input whose start value is the tire's nominal value."""
    start = tire.nominal(quantity.name)
    return Variable(quantity.name, "input", quantity.unit, quantity.description, start=start, nominal=quantity.typical)


def input_variable(quantity: Quantity, start: float) -> Variable:
    """Return an input of a native FMU."""
    described = (quantity.name, "input", quantity.unit, quantity.description)
    return Variable(*described, start=start, nominal=quantity.typical, group="input")


def _hidden(quantity: Quantity) -> Variable:
    """Return a hidden input that this tire does not read, with the value 0."""
    return Variable(quantity.name, "hidden", quantity.unit, quantity.description, start=0.0)


def option_variable(option: Option, value: float) -> Variable:
    """Return an option as a tunable parameter; the sign convention of the FMU is hidden."""
    first, second = option.values
    causality = "hidden" if option == signs else "parameter"
    return Variable(option.parameter, causality, "1", f"{option.description} (0 {first}, 1 {second})", value, 0.0, 1.0)


def declared_limits(declaration: Coefficient, written: str) -> tuple[float, float]:
    """Return the limits of a coefficient in the signs of a tire; declarations have them in adapted SAE."""
    if declaration.flips and written == "iso":
        return -declaration.upper, -declaration.lower
    return declaration.lower, declaration.upper


def parameter_variable(declaration: Coefficient, value: float, written: str) -> Variable:
    """Return a tunable coefficient; its limits, in the tire's signs, apply only if its own value satisfies them."""
    lower, upper = declared_limits(declaration, written)
    if not lower <= value <= upper:
        lower, upper = -inf, inf
    # + 0.0: no negative zero.
    return Variable(
        declaration.name,
        "parameter",
        declaration.unit,
        declaration.description,
        value + 0.0,
        lower + 0.0,
        upper + 0.0,
    )
