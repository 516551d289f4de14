"""The variables of a tire's FMU: one list behind the XML, the C code and the documentation."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from math import inf

from tirefmu.symbolic.model import Model, reaching
from tirefmu.symbolic.notation import Coefficient, Option, Quantity
from tirefmu.symbolic.options import signs
from tirefmu.symbolic.quantities import BEYOND
from tirefmu.tires import Tire


@dataclass(frozen=True)
class Variable:
    """A variable of the FMU; its value reference is its place in the list.

    Attributes
    ----------
    name : str
        As in the tables and in the .tir file.
    causality : str
        ``independent``, ``input``, ``output``, ``parameter`` or ``local``, as FMI calls them; ``hidden`` what
        the model's code reads and a host neither sees nor sets.
    unit, description : str
        SI unit, "1" where it has none.
    start : float or None
        None for what is computed.
    lower, upper : float
        Limits that the FMU holds; infinite where there are none.
    nominal : float
        The usual size; 0 where it is not known.
    depends : tuple of int
        Of an output or a derivative: the value references of the inputs and states that reach it without delay.
    group : str
        Of a native FMU: where the C code keeps it; see `tirefmu.fmu.description.interface`.
    reversed : bool
        Of a native FMU: host and formula write it with opposite signs.
    derivative_of : int or None
        Value reference of the state whose derivative it is.
    shows : str
        Of an extra output: how the C code finds it.
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
    group: str = ""
    reversed: bool = False
    derivative_of: int | None = None
    shows: str = ""


#: Roles of the quantities by which slips lag.
LENGTHS = ("relaxation_x", "relaxation_y")
TIME = Variable("time", "independent", "s", "simulation time")
#: What a tire with relaxation adds, named as in the result of `Tire.evaluate`.
LAGGED = (
    Variable("kappa_lagged", "local", "1", "longitudinal slip that acts, lagging behind kappa"),
    Variable("alpha_lagged", "local", "rad", "side slip angle that acts, its tangent lagging behind that of alpha"),
)


def variables(tire: Tire) -> tuple[Variable, ...]:
    """Return the variables of a tire's FMU in the order of their value references.

    Parameters
    ----------
    tire : Tire
        In ISO signs.

    Returns
    -------
    tuple of Variable
        ``time``, the inputs, the outputs, every coefficient and option as a parameter, and the lagged slips of
        a tire with relaxation. Inputs and parameters stand as in the arrays of the generated code: an input
        that the tire has no effect for is hidden at 0.

    Examples
    --------
    >>> from tirefmu.tires import published
    >>> [variable.name for variable in variables(published("trento_hoosier").in_signs("iso"))][:8]
    ['time', 'kappa', 'alpha', 'gamma', 'Fz', 'Fx', 'Fy', 'Mz']
    """
    book = tire.book
    values = dict(zip(book.parameters, tire.parameters().tolist(), strict=True))
    feedthrough = direct_feedthrough(book)
    silent = (set(tire.inputs) - read_inputs(tire)) | {"distance"}  # which the FMU finds itself
    return (
        TIME,
        *(_hidden(quantity) if quantity.name in silent else _input(quantity, tire) for quantity in book.inputs),
        *(
            Variable(
                quantity.name,
                "output",
                quantity.unit,
                quantity.description,
                nominal=quantity.typical,
                depends=tuple(
                    1 + i for i, known in enumerate(book.inputs) if known.name in feedthrough[quantity.name] - silent
                ),
            )
            for quantity in book.outputs
        ),
        *(parameter_variable(card, values[name], tire.signs) for name, card in book.coefficients.items()),
        *(option_variable(option, values[option.parameter]) for option in book.options),
        *(LAGGED if tire.lags else ()),
    )


def read_inputs(tire: Tire) -> set[str]:
    """Return the model's inputs that the FMU of a tire needs to know.

    Parameters
    ----------
    tire : Tire

    Returns
    -------
    set of str
        Inputs of effects on demand (phit) and beyond the book (T, distance) where the tire has an effect that
        reads them; all others for every tire of a model, so that one can take another's place.

    Examples
    --------
    >>> from tirefmu.tires import Tire
    >>> values = {"FNOMIN": 4000.0, "UNLOADED_RADIUS": 0.3}
    >>> sorted(read_inputs(Tire("mf61", values, effects=["turn_slip"])) - read_inputs(Tire("mf61", values, effects=[])))
    ['phit']
    """
    lines = reaching(tire.book.lines(tire.has), {*tire.outputs, *map(tire.book.quantity, LENGTHS)})
    reached = {symbol.name for line in lines for symbol in line.expression.free_symbols}
    idle = {name for name in BEYOND if name not in reached}
    return set(tire.inputs) - idle - {name for effect, name in tire.book.on_demand if effect not in tire.has}


def direct_feedthrough(book: Model) -> dict[str, set[str]]:
    """Return for every output of a model the inputs that stand in the lines which lead to it.

    Parameters
    ----------
    book : Model

    Returns
    -------
    dict of str to set of str

    Examples
    --------
    >>> from tirefmu.symbolic import model
    >>> sorted(direct_feedthrough(model("mf96"))["Fx"])
    ['Fz', 'alpha', 'gamma', 'kappa']
    """
    return feedthrough(book, [quantity.name for quantity in book.outputs])


def feedthrough(book: Model, names: Iterable[str]) -> dict[str, set[str]]:
    """Return for named quantities and outputs of a model the inputs that stand in the lines which lead to them.

    Parameters
    ----------
    book : Model
    names : iterable of str

    Returns
    -------
    dict of str to set of str
    """
    lines, inputs = book.lines(), {quantity.name for quantity in book.inputs}
    return {
        name: {symbol.name for line in reaching(lines, [name]) for symbol in line.expression.free_symbols} & inputs
        for name in names
    }


def _input(quantity: Quantity, tire: Tire) -> Variable:
    """Return an input, which starts at the tire's nominal value."""
    start = tire.nominal(quantity.name)
    return Variable(quantity.name, "input", quantity.unit, quantity.description, start=start, nominal=quantity.typical)


def _hidden(quantity: Quantity) -> Variable:
    """Return an input that this tire does not react to, at 0."""
    return Variable(quantity.name, "hidden", quantity.unit, quantity.description, start=0.0)


def option_variable(option: Option, value: float) -> Variable:
    """Return a convention as a tunable parameter; the one that says how the FMU is written is hidden."""
    first, second = option.values
    causality = "hidden" if option == signs else "parameter"
    return Variable(option.parameter, causality, "1", f"{option.description} (0 {first}, 1 {second})", value, 0.0, 1.0)


def parameter_variable(card: Coefficient, value: float, written: str) -> Variable:
    """Return a tunable coefficient, with its limits in the tire's signs if its own value keeps them."""
    # The book states bounds in adapted SAE.
    mirrored = card.flips and written == "iso"
    lower, upper = (-card.upper, -card.lower) if mirrored else (card.lower, card.upper)
    if not lower <= value <= upper:
        lower, upper = -inf, inf
    # + 0.0: a mirrored zero is an ordinary one.
    return Variable(card.name, "parameter", card.unit, card.description, value + 0.0, lower + 0.0, upper + 0.0)
