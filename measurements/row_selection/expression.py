"""Selection of rows by an expression of names, units and comparisons. It is parsed here and never evaluated as code.

selection  = part ("or" part)*                    part = term ("and" term)*
term       = "not" term | "(" selection ")" | comparison
comparison = quantity compare value               t > 120, abs(alpha) <= 1 deg, segment == 3, file == "run.mat"
           | value compare quantity compare value 70 < p < 90 kPa
           | quantity ["not"] "in" ranges         p in 70..90 kPa, Fz in 220 +- 100 N, alpha in (0 +- 1, 3 +- 1 deg)
quantity   = name | "abs" "(" name ")"
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from math import inf, isfinite, nextafter
from typing import NamedTuple

import numpy as np

from ...boundary.errors import DataError, TirefmuError, nearest
from ...boundary.escaping import excerpt
from ...numerics.arrays import BoolArray, FloatArray
from ...symbolic.channels import CHANNELS
from ..column_names import intended_channel
from ..units import to_si

#: Returns the numbers of a name for every row: those of a channel in SI units, or a counter.
Columns = Callable[[str], FloatArray]
#: Returns for each row of a file with a name whether it satisfies a condition; NaN satisfies no comparison.
Matches = Callable[[Columns, str], BoolArray]

#: Numbers counted from 1: rows of the file, stretches without interruption, sweeps.
COUNTERS = ("sample", "segment", "sweep")
NAMES = (*CHANNELS, *COUNTERS, "file")
KEYWORDS = ("and", "or", "not", "in")
#: Upper limits: characters of an expression (those of the Trento report have fewer than 200), nested brackets and
#: negations, characters of the rest of an expression that a message quotes.
LONGEST_EXPRESSION, DEEPEST, QUOTED = 10_000, 50, 40
PLUS_MINUS = ("+-", "\u00b1")
_MIRRORED = {"<": ">", ">": "<", "<=": ">=", ">=": "<="}
_EQUAL = ("=", "==", "!=")
_WORD = re.compile(
    r"""\s*(?:(?P<comment>\#[^\n]*)
      |(?P<number>(?:\d+(?:\.(?!\.)\d*)?|\.\d+)(?:[eE][-+]?\d+)?)(?!\w*/m\b)
      |(?P<word>deg\ [CF]\b|1/m\b|%|[^\W\d]\w*(?:/[^\W\d]\w*)?)
      |(?P<text>"[^"\n]*"|'[^'\n]*')
      |(?P<operator>\.\.|\+-|<=|>=|==|!=|[-+<>=()\[\],\u00b1]))""",
    re.VERBOSE,
)


@dataclass(frozen=True)
class Selection:
    """The condition that an expression states.

    - `names`: the names that it uses: channels, counters, "file".
    - `matches`: returns for each row whether it satisfies the condition.
    """

    expression: str
    names: frozenset[str]
    matches: Matches = field(repr=False, compare=False)


def parse_selection(expression: str) -> Selection:
    """Return the condition that an expression states.

    Numbers without a unit are in SI units (deg C for T). Fz is the load in every sign convention, positive for a loaded
    wheel; all other channels have the signs of the table. Names are the channels, ``sample``, ``segment`` and ``sweep``
    (counted from 1), and ``file``. Raises `DataError` with the word that is wrong, and the nearest valid name.
    """
    parser = _Parser(expression)
    matches = parser.selection()
    parser.expect("end", "", "'and', 'or' or the end")
    return Selection(expression, frozenset(parser.names), matches)


def parse_range(text: str, channel: str) -> tuple[float, float]:
    """Return value and tolerance of one range, such as ``220 +- 100 N`` or ``70..90 kPa``, in SI units.

    The limits are included. Raises `DataError` if it is not a range, or the unit is not one of the channel.

    >>> parse_range("220 +- 100 N", "Fz"), parse_range("70..90 kPa", "p")
    ((220.0, 100.0), (80000.0, 10000.0))
    """
    parser = _Parser(text)
    limits = parser.range_from(parser.value(), channel)
    parser.expect("end", "", "the end")
    return limits.value, limits.tolerance


def quoted(text: str, most: int = QUOTED) -> str:
    """Return the beginning of a text in quotation marks, on one line."""
    return repr(excerpt(" ".join(text.split()), most))


class _Word(NamedTuple):
    """A word of an expression: a number, a word (name, unit, keyword), a text, an operator, or the end; its index."""

    kind: str
    text: str
    at: int


class _Value(NamedTuple):
    """A number and its unit, which may be stated at the other end of a range."""

    number: float
    unit: str | None


class _Range(NamedTuple):
    """A range by its limits, and by its middle and half width, each as exact as it was written."""

    low: float
    high: float
    value: float
    tolerance: float


def _words(expression: str) -> list[_Word]:
    """Return the words of an expression, and the end. Lines may end in a comment after ``#``."""
    if len(expression) > LONGEST_EXPRESSION:
        raise DataError(f"where: {len(expression)} characters: at most {LONGEST_EXPRESSION} are read")
    words, at = [], 0
    while expression[at:].strip():
        match = _WORD.match(expression, at)
        if match is None or match.lastgroup is None:
            raise DataError(f"where {quoted(expression)}: {quoted(expression[at:].strip(), 10)} has no meaning here")
        if match.lastgroup != "comment":
            words.append(_Word(match.lastgroup, match[match.lastgroup], match.start(match.lastgroup)))
        at = match.end()
    return [*words, _Word("end", "", len(expression))]


def _in_ranges(name: str, absolute: bool, ranges: Sequence[tuple[float, float]]) -> Matches:
    """Return the condition that a name, or its magnitude, is in one of several ranges. Their limits are included."""

    def matches(columns: Columns, file: str) -> BoolArray:
        values = np.abs(columns(name)) if absolute else columns(name)
        return np.asarray(np.any([(values >= low) & (values <= high) for low, high in ranges], axis=0))

    return matches


def _not(part: Matches) -> Matches:
    return lambda columns, file: ~part(columns, file)


def _joined(parts: Sequence[Matches], join: Callable[..., BoolArray]) -> Matches:
    return lambda columns, file: np.asarray(join([part(columns, file) for part in parts], axis=0))


class _Parser:
    """Recursive descent over the words of one expression."""

    def __init__(self, expression: str) -> None:
        self.expression, self.names = expression, set[str]()
        self._words, self._at, self._depth = _words(expression), 0, 0

    @property
    def _next(self) -> _Word:
        return self._words[self._at]

    def selection(self) -> Matches:
        return self._chain_of("or", np.any, lambda: self._chain_of("and", np.all, self._term))

    def _chain_of(self, word: str, join: Callable[..., BoolArray], part: Callable[[], Matches]) -> Matches:
        parts = [part()]
        while self._take(word):
            parts.append(part())
        return _joined(parts, join) if len(parts) > 1 else parts[0]

    def _term(self) -> Matches:
        self._depth += 1
        if self._depth > DEEPEST:
            raise self._error(f"more than {DEEPEST} nested brackets")
        if self._take("not"):
            condition = _not(self._term())
        elif self._take("("):
            condition = self.selection()
            self.expect("operator", ")", "')'")
        else:
            condition = self._comparison()
        self._depth -= 1
        return condition

    def _comparison(self) -> Matches:
        if self._next.kind == "number" or self._next.text in ("-", "+"):
            return self._between()
        name, absolute = self._quantity()
        if name == "file":
            return self._file()
        negated = self._take("not")
        if self._take("in"):
            condition = _in_ranges(name, absolute, self._ranges(name))
            return _not(condition) if negated else condition
        if negated:
            raise self._unexpected("'in'")
        compare = self._compare()
        if compare not in _EQUAL:
            return _in_ranges(name, absolute, [self._half_line(name, compare, self.value())])
        if name not in COUNTERS:
            raise self._error(f"{name} is measured and equals no number exactly: write '{name} in 0 +- 1 UNIT'")
        number = self._si(name, self.value())
        condition = _in_ranges(name, absolute, [(number, number)])
        return _not(condition) if compare == "!=" else condition

    def _between(self) -> Matches:
        """Return the condition of a comparison that begins with a number."""
        low, first = self.value(), self._compare()
        name, absolute = self._quantity()
        if first not in _MIRRORED or name == "file":
            raise self._error(f"a number before {name!r} is compared by < or >")
        second = self._compare() if self._next.text in _MIRRORED else None
        if second is None:
            return _in_ranges(name, absolute, [self._half_line(name, _MIRRORED[first], low)])
        if second[0] != first[0]:
            raise self._error(f"{first} and {second} in one comparison")
        high = self.value()
        low = _Value(low.number, low.unit or high.unit)
        left, right = self._half_line(name, _MIRRORED[first], low), self._half_line(name, second, high)
        return _in_ranges(name, absolute, [(max(left[0], right[0]), min(left[1], right[1]))])

    def _file(self) -> Matches:
        compare = self._compare()
        if compare not in _EQUAL:
            raise self._error('a file is compared like file == "run.mat"')
        name = self.expect("text", None, 'the name of a file, such as "run.mat"').text[1:-1]
        return lambda columns, file: np.full(len(columns("sample")), (file == name) == (compare != "!="))

    def _half_line(self, name: str, compare: str, value: _Value) -> tuple[float, float]:
        """Return the limits, both included, of the numbers that a comparison accepts."""
        limit = self._si(name, value)
        if compare[0] == "<":
            return -inf, limit if compare == "<=" else nextafter(limit, -inf)
        return limit if compare == ">=" else nextafter(limit, inf), inf

    def _ranges(self, name: str) -> list[tuple[float, float]]:
        closing = {"(": ")", "[": "]"}.get(self._next.text)
        if closing is None:
            return [self._limits(name)]
        self._at += 1
        ranges = [self._limits(name)]
        while self._take(","):
            ranges.append(self._limits(name))
        self.expect("operator", closing, f"',' or '{closing}'")
        return ranges

    def _limits(self, name: str) -> tuple[float, float]:
        """Return the limits of a range or, for a counter, of one number."""
        first = self.value()
        if name in COUNTERS and self._next.text not in ("..", *PLUS_MINUS):
            number = self._si(name, first)
            return number, number
        return self.range_from(first, name)[:2]

    def range_from(self, first: _Value, name: str) -> _Range:
        """Return the range that begins with a value: ``a..b`` or ``a +- b``."""
        if self._take(".."):
            last = self.value()
            low, high = self._si(name, _Value(first.number, first.unit or last.unit)), self._si(name, last)
            if low > high:
                raise self._error(f"the range of {name} ends before it begins")
            return _Range(low, high, 0.5 * (low + high), 0.5 * (high - low))
        if not any(map(self._take, PLUS_MINUS)):
            raise self._unexpected("a range such as '70..90 kPa' or '220 +- 100 N'")
        width = self.value()
        if width.number < 0.0:
            raise self._error(f"the tolerance {width.number:g} is negative")
        unit = width.unit or first.unit
        # The width of a range of temperatures has no offset.
        tolerance = self._si(name, _Value(width.number, unit)) - self._si(name, _Value(0.0, unit))
        value = self._si(name, _Value(first.number, first.unit or unit))
        return _Range(value - tolerance, value + tolerance, value, tolerance)

    def _quantity(self) -> tuple[str, bool]:
        """Return a name, and whether its magnitude is meant."""
        absolute = self._next.text == "abs"
        if absolute:
            self._at += 1
            self.expect("operator", "(", "'('")
        name = self._next.text
        if self._next.kind != "word" or name in KEYWORDS:
            raise self._unexpected("a name")
        if name not in NAMES:
            meant = intended_channel(name)
            hint = f": did you mean {meant}? Known are {', '.join(NAMES)}" if meant else nearest(name, NAMES)
            raise self._error(f"unknown name {quoted(name)}{hint}")
        self._at += 1
        self.names.add(name)
        if absolute:
            self.expect("operator", ")", "')'")
        return name, absolute

    def _compare(self) -> str:
        if self._next.text not in (*_MIRRORED, *_EQUAL):
            raise self._unexpected("a comparison (< <= > >= == in)")
        self._at += 1
        return self._words[self._at - 1].text

    def value(self) -> _Value:
        sign = -1.0 if self._take("-") else 1.0
        if sign > 0.0:
            self._take("+")
        number = sign * float(self.expect("number", None, "a number").text)
        if not isfinite(number):
            raise self._error("a number is too large")
        unit = self._next.text if self._next.kind == "word" and self._next.text not in KEYWORDS else None
        self._at += unit is not None
        return _Value(number, unit)

    def _si(self, name: str, value: _Value) -> float:
        if name in COUNTERS:
            if value.unit is not None or value.number != int(value.number):
                raise self._error(f"{name} is compared with whole numbers")
            return value.number
        if value.unit is None:
            return value.number
        try:
            # An effect may have an input that is not a channel.
            quantity = CHANNELS[name].quantity if name in CHANNELS else None
            number = float(to_si(value.number, value.unit, quantity))
        except TirefmuError as error:
            raise self._error(f"{name}: {error}") from None
        if not isfinite(number):
            raise self._error("a number is too large")
        return number

    def _take(self, text: str) -> bool:
        """Advance if the next word is a certain one, and return whether it is."""
        taken = self._next.text == text and self._next.kind in ("word", "operator")
        self._at += taken
        return taken

    def expect(self, kind: str, text: str | None, wanted: str) -> _Word:
        """Return the next word and advance; raise for another one."""
        word = self._next
        if word.kind != kind or (text is not None and word.text != text):
            raise self._unexpected(wanted)
        self._at += word.kind != "end"
        return word

    def _unexpected(self, wanted: str) -> DataError:
        rest = "the end" if self._next.kind == "end" else quoted(self.expression[self._next.at :], 20)
        return self._error(f"{wanted} is expected at {rest}")

    def _error(self, reason: str) -> DataError:
        return DataError(f"where {quoted(self.expression)}: {reason}")
