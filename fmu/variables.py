"""The variables of a tire's FMU: one list behind the XML, the C code and the documentation."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf

from tirefmu.symbolic.model import Model, reaching
from tirefmu.symbolic.notation import Coefficient, Option, Quantity
from tirefmu.symbolic.options import signs
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
        Of an output: the value references of the inputs that reach it without delay.
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
    silent = {name for effect, name in book.on_demand if effect not in tire.has}
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
        *(_parameter(card, values[name]) for name, card in book.coefficients.items()),
        *(_option(option, values[option.parameter]) for option in book.options),
        *(LAGGED if tire.lags else ()),
    )


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
    lines, inputs = book.lines(), {quantity.name for quantity in book.inputs}
    return {
        quantity.name: {
            symbol.name for line in reaching(lines, [quantity.name]) for symbol in line.expression.free_symbols
        }
        & inputs
        for quantity in book.outputs
    }


def _input(quantity: Quantity, tire: Tire) -> Variable:
    """Return an input, which starts at the tire's nominal value."""
    start = tire.nominal(quantity.name)
    return Variable(quantity.name, "input", quantity.unit, quantity.description, start=start, nominal=quantity.typical)


def _hidden(quantity: Quantity) -> Variable:
    """Return an input that this tire does not react to, at 0."""
    return Variable(quantity.name, "hidden", quantity.unit, quantity.description, start=0.0)


def _option(option: Option, value: float) -> Variable:
    """Return a convention as a tunable parameter; the one that says how the FMU is written is hidden."""
    first, second = option.values
    causality = "hidden" if option == signs else "parameter"
    return Variable(option.parameter, causality, "1", f"{option.description} (0 {first}, 1 {second})", value, 0.0, 1.0)


def _parameter(card: Coefficient, value: float) -> Variable:
    """Return a tunable coefficient, with its limits in ISO signs if the tire's own value keeps them."""
    # The book states bounds in adapted SAE.
    lower, upper = (-card.upper, -card.lower) if card.flips else (card.lower, card.upper)
    if not lower <= value <= upper:
        lower, upper = -inf, inf
    # + 0.0: a mirrored zero is an ordinary one.
    return Variable(card.name, "parameter", card.unit, card.description, value + 0.0, lower + 0.0, upper + 0.0)
