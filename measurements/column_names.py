"""Names of columns that resemble a channel: which channel a name probably means, and errors for such names.

A column under a wrong name would silently be ignored, and the nominal value would replace the input.
"""

from __future__ import annotations

import re
import shlex
from collections.abc import Collection, Iterable, Mapping

from ..boundary.errors import DataError
from ..symbolic.channels import CHANNELS, INPUTS, channel
from .terms import without_qualifiers, words_of
from .units import quantity_of

#: Words in the name of a column that do not change its meaning.
_QUALIFIERS = frozenset(
    ("raw", "filtered", "filt", "measured", "meas", "mean", "avg", "average", "corrected", "corr", "signal", "channel")
)
#: Characters. A shorter name is not compared for typing errors with a channel, or with another name of one.
SHORTEST_CHANNEL, SHORTEST_ALIAS = 4, 6
#: Characters. A longer name is not repeated in a message.
LONGEST_NAME = 60

# Bench names are case-sensitive: "ET" is the time, "Et" the curvature factor of the trail.
_BENCH_NAMES = {alias: declared.name for declared in CHANNELS.values() for alias in declared.bench_names}
#: Names in lower case without separators.
_ALIASES = {
    "".join(re.findall("[a-z0-9]+", alias.casefold())): declared.name
    for declared in CHANNELS.values()
    for alias in (declared.name, *declared.aliases)
}
#: Names of several words: a column contains one of them only if it is meant.
_PHRASES = {
    "".join(alias.split("_")): declared.name
    for declared in CHANNELS.values()
    for alias in declared.aliases
    if "_" in alias
}
_SUFFIXED = re.compile(r"(?P<name>[\w ]+)[ _]?[ _(](?P<unit>[^()\[\]_ ]+)\)?")
#: The wheel at the end of a name: "Alpha_L1", "slip_angle_fl", "SlipAngleFL".
_WHEEL = re.compile(r"(?:[ _.](?:[fr][lr]|[lr][fr12])|(?-i:(?<=[a-z])(?:[FR][LR]|[LR][FR12])))$", re.IGNORECASE)
_BRACKETED = re.compile(r"(?P<name>[^\[(]+)[\[(]")


def intended_channel(column: str) -> str | None:
    """Return the channel that the name of a column probably means, or None.

    Recognized are names in another case or with other separators, bench names, aliases, names with a unit, a wheel
    ("FL", "L1") or a qualifier ("raw", "filtered"), names in the languages of `TERMS`, names that contain an alias of
    several words, and single typing errors. Named quantities of a tire (``alpha_y``) are not channels.

    >>> [intended_channel(name) for name in ("Alpha", "SA", "gama", "alpha_deg", "SlipAngle", "TirePressure_kPa")]
    ['alpha', 'alpha', 'gamma', 'alpha', 'alpha', 'p']
    >>> intended_channel("alpha_y") is None
    True
    """
    column = "".join(character for character in column if character.isprintable()).strip()
    if column in _BENCH_NAMES:
        return _BENCH_NAMES[column]
    if suffixed := unit_in_name(column):
        return suffixed[0]
    bracketed = _BRACKETED.match(column)
    name = _WHEEL.sub("", (bracketed["name"] if bracketed else column).strip())
    words = [word for word in words_of(name) if word not in _QUALIFIERS]
    written = "".join(words)
    if written in _ALIASES:
        return _ALIASES[written]
    if (meant := _ALIASES.get("".join(words[:-1]))) and quantity_of(words[-1]) == CHANNELS[meant].quantity:
        return meant
    contained = next((meant for phrase, meant in _PHRASES.items() if phrase in written), None)
    if contained is not None:
        return contained
    return _misspelled(name.strip().casefold(), written)


def names_a_wheel(column: str) -> bool:
    """Return whether the name of a column ends in a wheel of a car.

    >>> [names_a_wheel(name) for name in ("Fy_L1", "SlipAngleFL [deg]", "Fy", "half")]
    [True, True, False, False]
    """
    return bool(_WHEEL.search(re.split(r"[\[(]", column)[0].strip()))


