"""The table [diagnosis] of an effect file: reading, checks and writing.

Examples
--------
>>> table = {"requires": ["T"], "channels": ["Fx", "Fy"], "forms": [{"sizes": {"TMU1": -0.002}}]}
>>> read_detection(table, "example.toml").forms[0].free
('TMU1',)
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from math import prod
from typing import Any

from ...boundary.errors import EffectError, nearest
from ...boundary.escaping import quoted, toml_string
from ...boundary.json_schema import by_name, list_schema, name_schema, object_schema, one_of
from ..contract import ROLES
from ..detection import Confounded, Detection, Form
from ..quantities import ALPHA, BEYOND, FX, FY, FZ, GAMMA, KAPPA, MX, MY, MZ, PHIT, P, V
from ..reserved import (
    COEFFICIENT_FORM,
    COEFFICIENT_NAME,
    EFFECT_FORM,
    EFFECT_NAME,
    LONGEST_NAME,
    no_coefficient,
    no_effect,
)
from .checks import LONGEST_TEXT, MAX_COEFFICIENTS

#: Upper limits of counts, and of the magnitude of a size and its reciprocal.
MAX_FORMS, MAX_PROBES, MAX_PAIRS, LARGEST_SIZE, MAX_POINTS = 10, 10, 20, 1e12, 20
INPUTS = ("t", *(quantity.name for quantity in (KAPPA, ALPHA, GAMMA, FZ, P, V, PHIT)), *BEYOND)
OUTPUTS = tuple(quantity.name for quantity in (FX, FY, MZ, MX, MY))
TEXT: dict[str, Any] = {
    "type": "string", "maxLength": LONGEST_TEXT, "pattern": r"\S", "title": f"a text of 1 to {LONGEST_TEXT} characters",
}  # fmt: skip
NAME = name_schema(EFFECT_NAME, LONGEST_NAME, f"{EFFECT_FORM}, of at most {LONGEST_NAME}")
COEFFICIENT = name_schema(COEFFICIENT_NAME, LONGEST_NAME, f"{COEFFICIENT_FORM}, of at most {LONGEST_NAME}")
POSITIVE = {"type": "number", "minimum": 1.0 / LARGEST_SIZE, "maximum": LARGEST_SIZE}
NEGATIVE = {"type": "number", "minimum": -LARGEST_SIZE, "maximum": -1.0 / LARGEST_SIZE}
SIZE = {"anyOf": [POSITIVE, NEGATIVE], "title": "a number other than 0, of plausible size"}
SIZES = {**by_name(COEFFICIENT, SIZE), "minProperties": 1, "maxProperties": MAX_COEFFICIENTS}
#: The keys of each table with the JSON Schemas of their values.
FORM_KEYS: dict[str, Any] = {
    "free": {**list_schema(COEFFICIENT, 1, MAX_COEFFICIENTS), "uniqueItems": True},
    "starts": list_schema(SIZES, 1, MAX_PROBES),
    "sizes": SIZES,
    "given": NAME,
    "holds": one_of(ROLES),
    "grid": {**by_name(COEFFICIENT, list_schema(SIZE, 1, MAX_POINTS)), "maxProperties": MAX_COEFFICIENTS},
}
PAIR_KEYS: dict[str, Any] = {"with": NAME, "separate_by": TEXT}
KEYS: dict[str, Any] = {
    "requires": {"type": "array", "items": one_of((*INPUTS, *OUTPUTS)), "uniqueItems": True},
    "rate": {**POSITIVE, "description": "rows per second that a recording must have"},
    "channels": {"type": "array", "items": one_of(OUTPUTS), "uniqueItems": True},
    "contains": NAME,
    "spread": {**by_name(COEFFICIENT, POSITIVE), "maxProperties": MAX_COEFFICIENTS},
    "separate_by": TEXT,
    "forms": list_schema(object_schema(FORM_KEYS), 0, MAX_FORMS),
    "refinements": list_schema(object_schema(FORM_KEYS), 0, MAX_FORMS),
    "confounded": list_schema(object_schema(PAIR_KEYS, PAIR_KEYS), 0, MAX_PAIRS),
}


def read_detection(given: Mapping[str, Any], location: str) -> Detection:
    """Return the declarations of a table [diagnosis] that satisfies the schema of `KEYS`.

    `location`: name of the file, for messages. Raises `EffectError` if a form is incomplete or a name is reserved.
    """
    location = f"{location}: [diagnosis]"
    return Detection(
        requires=tuple(given.get("requires", ())),
        rate=float(given.get("rate", 0.0)),
        channels=tuple(given.get("channels", ())),
        forms=tuple(_form(table, f"{location} forms") for table in given.get("forms", ())),
        refinements=tuple(_form(table, f"{location} refinements") for table in given.get("refinements", ())),
        contains=_effect(given, "contains", location),
        spread=_numbers(given.get("spread", {}), location),
        separate_by=given.get("separate_by", ""),
        confounded=tuple(
            Confounded(_effect(pair, "with", location), pair["separate_by"]) for pair in given.get("confounded", ())
        ),
    )


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


def _form(given: Mapping[str, Any], location: str) -> Form:
    present, holds = _effect(given, "given", location), given.get("holds", "")
    if ("sizes" in given) == ("starts" in given) or ("free" in given) != ("starts" in given):
        raise EffectError(f"{location}: either sizes, or free and starts are required")
    if "sizes" in given:
        grid = given.get("grid", {})
        for name in grid.keys() & given["sizes"].keys():
            raise EffectError(f"{location} grid: {quoted(name)} is also in sizes")
        if prod(map(len, grid.values())) > MAX_POINTS:
            raise EffectError(f"{location} grid has more than {MAX_POINTS} points")
        points = {name: tuple(map(float, values)) for name, values in grid.items()}
        return Form.each(_numbers(given["sizes"], location), present, holds, points)
    if "grid" in given:
        raise EffectError(f"{location}: grid requires sizes")
    free, probes = tuple(given["free"]), tuple(_numbers(start, location) for start in given["starts"])
    for name in (name for probe in probes for name in probe):
        if name not in free:
            raise EffectError(f"{location}: starts contains {name}, which is not in free{nearest(name, free)}")
    return Form(free, probes, False, present, holds)


def _effect(table: Mapping[str, Any], key: str, location: str) -> str:
    name: str = table.get(key, "")
    if name and (reason := no_effect(name)):
        raise EffectError(f"{location}: {key} {quoted(name)} {reason}")
    return name


def _numbers(table: Mapping[str, Any], location: str) -> dict[str, float]:
    for name in table:
        if reason := no_coefficient(name):
            raise EffectError(f"{location}: {quoted(name)} {reason}")
    return {name: float(number) for name, number in table.items()}
