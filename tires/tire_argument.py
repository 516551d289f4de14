"""Tire arguments: a tire, the path of a .tir file, or the name of a published tire."""

from __future__ import annotations

import os
from pathlib import Path

from ..boundary.errors import TireError, UnknownName, WrongType
from .property_file.reading import read_tir
from .published_tires import PUBLISHED, published
from .tire import Tire

#: Types that the functions of the public interface accept as a tire.
TireLike = Tire | str | os.PathLike[str]


def tire_from(tire: TireLike, parameter: str = "tire", *, radius: float | None = None) -> Tire:
    """Return a tire given as such, as a .tir file, or by the name of a published one.

    Parameters
    ----------
    tire : Tire, str or path-like
        A str is a path if there is such a file, or if it has an extension and is not a published name.
    parameter : str
        Name of the caller's parameter, for the message.
    radius : float, optional
        Free radius, m, of a file without UNLOADED_RADIUS.

    Returns
    -------
    Tire
        Of a file: in ISO-W. Published: in the signs of its source.

    Raises
    ------
    UnknownName
        If there is neither a file nor a published tire of that name; the message offers the nearest.
    TirError
        If the file cannot be read.
    WrongType
        If it is anything else.

    Examples
    --------
    >>> tire_from("trento_hoosier").model
    'mf96'
    >>> tire_from("trento")
    Traceback (most recent call last):
    ...
    tirefmu.boundary.errors.UnknownName: unknown tire file or published tire 'trento': did you mean trento_hoosier? ...
    """
    if isinstance(tire, Tire):
        _refuse_radius(radius, tire.name or "the tire")
        return tire
    if not isinstance(tire, (str, os.PathLike)):
        raise WrongType(parameter, tire, "a Tire, the path of a .tir file or the name of a published tire")
    path, name = Path(tire), os.fspath(tire)
    if path.is_file() or (name not in PUBLISHED and (path.suffix or path.exists())):
        return read_tir(path, radius)
    if name not in PUBLISHED:
        raise UnknownName("tire file or published tire", name, PUBLISHED)
    _refuse_radius(radius, name)
    return published(name)


def tire_label(tire: TireLike) -> str:
    """Return a short name of a tire: of its file without the extension, its own, or that of its model.

    >>> tire_label("tires/front.tir"), tire_label(Tire("fiala", {"FNOMIN": 1.0, "UNLOADED_RADIUS": 0.3}))
    ('front', 'fiala')
    """
    return (tire.name or tire.model) if isinstance(tire, Tire) else Path(tire).stem


def tires_from(tire: TireLike, parameter: str = "tire") -> list[Tire]:
    """Return a tire as a list, or the tires of all .tir files in a folder.

    `tire`, str or path-like: as for `tire_from`, or a folder. `parameter`: name of the caller's parameter, for the
    message. Returns: in the order of the file names. Raises `TireError` if a folder has no .tir file. Raises
    `UnknownName, TirError, WrongType` as `tire_from`.

    >>> [tire.model for tire in tires_from("trento_hoosier")]
    ['mf96']
    """
    if isinstance(tire, (str, os.PathLike)) and Path(tire).is_dir():
        paths = sorted(path for path in Path(tire).iterdir() if path.suffix.lower() == ".tir")
        if not paths:
            raise TireError(f"{os.fspath(tire)}: no .tir file in this folder")
        return [read_tir(path) for path in paths]
    return [tire_from(tire, parameter)]


def _refuse_radius(radius: float | None, name: str) -> None:
    if radius is not None:
        raise TireError(f"{name} has a radius: R0 is for a .tir file without one")
