"""Parser of a selection. It knows names, units and comparisons, nothing else: an expression is never evaluated as code.

selection  = part ("or" part)*                    part = term ("and" term)*
term       = "not" term | "(" selection ")" | comparison
comparison = quantity compare value               t > 120, abs(alpha) <= 1 deg, segment == 3, file == "run.mat"
           | value compare quantity compare value 70 < p < 90 kPa
           | quantity ["not"] "in" ranges         p in 70..90 kPa, Fz in 220 +- 100 N, alpha in (0 +- 1, 3 +- 1 deg)
quantity   = name | "abs" "(" name ")"
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import inf, isfinite, nextafter

from tirefmu.symbolic.errors import DataError, TirefmuError, nearest

from ..channels import CHANNELS
from ..column_names import intended_channel
from ..units import to_si
from .rows import AllOf, AnyOf, InFile, InRanges, Not, Rows
from .tokens import KEYWORDS, Token, quoted, tokens

#: Numbers counted from 1: rows of the file, stretches without interruption, sweeps.
COUNTERS = ("sample", "segment", "sweep")
NAMES = (*CHANNELS, *COUNTERS, "file")
#: Largest number of nested brackets and negations.
DEEPEST = 50
PLUS_MINUS = "\u00b1"
_MIRRORED = {"<": ">", ">": "<", "<=": ">=", ">=": "<="}


def parse_selection(expression: str) -> Rows:
    """Return the condition that an expression states.

    Parameters
    ----------
    expression : str
        Numbers without a unit are in SI units (deg C for T). Fz is the load in every sign convention, positive for a
        loaded wheel; all other channels have the signs of the table. Names: the channels, ``sample``, ``segment`` and
        ``sweep`` (counted from 1), ``file``.

    Returns
    -------
    Rows

    Raises
    ------
    DataError
        With the word that is wrong, and the nearest valid name.

    Examples
    --------
    >>> sorted(parse_selection("t > 2 min and p in 70..90 kPa").names())
    ['p', 't']
    >>> parse_selection("t > 2 min and pressure > 70 kPa")
    Traceback (most recent call last):
    ...
    tirefmu.symbolic.errors.DataError: where 't > 2 min and pressure > 70 kPa': unknown name 'pressure': did you ...
    """
    parser = _Parser(expression)
    selection = parser.selection()
    parser.expect("end", "", "'and', 'or' or the end")
    return selection


def parse_range(text: str, channel: str) -> tuple[float, float]:
    """Return value and tolerance of one range, such as ``220 +- 100 N`` or ``70..90 kPa``.

    Parameters
    ----------
    text : str
    channel : str
        The contract's name, for the unit.

    Returns
    -------
    tuple of (float, float)
        In SI units. The limits are included.

    Raises
    ------
    DataError
        If it is not a range, or the unit is not one of the channel.

    Examples
    --------
    >>> parse_range("220 +- 100 N", "Fz"), parse_range("70..90 kPa", "p")
    ((220.0, 100.0), (80000.0, 10000.0))
    """
    parser = _Parser(text)
    found = parser.range(channel)
    parser.expect("end", "", "the end")
    return found.value, found.tolerance


@dataclass(frozen=True)
class _Value:
    """A number and its unit, which may be stated at the other end of a range."""

    number: float
    unit: str | None


@dataclass(frozen=True)
class _Range:
    """A range by its limits, and by its middle and half width, each as exact as it was written."""

    low: float
    high: float
    value: float
    tolerance: float


class _Parser:
    """Recursive descent over the words of one expression."""

    def __init__(self, expression: str) -> None:
        self.expression = expression
        self.tokens = tokens(expression)
        self.at = 0
        self.depth = 0

    @property
    def next(self) -> Token:
        return self.tokens[self.at]

    def selection(self) -> Rows:
        return self._joined("or", AnyOf, lambda: self._joined("and", AllOf, self._term))

    def _joined(self, word: str, join: Callable[[tuple[Rows, ...]], Rows], part: Callable[[], Rows]) -> Rows:
        parts = [part()]
        while self._take(word):
            parts.append(part())
        return join(tuple(parts)) if len(parts) > 1 else parts[0]

    def _term(self) -> Rows:
        self.depth += 1
        if self.depth > DEEPEST:
            raise self._error(f"more than {DEEPEST} nested brackets")
        if self._take("not"):
            found: Rows = Not(self._term())
        elif self._take("("):
            found = self.selection()
            self.expect("operator", ")", "')'")
        else:
            found = self._comparison()
        self.depth -= 1
        return found

    def _comparison(self) -> Rows:
        if self.next.kind == "number" or self.next.text in ("-", "+"):
            return self._chain()
        name, absolute = self._quantity()
        if name == "file":
            return self._file()
        negated = self._take("not")
        if self._take("in"):
            found = InRanges(name, absolute, tuple(self._ranges(name)))
            return Not(found) if negated else found
        if negated:
            raise self._unexpected("'in'")
        compare = self._compare()
        if compare in ("=", "==", "!="):
            return self._equal(name, absolute, compare)
        return InRanges(name, absolute, (self._half_line(name, compare, self._value()),))

    def _chain(self) -> Rows:
        low, first = self._value(), self._compare()
        name, absolute = self._quantity()
        if first not in _MIRRORED or name == "file":
            raise self._error(f"a number before {name!r} is compared by < or >")
        second = self._compare() if self.next.text in _MIRRORED else None
        if second is None:
            return InRanges(name, absolute, (self._half_line(name, _MIRRORED[first], low),))
        if second[0] != first[0]:
            raise self._error(f"{first} and {second} in one comparison")
        high = self._value()
        low = _Value(low.number, low.unit or high.unit)
        one, other = self._half_line(name, _MIRRORED[first], low), self._half_line(name, second, high)
        return InRanges(name, absolute, ((max(one[0], other[0]), min(one[1], other[1])),))

    def _file(self) -> Rows:
        compare = self._compare()
        if compare not in ("=", "==", "!="):
            raise self._error('a file is compared like file == "run.mat"')
        named = InFile(self.expect("text", None, 'the name of a file, such as "run.mat"').text[1:-1])
        return Not(named) if compare == "!=" else named

    def _equal(self, name: str, absolute: bool, compare: str) -> Rows:
        if name not in COUNTERS:
            raise self._error(f"{name} is measured and equals no number exactly: write '{name} in 0 +- 1 UNIT'")
        number = self._si(name, self._value())
        found = InRanges(name, absolute, ((number, number),))
        return Not(found) if compare == "!=" else found

    def _half_line(self, name: str, compare: str, value: _Value) -> tuple[float, float]:
        """Return the limits, both included, of the numbers that a comparison accepts."""
        limit = self._si(name, value)
        if compare[0] == "<":
            return -inf, limit if compare == "<=" else nextafter(limit, -inf)
        return limit if compare == ">=" else nextafter(limit, inf), inf

    def _ranges(self, name: str) -> list[tuple[float, float]]:
        closing = {"(": ")", "[": "]"}.get(self.next.text)
        if closing is None:
            return [self._limits(name)]
        self.at += 1
        found = [self._limits(name)]
        while self._take(","):
            found.append(self._limits(name))
        self.expect("operator", closing, f"',' or '{closing}'")
        return found

    def _limits(self, name: str) -> tuple[float, float]:
        """Return the limits of a range or, for a counter, of one number."""
        first = self._value()
        if name in COUNTERS and self.next.text not in ("..", "+-", PLUS_MINUS):
            number = self._si(name, first)
            return number, number
        found = self._range_from(first, name)
        return found.low, found.high

    def range(self, name: str) -> _Range:
        """Return ``a..b`` or ``a +- b``."""
        return self._range_from(self._value(), name)

    def _range_from(self, first: _Value, name: str) -> _Range:
        """Return the range that begins with a value."""
        if self._take(".."):
            last = self._value()
            low, high = self._si(name, _Value(first.number, first.unit or last.unit)), self._si(name, last)
            if low > high:
                raise self._error(f"the range of {name} ends before it begins")
            return _Range(low, high, 0.5 * (low + high), 0.5 * (high - low))
        if not (self._take("+-") or self._take(PLUS_MINUS)):
            raise self._unexpected("a range such as '70..90 kPa' or '220 +- 100 N'")
        width = self._value()
        if width.number < 0.0:
            raise self._error(f"the tolerance {width.number:g} is negative")
        unit = width.unit or first.unit
        # The width of a range of temperatures has no offset.
        tolerance = self._si(name, _Value(width.number, unit)) - self._si(name, _Value(0.0, unit))
        value = self._si(name, _Value(first.number, first.unit or unit))
        return _Range(value - tolerance, value + tolerance, value, tolerance)

    def _quantity(self) -> tuple[str, bool]:
        absolute = self.next.text == "abs"
        if absolute:
            self.at += 1
            self.expect("operator", "(", "'('")
        token = self.next
        if token.kind != "word" or token.text in KEYWORDS:
            raise self._unexpected("a name")
        if token.text not in NAMES:
            meant = intended_channel(token.text)
            known = f"Known are {', '.join(NAMES)}"
            hint = f": did you mean {meant}? {known}" if meant else nearest(token.text, NAMES)
            raise self._error(f"unknown name {quoted(token.text)}{hint}")
        self.at += 1
        if absolute:
            self.expect("operator", ")", "')'")
        return token.text, absolute

    def _compare(self) -> str:
        if self.next.text not in (*_MIRRORED, "=", "==", "!="):
            raise self._unexpected("a comparison (< <= > >= == in)")
        self.at += 1
        return self.tokens[self.at - 1].text

    def _value(self) -> _Value:
        sign = -1.0 if self._take("-") else 1.0
        if sign > 0.0:
            self._take("+")
        number = sign * float(self.expect("number", None, "a number").text)
        if not isfinite(number):
            raise self._error("a number is too large")
        unit = self.next.text if self.next.kind == "word" and self.next.text not in KEYWORDS else None
        self.at += unit is not None
        return _Value(number, unit)

    def _si(self, name: str, value: _Value) -> float:
        if name in COUNTERS:
            if value.unit is not None or value.number != int(value.number):
                raise self._error(f"{name} is compared with whole numbers")
            return value.number
        if value.unit is None:
            return value.number
        try:
            # An effect may have an input that is no channel.
            quantity = CHANNELS[name].quantity if name in CHANNELS else None
            number = float(to_si(value.number, value.unit, quantity))
        except TirefmuError as error:
            raise self._error(f"{name}: {error}") from None
        if not isfinite(number):
            raise self._error("a number is too large")
        return number

    def _take(self, text: str) -> bool:
        taken = self.next.text == text and self.next.kind in ("word", "operator")
        self.at += taken
        return taken

    def expect(self, kind: str, text: str | None, wanted: str) -> Token:
        """Return the next word and advance; raise for another one."""
        token = self.next
        if token.kind != kind or (text is not None and token.text != text):
            raise self._unexpected(wanted)
        self.at += token.kind != "end"
        return token

    def _unexpected(self, wanted: str) -> DataError:
        found = "the end" if self.next.kind == "end" else quoted(self.expression[self.next.at :], 20)
        return self._error(f"{wanted} is expected at {found}")

    def _error(self, reason: str) -> DataError:
        return DataError(f"where {quoted(self.expression)}: {reason}")
