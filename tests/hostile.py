"""Texts with a meaning in a terminal, a page, a plot or a path; each may occur in any text of a file."""

from __future__ import annotations

import unicodedata
from html.parser import HTMLParser

from .relatives import slow_but

HOSTILE = (
    "\x1b[2J\x1b[31mred\x07\x9b0m",
    "\x1b]8;;http://example.com\x1b\\link\x1b]8;;\x1b\\",
    "[bold]x[/bold][link=http://example.com]y[/] :bomb:",
    "one\ntwo\rthree\x0b\x0c\x85\u2028\u2029four",
    "evil\u202egnp.exe\u2066\u200e\u200b\ufeff",
    "<script>alert(1)</script>",
    "\"'><img src=x onerror=alert(1)><!-- ]]> </style></title></script>",
    "{{ 7 * 7 }}{% raw %}&lt;&#0;",
    r"$\frac{$ $$ \$ % \notacommand{",
    "../../etc/passwd\\..\\con.txt\x00|;$(touch ran)`touch ran`",
    "=1+1 -- \udc80\ud800 \U0001f525 e\u0301\u0336",
    "x" * 5000,
)
#: Where drawing a text takes long: those with a meaning in a page and in a terminal or a plot.
EACH_PAGE = slow_but(HOSTILE[:1] + HOSTILE[6:7] + HOSTILE[8:9], HOSTILE)


def is_plain(text: str) -> bool:
    """Return whether a text is safe for a terminal: every character except line feeds is printable."""
    return all(character == "\n" or character.isprintable() for character in text) and not any(
        unicodedata.bidirectional(character) in ("RLO", "LRO", "RLE", "LRE", "PDF", "RLI", "LRI", "FSI", "PDI")
        for character in text
    )


class Skeleton(HTMLParser):
    """Elements and names of attributes of a page, in order, and everything that is not text of tirefmu or of a file."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.parts: list[tuple[str, ...]] = []
        self.text = ""
        self.feed(page)
        self.close()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.parts.append((tag, *(name for name, _ in attrs)))

    def handle_endtag(self, tag: str) -> None:
        self.parts.append((f"/{tag}",))

    def handle_comment(self, data: str) -> None:
        self.parts.append(("comment", data))

    def handle_data(self, data: str) -> None:
        self.text += data
