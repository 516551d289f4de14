"""Short HTML for notebooks: a title and small tables, in which every text is escaped."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from html import escape

from ..boundary.escaping import excerpt

#: The longest text of a cell, in characters.
LONGEST = 200


def html_text(text: object) -> str:
    r"""Return a text as HTML: on one line, escaped, characters that are not printable made visible.

    >>> html_text("<b>\x1b[2J & co")
    '&lt;b&gt;\\x1b[2J &amp; co'
    """
    return escape(excerpt(str(text), LONGEST))


def html_table(header: Sequence[object], rows: Iterable[Sequence[object]]) -> str:
    """Return a table; numbers are written with five digits, texts are escaped.

    `header`: empty for a table without one.

    >>> html_table(["name", "value"], [("PDY1", 1.30000001)])
    '<table><tr><th>name</th><th>value</th></tr><tr><td>PDY1</td><td style="text-align:right">1.3</td></tr></table>'
    """
    cells = ["".join(f"<th>{html_text(cell)}</th>" for cell in header)] if header else []
    cells += ["".join(map(_cell, row)) for row in rows]
    return f"<table>{''.join(f'<tr>{row}</tr>' for row in cells)}</table>"


def html_summary(text: str, *parts: str) -> str:
    r"""Return the lines of a plain summary as HTML, the first one bold, and further parts that are already HTML.

    >>> html_summary("Tire <x>\nmf61", "<table></table>")
    '<p><b>Tire &lt;x&gt;</b><br>mf61</p><table></table>'
    """
    first, *more = (html_text(line) for line in text.split("\n"))
    return f"<p>{'<br>'.join([f'<b>{first}</b>', *more])}</p>{''.join(parts)}"


def html_details(title: str, part: str) -> str:
    """Return a part that opens on a click; the part is already HTML.

    >>> html_details("Coefficients", "<table></table>")
    '<details><summary>Coefficients</summary><table></table></details>'
    """
    return f"<details><summary>{html_text(title)}</summary>{part}</details>"


def _cell(value: object) -> str:
    if isinstance(value, float):
        return f'<td style="text-align:right">{value:.5g}</td>'
    return f"<td>{html_text(value)}</td>"
