"""The variables of a tire's FMU: one list behind the XML, the C code and the documentation."""

from __future__ import annotations

from dataclasses import dataclass
from math import inf

from tirefmu.symbolic.model import Model, reaching
from tirefmu.symbolic.notation import Coefficient, Quantity
from tirefmu.tires import Tire


@dataclass(frozen=True)
class Variable:
    """A variable of the FMU; its value reference is its place in the list.

    Attributes
    ----------
    name : str
        As in the tables and in the .tir file.
    causality : str
        ``independent``, ``input``, ``output`` or ``parameter``, as FMI calls them.
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


def variables(tire: Tire) -> tuple[Variable, ...]:
    """Return the variables of a tire's FMU in the order of their value references.

    Parameters
    ----------
    tire : Tire
        In ISO signs.

    Returns
    -------
    tuple of Variable
        ``time``, then the inputs, the outputs, and every coefficient as a parameter.

    Examples
    --------
    >>> from tirefmu.tires import published
    >>> [variable.name for variable in variables(published("trento_hoosier").in_signs("iso"))][:8]
    ['time', 'kappa', 'alpha', 'gamma', 'Fz', 'Fx', 'Fy', 'Mz']
    """
    book = tire.book
    values = dict(zip((card.name for card in book.parameters), tire.parameters().tolist(), strict=True))
    feedthrough = direct_feedthrough(book)
    return (
        TIME,
        *(_input(quantity, tire) for quantity in book.inputs),
        *(
            Variable(
                quantity.name,
                "output",
                quantity.unit,
                quantity.description,
                nominal=quantity.typical,
                depends=tuple(1 + i for i, known in enumerate(book.inputs) if known.name in feedthrough[quantity.name]),
            )
            for quantity in book.outputs
        ),
        *(_parameter(card, values[card.name]) for card in book.parameters),
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


def _parameter(card: Coefficient, value: float) -> Variable:
    """Return a tunable coefficient, with its limits in ISO signs if the tire's own value keeps them."""
    # The book states bounds in adapted SAE.
    lower, upper = (-card.upper, -card.lower) if card.flips else (card.lower, card.upper)
    if not lower <= value <= upper:
        lower, upper = -inf, inf
    # + 0.0: a mirrored zero is an ordinary one.
    return Variable(card.name, "parameter", card.unit, card.description, value + 0.0, lower + 0.0, upper + 0.0)
