"""Tables of the terminal, whose cells are printable texts of limited length."""

from __future__ import annotations

from rich.console import JustifyMethod, RenderableType
from rich.style import StyleType
from rich.table import Table

from .escaping import excerpt, shortened, visible

#: Columns of text; the others contain numbers.
WORDS = {
    "coefficient", "unit", "description", "problem", "stage", "recording", "channel", "constraint", "at", "",
    "force", "first", "second", "mean difference at", "largest error",
    "taken for", "evidence", "why", "unit from", "held at", "swept", "input", "speed in", "numbers", "reason",
    "effect", "kind", "models", "model", "inputs", "outputs", "tire", "bounds",
}  # fmt: skip
#: The longest text in a cell, in characters.
LONGEST_CELL = 200
#: Lengths of an interval and of a word up to which they are not broken, and the longest name of a recording.
NUMBER, WORD, NAME = 20, 16, 24


class PlainTable(Table):
    """A table whose cells are printable text of limited length."""

    def add_row(self, *cells: RenderableType | None, style: StyleType | None = None, end_section: bool = False) -> None:
        """Add a row; see rich. Numbers and words are not broken; a long name of a recording is shortened."""
        shown = [excerpt(cell, LONGEST_CELL) if isinstance(cell, str) else cell for cell in cells]
        for number, column in enumerate(self.columns[: len(shown)]):
            cell = str(shown[number])
            if column.header == "recording":
                shown[number] = cell = shortened(cell, NAME)
                whole = len(cell)
            else:
                whole = min(len(cell), NUMBER) if column.justify == "right" else min(_longest_word(cell), WORD)
            column.min_width = max(column.min_width or 0, whole)
        super().add_row(*shown, style=style, end_section=end_section)


def _longest_word(text: str) -> int:
    return max(map(len, text.split()), default=0)


def plain_table(*columns: str, title: str = "", caption: str = "") -> Table:
    """Return a table without rules, `caption` below it; numbers are right-aligned."""
    title = visible(title)
    table = PlainTable(title=title or None, title_justify="left", box=None, pad_edge=False, header_style="bold")
    table.caption, table.caption_justify = caption or None, "left"
    for column in columns:
        justify: JustifyMethod = "left" if column in WORDS else "right"
        table.add_column(column, justify=justify, overflow="fold", min_width=_longest_word(column))
    return table
