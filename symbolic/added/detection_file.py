"""The table [diagnosis] of an effect file: reading, checks and writing.

Examples
--------
>>> table = {"requires": ["T"], "channels": ["Fx", "Fy"], "forms": [{"sizes": {"TMU1": -0.002}}]}
>>> read_detection(table, "example.toml", {"TMU1"}).forms[0].free
('TMU1',)
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from typing import Annotated, Any

from tirefmu.boundary.errors import EffectError, nearest
from tirefmu.boundary.escaping import quoted, toml_string, visible
from tirefmu.boundary.json_schema import by_name, name_schema, one_of, tables_schema

from ..contract import ROLES
from ..detection import Confounded, Detection, Form
from ..quantities import ALPHA, BEYOND, FX, FY, FZ, GAMMA, KAPPA, MX, MY, MZ, PHIT, P, V
from ..reserved import COEFFICIENT_NAME, EFFECT_NAME, LONGEST_NAME, no_coefficient, no_effect
from .checks import LONGEST_TEXT, MAX_COEFFICIENTS

#: Upper limits of counts, and of the magnitude of a size and its reciprocal.
MAX_FORMS, MAX_PROBES, MAX_PAIRS, LARGEST_SIZE, MAX_POINTS = 10, 10, 20, 1e12, 20
INPUTS = ("t", *(quantity.name for quantity in (KAPPA, ALPHA, GAMMA, FZ, P, V, PHIT)), *BEYOND)
OUTPUTS = tuple(quantity.name for quantity in (FX, FY, MZ, MX, MY))
TEXT, NAME = {"type": "string", "maxLength": LONGEST_TEXT}, name_schema(EFFECT_NAME)
NUMBERS = by_name(COEFFICIENT_NAME, float)
#: The keys of each table with the JSON Schemas of their values.
FORM_KEYS: dict[str, Any] = {
    "free": list[str], "starts": {"type": "array", "items": NUMBERS}, "sizes": NUMBERS, "given": NAME,
    "holds": one_of(ROLES), "grid": by_name(COEFFICIENT_NAME, list[float]),
}  # fmt: skip
PAIR_KEYS: dict[str, Any] = {"with": NAME, "separate_by": TEXT}
KEYS: dict[str, Any] = {
    "requires": {"type": "array", "items": one_of((*INPUTS, *OUTPUTS)), "uniqueItems": True},
    "rate": Annotated[float, "rows per second that a recording must have", {"exclusiveMinimum": 0}],
    "channels": {"type": "array", "items": one_of(OUTPUTS), "uniqueItems": True},
    "contains": NAME,
    "spread": NUMBERS,
    "separate_by": TEXT,
    "forms": tables_schema(FORM_KEYS, MAX_FORMS),
    "refinements": tables_schema(FORM_KEYS, MAX_FORMS),
    "confounded": tables_schema(PAIR_KEYS, MAX_PAIRS, PAIR_KEYS),
}


def read_detection(table: object, location: str, own: Collection[str] | None = None) -> Detection:
    """Return the declarations of a table [diagnosis].

    `table`: as parsed from TOML. `location`: name of the file, for messages. `own`: coefficients that the file
    declares; the table may then use no others. Raises `EffectError` if a key, a name, a number or a count is invalid.
    """
    location = f"{location}: [diagnosis]"
    given = known_keys(table, KEYS, location)
    detection = Detection(
        requires=_words(given, "requires", location, (*INPUTS, *OUTPUTS)),
        rate=_rate(given, location),
        channels=_words(given, "channels", location, OUTPUTS),
        forms=_forms(given, "forms", location),
        refinements=_forms(given, "refinements", location),
        contains=_effect(given, "contains", location),
        spread=_sizes(given.get("spread", {}), f"{location} spread", positive=True),
        separate_by=_text(given, "separate_by", location),
        confounded=tuple(_pair(one, location) for one in _tables(given, "confounded", location, MAX_PAIRS)),
    )
    if own is not None:
        used = [name for form in (*detection.forms, *detection.refinements) for name in form.free]
        for name in (*used, *detection.spread):
            if name not in own:
                raise EffectError(f"{location}: {name} is not a coefficient of this effect{nearest(name, own)}")
    return detection


def detection_text(detection: Detection) -> str:
    """Return the text of a table [diagnosis]; `read_detection` is the inverse."""
    lines = ["[diagnosis]"]
    lines += [f"requires = {_list(detection.requires)}"] if detection.requires else []
    lines += [f"rate = {detection.rate!r}"] if detection.rate else []
    lines += [f"channels = {_list(detection.channels)}"] if detection.channels else []
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


def known_keys(table: object, keys: Iterable[str], location: str) -> dict[str, Any]:
    """Return a table if it has only these keys, otherwise raise `EffectError`."""
    if not isinstance(table, dict):
        raise EffectError(f"{location} is not a table")
    for key in table:
        if key not in keys:
            raise EffectError(f"{location}: unknown key {quoted(key)}{nearest(key, sorted(keys))}")
    return table


def _form_lines(form: Form) -> Iterable[str]:
    for key, text in (("given", form.given), ("holds", form.holds)):
        if text:
            yield f"{key} = {toml_string(text)}"
    if form.scalable:
        yield f"sizes = {_inline({name: size for probe in form.probes for name, size in probe.items()})}"
        if form.grid:
            points = (f"{name} = [{', '.join(repr(float(v)) for v in values)}]" for name, values in form.grid.items())
            yield f"grid = {{{', '.join(points)}}}"
    else:
        yield f"free = {_list(form.free)}"
        yield f"starts = [{', '.join(_inline(probe) for probe in form.probes)}]"


def _inline(numbers: Mapping[str, float]) -> str:
    return f"{{{', '.join(f'{name} = {float(number)!r}' for name, number in numbers.items())}}}"


def _list(words: Iterable[str]) -> str:
    return f"[{', '.join(map(toml_string, words))}]"


def _words(table: dict[str, Any], key: str, location: str, known: Collection[str]) -> tuple[str, ...]:
    words = table.get(key, [])
    if not isinstance(words, list) or not all(isinstance(word, str) for word in words):
        raise EffectError(f"{location}: {key} is not a list of names")
    for word in words:
        if word not in known:
            raise EffectError(f"{location}: {key} contains the unknown name {quoted(word)}{nearest(word, known)}")
    if len(set(words)) < len(words):
        raise EffectError(f"{location}: {key} contains a name twice")
    return tuple(words)


def _rate(table: dict[str, Any], location: str) -> float:
    if "rate" not in table:
        return 0.0
    return _sizes({"RATE": table["rate"]}, f"{location} rate", positive=True)["RATE"]


def _text(table: dict[str, Any], key: str, location: str) -> str:
    text = table.get(key, "")
    if not isinstance(text, str) or len(text) > LONGEST_TEXT:
        raise EffectError(f"{location}: {key} is not a text of at most {LONGEST_TEXT} characters")
    return text


def _effect(table: dict[str, Any], key: str, location: str) -> str:
    name = _text(table, key, location)
    if name and (len(name) > LONGEST_NAME or (reason := no_effect(name))):
        why = reason if len(name) <= LONGEST_NAME else f"has more than {LONGEST_NAME} characters"
        raise EffectError(f"{location}: {key} {quoted(name)} {why}")
    return name


def _tables(table: dict[str, Any], key: str, location: str, most: int) -> list[Any]:
    tables = table.get(key, [])
    if not isinstance(tables, list):
        raise EffectError(f"{location}: {key} is not a list of tables [[diagnosis.{key}]]")
    if len(tables) > most:
        raise EffectError(f"{location}: {key} has {len(tables)} tables, at most {most} are allowed")
    return tables


def _forms(table: dict[str, Any], key: str, location: str) -> tuple[Form, ...]:
    return tuple(_form(one, f"{location} {key}") for one in _tables(table, key, location, MAX_FORMS))


def _form(table: object, location: str) -> Form:
    given = known_keys(table, FORM_KEYS, location)
    present, holds = _effect(given, "given", location), _text(given, "holds", location)
    if holds and holds not in ROLES:
        raise EffectError(f"{location}: holds = {quoted(holds)} is not a role of a quantity{nearest(holds, ROLES)}")
    if ("sizes" in given) == ("starts" in given) or ("free" in given) != ("starts" in given):
        raise EffectError(f"{location}: either sizes, or free and starts are required")
    if "sizes" in given:
        sizes = _sizes(given["sizes"], f"{location} sizes", least=1)
        return Form.each(sizes, present, holds, _grid(given.get("grid", {}), f"{location} grid", sizes))
    if "grid" in given:
        raise EffectError(f"{location}: grid requires sizes")
    starts, free = given["starts"], given["free"]
    if not isinstance(free, list) or not 1 <= len(free) <= MAX_COEFFICIENTS:
        raise EffectError(f"{location}: free is not a list of 1 to {MAX_COEFFICIENTS} coefficients")
    if not isinstance(starts, list) or not 1 <= len(starts) <= MAX_PROBES:
        raise EffectError(f"{location}: starts is not a list of 1 to {MAX_PROBES} tables")
    probes = tuple(_sizes(start, f"{location} starts", least=1) for start in starts)
    _check_coefficients(free, f"{location} free")
    for name in (name for probe in probes for name in probe):
        if name not in free:
            raise EffectError(f"{location}: starts contains {name}, which is not in free{nearest(name, free)}")
    return Form(tuple(free), probes, False, present, holds)


def _grid(table: object, location: str, sizes: Collection[str]) -> dict[str, tuple[float, ...]]:
    """Return the values of each coefficient of a grid."""
    if not isinstance(table, dict) or len(table) > MAX_COEFFICIENTS:
        raise EffectError(f"{location} is not a table of at most {MAX_COEFFICIENTS} coefficients and lists of numbers")
    points = 1
    for name, values in table.items():
        if name in sizes:
            raise EffectError(f"{location}: {quoted(name)} is also in sizes")
        if not isinstance(values, list) or not values:
            raise EffectError(f"{location}: {quoted(name)} is not a list of numbers")
        points *= len(values)
        if points > MAX_POINTS:
            raise EffectError(f"{location} has more than {MAX_POINTS} points")
        for value in values:
            _sizes({name: value}, location)
    return {name: tuple(map(float, values)) for name, values in table.items()}


def _sizes(table: object, location: str, *, least: int = 0, positive: bool = False) -> dict[str, float]:
    if not isinstance(table, dict) or not least <= len(table) <= MAX_COEFFICIENTS:
        raise EffectError(f"{location} is not a table of {least} to {MAX_COEFFICIENTS} coefficients and numbers")
    _check_coefficients(list(table), location)
    for name, size in table.items():
        number = isinstance(size, (int, float)) and not isinstance(size, bool)
        if not number or not 1.0 / LARGEST_SIZE <= (size if positive else abs(size)) <= LARGEST_SIZE:
            what = "a positive number" if positive else "a number other than 0"
            raise EffectError(f"{location}: {name} = {visible(repr(size))[:80]} is not {what} of plausible magnitude")
    return {name: float(size) for name, size in table.items()}


def _check_coefficients(names: Collection[object], location: str) -> None:
    for name in names:
        reason = no_coefficient(name) if isinstance(name, str) else "is not a text"
        if reason:
            raise EffectError(f"{location}: {quoted(name)} {reason}")
    if len(set(names)) < len(names):
        raise EffectError(f"{location} contains a coefficient twice")


def _pair(table: object, location: str) -> Confounded:
    location = f"{location} confounded"
    given = known_keys(table, PAIR_KEYS, location)
    other, how = _effect(given, "with", location), _text(given, "separate_by", location)
    if not other or not how.strip():
        raise EffectError(f"{location}: with and separate_by are required")
    return Confounded(other, how)
