"""What can go wrong by misuse: one class per kind, each carrying the facts of its sentence."""

from __future__ import annotations

import difflib
import os
import reprlib
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from .escaping import excerpt

#: The longest sentence of an error, in characters.
LONGEST = 2000


class TirefmuError(Exception):
    r"""Any misuse that tirefmu reports: one clear line, exit status 2 on the command line.

    Parameters
    ----------
    sentence : str
        May quote a file: what is not printable becomes an escape sequence, and the middle of what is longer than
        `LONGEST` is omitted.

    Examples
    --------
    >>> print(TirefmuError("run\x1b[2J.csv: no rows"))
    run\x1b[2J.csv: no rows
    """

    def __init__(self, sentence: str) -> None:
        super().__init__(excerpt(sentence, LONGEST))


class UnknownName(TirefmuError):
    """An unknown name; the message has the nearest known one, and all of a few or how to list many.

    Parameters
    ----------
    kind : str
        What the name should have been: "model", "effect", "coefficient", ...
    name : str
        The name as it was given.
    known : iterable of str
        The names that exist.

    Examples
    --------
    >>> print(UnknownName("coefficient", "PDYI", ["PDY1", "PKX1"]))
    unknown coefficient 'PDYI': did you mean PDY1? Known are PDY1, PKX1
    """

    def __init__(self, kind: str, name: str, valid: Iterable[str]) -> None:
        self.kind, self.name, self.known = kind, name, tuple(valid)
        command = next((text for what, text in LISTED_BY.items() if kind.startswith(what)), "")
        super().__init__(f"unknown {kind} {name!r}{nearest(str(name), self.known, command)}")


class WrongType(TirefmuError, TypeError):
    """A value of a type that a parameter does not accept.

    `parameter`: name of the parameter. `value`: the value as it was given. `accepted`: what the parameter accepts, as
    the end of a sentence.

    >>> print(WrongType("table", None, "a path, a DataFrame or a Recording"))
    table is None: it has to be a path, a DataFrame or a Recording
    >>> print(WrongType("tire", [1, 2], "a Tire or a path"))
    tire is [1, 2] (list): it has to be a Tire or a path
    """

    def __init__(self, parameter: str, value: object, accepted: str) -> None:
        self.parameter, self.accepted = parameter, accepted
        shown = "None" if value is None else f"{reprlib.repr(value)} ({type(value).__name__})"
        super().__init__(f"{parameter} is {' '.join(shown.split())}: it has to be {accepted}")


def no_single_text(parameter: str, names: object) -> None:
    """Raise `WrongType` if a text is given where a collection of names is expected: its letters would be the names.

    >>> no_single_text("effects", ["plysteer"])
    >>> no_single_text("effects", "plysteer")
    Traceback (most recent call last):
    ...
    tirefmu.boundary.errors.WrongType: effects is 'plysteer' (str): it has to be a list of names, such as ['plysteer']
    """
    if isinstance(names, str):
        raise WrongType(parameter, names, f"a list of names, such as [{names[:40]!r}]")


class ModelError(TirefmuError):
    """A model that violates its declarations; the sentence names model and coefficient or quantity."""


class TireError(TirefmuError):
    """A tire whose coefficients cannot be evaluated."""


class EffectError(TirefmuError):
    """A file of an added effect that cannot be read, or one that does not fit a model."""


class TirError(TirefmuError):
    """A .tir file that cannot be read; the sentence names file, line and key."""


class DataError(TirefmuError):
    """A table or recording that cannot be used; the sentence names file, row and channel."""


class FitError(TirefmuError):
    """A fit that cannot be set up; one that does not converge is a result, not an error."""


class FmuError(TirefmuError):
    """An FMU that cannot be built or simulated; lists every problem found."""


class TirefmuWarning(UserWarning):
    r"""What the user has to know of a result, although nothing is wrong: "tirefmu: warning: ..." on the command line.

    Its text may quote a file, as that of `TirefmuError`.

    >>> print(TirefmuWarning("a\x1b[2J.tir: USE_MODE = 3"))
    a\x1b[2J.tir: USE_MODE = 3
    """

    def __init__(self, sentence: str) -> None:
        super().__init__(excerpt(sentence, LONGEST))


