"""The words of a selection: numbers, names and units, texts, operators."""

from __future__ import annotations

import re
from dataclasses import dataclass

from tirefmu.symbolic.errors import DataError
from tirefmu.symbolic.escaping import excerpt

#: Characters of an expression. Those of the Trento report have fewer than 200.
LONGEST_EXPRESSION = 10_000
#: Characters of the rest of an expression that a message quotes.
QUOTED = 40
KEYWORDS = ("and", "or", "not", "in")
_TOKEN = re.compile(
    r"""\s*(?:(?P<comment>\#[^\n]*)
      |(?P<number>(?:\d+(?:\.(?!\.)\d*)?|\.\d+)(?:[eE][-+]?\d+)?)(?!\w*/m\b)
      |(?P<word>deg\ [CF]\b|1/m\b|%|[^\W\d]\w*(?:/[^\W\d]\w*)?)
      |(?P<text>"[^"\n]*"|'[^'\n]*')
      |(?P<operator>\.\.|\+-|<=|>=|==|!=|[-+<>=()\[\],\u00b1]))""",
    re.VERBOSE,
)


@dataclass(frozen=True)
class Token:
    """A word of an expression.

    Parameters
    ----------
    kind : str
        "number", "word" (a name, a unit or a keyword), "text", "operator", or "end".
    text : str
    at : int
        Index of the first character.
    """

    kind: str
    text: str
    at: int


def tokens(expression: str) -> list[Token]:
    """Return the words of an expression, and the end.

    Parameters
    ----------
    expression : str
        Lines may end in a comment after ``#``.

    Returns
    -------
    list of Token

    Raises
    ------
    DataError
        If the expression is too long, or a character has no meaning.

    Examples
    --------
    >>> [token.text for token in tokens("p in 70..90 kPa")]
    ['p', 'in', '70', '..', '90', 'kPa', '']
    """
    if len(expression) > LONGEST_EXPRESSION:
        raise DataError(f"where: {len(expression)} characters: at most {LONGEST_EXPRESSION} are read")
    found, at = [], 0
    while expression[at:].strip():
        match = _TOKEN.match(expression, at)
        if match is None or match.lastgroup is None:
            raise DataError(f"where {quoted(expression)}: {quoted(expression[at:].strip(), 10)} has no meaning here")
        if match.lastgroup != "comment":
            found.append(Token(match.lastgroup, match[match.lastgroup], match.start(match.lastgroup)))
        at = match.end()
    return [*found, Token("end", "", len(expression))]


def quoted(text: str, most: int = QUOTED) -> str:
    """Return the beginning of a text in quotation marks, on one line."""
    return repr(excerpt(" ".join(text.split()), most))
