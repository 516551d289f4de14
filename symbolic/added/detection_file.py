"""The table [diagnosis] of an effect's file: read, checked and written.

Examples
--------
>>> table = {"requires": ["T"], "channels": ["Fx", "Fy"], "forms": [{"sizes": {"TMU1": -0.002}}]}
>>> read_detection(table, "example.toml", {"TMU1"}).forms[0].free
('TMU1',)
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from typing import Any

from ..contract import ROLES
from ..detection import Confounded, Detection, Form
from ..errors import EffectError, nearest
from ..escaping import quoted, toml_string, visible
from ..quantities import ALPHA, BEYOND, FX, FY, FZ, GAMMA, KAPPA, MX, MY, MZ, PHIT, P, V
from ..reserved import LONGEST_NAME, no_coefficient, no_effect
from .checks import LONGEST_TEXT, MOST_COEFFICIENTS

#: Upper limits of counts, and of the magnitude of a size and of its reciprocal.
MOST_FORMS, MOST_PROBES, MOST_PAIRS, LARGEST_SIZE = 10, 10, 20, 1e12
INPUTS = ("t", *(quantity.name for quantity in (KAPPA, ALPHA, GAMMA, FZ, P, V, PHIT)), *BEYOND)
OUTPUTS = tuple(quantity.name for quantity in (FX, FY, MZ, MX, MY))
KEYS = ("requires", "channels", "contains", "spread", "separate_by", "forms", "refinements", "confounded")
FORM_KEYS = ("free", "starts", "sizes", "given", "holds")


def read_detection(table: object, place: str, own: Collection[str] | None = None) -> Detection:
    """Return what a table [diagnosis] declares.

    Parameters
    ----------
    table : object
        As TOML gave it.
    place : str
        The file's name, for messages.
    own : collection of str, optional
        The coefficients that the file declares, to which the table is then limited.

    Returns
    -------
    Detection

    Raises
    ------
    EffectError
        If a key, a name, a number or a count is not admissible.
    """
    place = f"{place}: [diagnosis]"
    given = known_keys(table, KEYS, place)
    detection = Detection(
        requires=_words(given, "requires", place, INPUTS),
        channels=_words(given, "channels", place, OUTPUTS),
        forms=_forms(given, "forms", place),
        refinements=_forms(given, "refinements", place),
        contains=_effect(given, "contains", place),
        spread=_sizes(given.get("spread", {}), f"{place} spread", positive=True),
        separate_by=_text(given, "separate_by", place),
        confounded=tuple(_pair(one, place) for one in _tables(given, "confounded", place, MOST_PAIRS)),
    )
    if own is not None:
        used = [name for form in (*detection.forms, *detection.refinements) for name in form.free]
        for name in (*used, *detection.spread):
            if name not in own:
                raise EffectError(f"{place}: {name} is no coefficient of this effect{nearest(name, own)}")
    return detection


def detection_text(detection: Detection) -> str:
    """Return the lines of a table [diagnosis]; `read_detection` reads an equal one from them."""
    lines = ["[diagnosis]"]
    for key, words in (("requires", detection.requires), ("channels", detection.channels)):
        lines += [f"{key} = {_list(words)}"] if words else []
    for key, text in (("contains", detection.contains), ("separate_by", detection.separate_by)):
        lines += [f"{key} = {toml_string(text)}"] if text else []
    lines += [f"spread = {_inline(detection.spread)}"] if detection.spread else []
    for key, forms in (("forms", detection.forms), ("refinements", detection.refinements)):
        for form in forms:
            lines += ["", f"[[diagnosis.{key}]]", *_form_lines(form)]
    for pair in detection.confounded:
        lines += ["", "[[diagnosis.confounded]]", f"with = {toml_string(pair.other)}"]
        lines += [f"separate_by = {toml_string(pair.separate_by)}"]
    return "\n".join(lines)


def known_keys(table: object, keys: Iterable[str], place: str) -> dict[str, Any]:
    """Return a table that has none but these keys, or raise `EffectError`."""
    if not isinstance(table, dict):
        raise EffectError(f"{place} is not a table")
    for key in table:
        if key not in keys:
            raise EffectError(f"{place}: unknown key {quoted(key)}{nearest(key, sorted(keys))}")
    return table


def _form_lines(form: Form) -> Iterable[str]:
    for key, text in (("given", form.given), ("holds", form.holds)):
        if text:
            yield f"{key} = {toml_string(text)}"
    if form.scalable:
        yield f"sizes = {_inline({name: size for probe in form.probes for name, size in probe.items()})}"
    else:
        yield f"free = {_list(form.free)}"
        yield f"starts = [{', '.join(_inline(probe) for probe in form.probes)}]"


def _inline(numbers: Mapping[str, float]) -> str:
    return f"{{{', '.join(f'{name} = {float(number)!r}' for name, number in numbers.items())}}}"


def _list(words: Iterable[str]) -> str:
    return f"[{', '.join(map(toml_string, words))}]"


def _words(table: dict[str, Any], key: str, place: str, known: Collection[str]) -> tuple[str, ...]:
    words = table.get(key, [])
    if not isinstance(words, list) or not all(isinstance(word, str) for word in words):
        raise EffectError(f"{place}: {key} is not a list of names")
    for word in words:
        if word not in known:
            raise EffectError(f"{place}: {key} has {quoted(word)}{nearest(word, known)}")
    if len(set(words)) < len(words):
        raise EffectError(f"{place}: {key} has a name twice")
    return tuple(words)


def _text(table: dict[str, Any], key: str, place: str) -> str:
    text = table.get(key, "")
    if not isinstance(text, str) or len(text) > LONGEST_TEXT:
        raise EffectError(f"{place}: {key} is not a text of at most {LONGEST_TEXT} characters")
    return text


def _effect(table: dict[str, Any], key: str, place: str) -> str:
    name = _text(table, key, place)
    if name and (len(name) > LONGEST_NAME or (reason := no_effect(name))):
        why = reason if len(name) <= LONGEST_NAME else f"has more than {LONGEST_NAME} characters"
        raise EffectError(f"{place}: {key} {quoted(name)} {why}")
    return name


def _tables(table: dict[str, Any], key: str, place: str, most: int) -> list[Any]:
    tables = table.get(key, [])
    if not isinstance(tables, list):
        raise EffectError(f"{place}: {key} is not a list of tables [[diagnosis.{key}]]")
    if len(tables) > most:
        raise EffectError(f"{place}: {key} has {len(tables)} tables, {most} at most")
    return tables


def _forms(table: dict[str, Any], key: str, place: str) -> tuple[Form, ...]:
    return tuple(_form(one, f"{place} {key}") for one in _tables(table, key, place, MOST_FORMS))


def _form(table: object, place: str) -> Form:
    given = known_keys(table, FORM_KEYS, place)
    present, holds = _effect(given, "given", place), _text(given, "holds", place)
    if holds and holds not in ROLES:
        raise EffectError(f"{place}: holds = {quoted(holds)} is no role of a quantity{nearest(holds, ROLES)}")
    if ("sizes" in given) == ("starts" in given) or ("free" in given) != ("starts" in given):
        raise EffectError(f"{place}: either sizes, or free and starts are needed")
    if "sizes" in given:
        return Form.each(_sizes(given["sizes"], f"{place} sizes", least=1), present, holds)
    starts, free = given["starts"], given["free"]
    if not isinstance(free, list) or not 1 <= len(free) <= MOST_COEFFICIENTS:
        raise EffectError(f"{place}: free is not a list of 1 to {MOST_COEFFICIENTS} coefficients")
    if not isinstance(starts, list) or not 1 <= len(starts) <= MOST_PROBES:
        raise EffectError(f"{place}: starts is not a list of 1 to {MOST_PROBES} tables")
    probes = tuple(_sizes(start, f"{place} starts", least=1) for start in starts)
    _check_coefficients(free, f"{place} free")
    for name in (name for probe in probes for name in probe):
        if name not in free:
            raise EffectError(f"{place}: starts has {name}, which free has not{nearest(name, free)}")
    return Form(tuple(free), probes, False, present, holds)


def _sizes(table: object, place: str, *, least: int = 0, positive: bool = False) -> dict[str, float]:
    if not isinstance(table, dict) or not least <= len(table) <= MOST_COEFFICIENTS:
        raise EffectError(f"{place} is not a table of {least} to {MOST_COEFFICIENTS} coefficients and numbers")
    _check_coefficients(list(table), place)
    for name, size in table.items():
        number = isinstance(size, (int, float)) and not isinstance(size, bool)
        if not number or not 1.0 / LARGEST_SIZE <= (size if positive else abs(size)) <= LARGEST_SIZE:
            what = "a positive number" if positive else "a number other than 0"
            raise EffectError(f"{place}: {name} = {visible(repr(size))[:80]} is not {what} of usual magnitude")
    return {name: float(size) for name, size in table.items()}


def _check_coefficients(names: Collection[object], place: str) -> None:
    for name in names:
        reason = no_coefficient(name) if isinstance(name, str) else "is no text"
        if reason:
            raise EffectError(f"{place}: {quoted(name)} {reason}")
    if len(set(names)) < len(names):
        raise EffectError(f"{place} has a coefficient twice")


def _pair(table: object, place: str) -> Confounded:
    place = f"{place} confounded"
    given = known_keys(table, ("with", "separate_by"), place)
    other, how = _effect(given, "with", place), _text(given, "separate_by", place)
    if not other or not how.strip():
        raise EffectError(f"{place}: with and separate_by are needed")
    return Confounded(other, how)