def unit_in_name(column: str) -> tuple[str, str] | None:
    """Return channel and unit of a name like ``alpha_deg`` or ``p (kPa)``, or None.

    A wheel and words of a sensor or a filter may be behind them, a wheel also behind the channel.

    >>> unit_in_name("p_kPa"), unit_in_name("Fz_FL_kN_raw"), unit_in_name("kappa_in")
    (('p', 'kPa'), ('Fz', 'kN'), None)
    """
    match = _SUFFIXED.fullmatch(_WHEEL.sub("", without_qualifiers(column.strip())))
    if match is None:
        return None
    written = _WHEEL.sub("", match["name"])
    name = written if written in CHANNELS else _BENCH_NAMES.get(written) or _ALIASES.get("".join(words_of(written)))
    # The unit has to match the quantity: "kappa_in" is an input, not a slip in inches.
    return (name, match["unit"]) if name is not None and quantity_of(match["unit"]) == CHANNELS[name].quantity else None


def check_names(names: Iterable[str], source: str, required: Collection[str] = INPUTS) -> None:
    """Refuse a column whose name resembles a channel that the table lacks.

    `required`: the channels that the caller reads. Outputs are required where data are compared with a tire
    (`Recording.measured`). A table to evaluate may have columns such as FX as a reference. Raises `DataError` with the
    column, the name or the header that was probably meant, and the option that reads all such columns.
    """
    given = list(names)
    meant = {name: intended_channel(name) for name in given if name not in CHANNELS}
    missing = {name: channel for name, channel in meant.items() if channel is not None and channel not in given}
    name = next((name for name, channel in missing.items() if channel in required), None)
    if name is not None:
        hint = f"did you mean {_suggestion(name, missing[name])}? "
        option = _option({channel: name for name, channel in reversed(missing.items())})
        hint += f"All such columns: {option}" if option else f"Channels are {', '.join(CHANNELS)}"
        raise DataError(f"{source}: column {name!r} is not a channel: {hint}")


def _option(columns: Mapping[str, str]) -> str:
    """Return the option that reads several columns, by channel, with the units at the end of their names.

    Empty for a single column, and for names that the option cannot contain.
    """
    texts = []
    for meant in filter(columns.__contains__, CHANNELS):
        name = columns[meant]
        unit = None if _BRACKETED.match(name) else unit_in_name(name)
        texts.append(f"{meant}={name} [{unit[1]}]" if unit else f"{meant}={name}")
    writable = all("," not in text and text.isprintable() and len(text) < LONGEST_NAME for text in texts)
    return f"--columns {shlex.quote(','.join(texts))}" if writable and len(texts) > 1 else ""


def _suggestion(name: str, intended: str) -> str:
    suffixed = unit_in_name(name)
    if suffixed is not None:
        return f"'{intended} [{suffixed[1]}]'"
    bench_degrees = channel(intended).quantity == "angle" and name in channel(intended).bench_names
    return f"{intended} (rad; 'alpha [deg]' declares degrees)".replace("alpha", intended) if bench_degrees else intended


def _misspelled(column: str, written: str) -> str | None:
    """Return the channel with a name one typing error apart."""
    for name in CHANNELS:
        if len(name) >= SHORTEST_CHANNEL and _one_error_apart(column, name):
            return name
    near = (
        meant for alias, meant in _ALIASES.items() if len(alias) >= SHORTEST_ALIAS and _one_error_apart(written, alias)
    )
    return next(near, None)


def _one_error_apart(written: str, name: str) -> bool:
    """Return whether one letter is wrong, missing or added, or two adjacent ones are swapped."""
    same = next((i for i, (a, b) in enumerate(zip(written, name, strict=False)) if a != b), None)
    if same is None:
        return abs(len(written) - len(name)) <= 1
    left, right = written[same:], name[same:]
    swapped = left[1::-1] + left[2:]
    return right in (left[1:], swapped) or left == right[1:] or left[1:] == right[1:]