#: Largest number of known names that a message lists; of more it has the nearest ones.
FEW, NEAREST = 18, 4
#: What lists many names of a kind: the first one with which the kind begins.
LISTED_BY = {
    "effect": "tirefmu effects",
    "coefficient": "tirefmu info TIRE --all",
    "published tire": "tirefmu published",
    "unit": "docs/conventions.md",
}


def nearest(name: str, valid: Iterable[str], listed_by: str = "") -> str:
    """Return the end of a message on an unknown name: the nearest known one, and all of a few or how many there are.

    `listed_by`: command that lists all known names; a message needs it if there are many. Returns: the end of a
    sentence, beginning with a colon; empty when nothing is known.

    >>> nearest("gama", ["gamma", "alpha"])
    ': did you mean gamma? Known are gamma, alpha'
    >>> nearest("gama", ["gamma"]), nearest("X", ["gamma", "alpha"])
    (': did you mean gamma?', ': known are gamma, alpha')
    >>> nearest("PDYI", [f"PDY{i}" for i in range(20)], "tirefmu info")
    ': did you mean PDY9? Also near: PDY8, PDY7, PDY6; tirefmu info lists all 20'
    >>> nearest("lfz0", ["LFZ0", *"ABCDEFGHIJKLMNOPQR"], "tirefmu info")
    ': did you mean LFZ0? tirefmu info lists all 19'
    """
    names = list(dict.fromkeys(valid))
    folded = {candidate.casefold(): candidate for candidate in names}
    near = [folded[match] for match in difflib.get_close_matches(name.casefold(), folded, n=NEAREST, cutoff=0.5)]
    meant = [f"did you mean {near[0]}?"] if near else []
    if len(names) <= FEW:
        others = [f"known are {', '.join(names)}"] if len(names) > len(near[:1]) else []
    else:
        few = near[1:] or names[:FEW] * (not near and not listed_by)
        others = [f"{'also near' if near else 'known are'}: {', '.join(few)}".replace("are:", "are")] if few else []
        others += [f"{listed_by} lists all {len(names)}" if listed_by else f"{len(names)} are known"]
    if not meant:
        return f": {'; '.join(others)}" if others else ""
    end = "; ".join(others)
    first = end[:1] if listed_by and end.startswith(listed_by) else end[:1].upper()  # a command is written as it is
    return f": {meant[0]} {first}{end[1:]}".rstrip()


def path_from(value: Any, parameter: str = "path") -> Path:
    """Return a path given as str or path-like.

    `parameter`: name of the parameter, for the message. Raises `WrongType` if it is neither.

    >>> path_from("tires/front.tir").name
    'front.tir'
    >>> path_from(3)
    Traceback (most recent call last):
    ...
    tirefmu.boundary.errors.WrongType: path is 3 (int): it has to be a str or a Path
    """
    if not isinstance(value, (str, os.PathLike)):
        raise WrongType(parameter, value, "a str or a Path")
    return Path(value)


@contextmanager
def reading(path: Path | str, error: type[TirefmuError] = TirefmuError) -> Iterator[None]:
    """Raise an error of one line if the system refuses what is read inside.

    >>> with reading("none.tir"):
    ...     Path("none.tir").read_bytes()
    Traceback (most recent call last):
    ...
    tirefmu.boundary.errors.TirefmuError: none.tir: cannot be read (No such file or directory)
    """
    try:
        yield
    except OSError as reason:
        raise error(f"{path}: cannot be read ({reason.strerror or reason})") from reason


@contextmanager
def writing(path: Path | str, error: type[TirefmuError] = TirefmuError) -> Iterator[None]:
    """Raise an error of one line if the system refuses what is written inside."""
    try:
        yield
    except OSError as reason:
        raise error(f"{path}: cannot be written ({reason.strerror or reason})") from reason
