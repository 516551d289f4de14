"""Tires that were published with their parameters, ready to load."""

from __future__ import annotations

from importlib.resources import as_file, files
from typing import overload

from ...boundary.errors import UnknownName
from ..property_file.reading import read_tir
from ..tire import Tire

#: The published tires and the signs of their source.
PUBLISHED = {"trento_hoosier": "adapted-sae", "unicamp_small_tire": "adapted-sae"}


@overload
def published() -> tuple[str, ...]: ...


@overload
def published(name: str) -> Tire: ...


def published(name: str | None = None) -> Tire | tuple[str, ...]:
    """Return a published tire in the signs of its source, or the names of all if none is given.

    Parameters
    ----------
    name : str, optional
        ``trento_hoosier``: Hoosier 6.0/18.0-10 LCO, MF96, University of Trento, Dynamics of Vehicles, team 6.
        ``unicamp_small_tire``: 4PR Imsa, 152.4 x 50.8 mm, MF6.1, University of Campinas. Its ``about`` states what
        was printed, and what had to be inferred, replaced and omitted.

    Returns
    -------
    Tire, or tuple of str
        Without a name, the names of all published tires.

    Raises
    ------
    UnknownName
        If there is no such tire.

    Examples
    --------
    >>> published()
    ('trento_hoosier', 'unicamp_small_tire')
    >>> tire = published("trento_hoosier")
    >>> tire.signs, tire.values["PDY1"]
    ('adapted-sae', 2.7167406877414653)
    """
    if name is None:
        return tuple(PUBLISHED)
    if name not in tuple(PUBLISHED):
        raise UnknownName("published tire", name, PUBLISHED)
    with as_file(files(__package__) / f"{name}.tir") as path:
        return read_tir(path).in_signs(PUBLISHED[name])
