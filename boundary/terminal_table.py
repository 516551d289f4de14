"""Tables of the terminal, whose cells are printable texts of limited length."""

from __future__ import annotations

from rich.console import JustifyMethod, RenderableType
from rich.style import StyleType
from rich.table import Table

from .escaping import excerpt, visible

#: Columns of text; the others contain numbers.
WORDS = {
    "coefficient", "unit", "description", "problem", "stage", "recording", "channel", "constraint", "at", "",
    "force", "first", "second", "mean difference at", "largest error",
    "taken for", "evidence", "why", "unit from", "held at", "swept", "input", "speed in", "numbers", "reason",
    "effect", "kind", "models", "model", "inputs", "outputs", "tire", "bounds",
}  # fmt: skip
#: The longest text in a cell, in characters.
LONGEST_CELL = 200
#: Lengths of an interval and of a name up to which they do not fold.
NUMBER, NAME = 20, 8


class PlainTable(Table):
    """A table whose cells are printable text of limited length."""

    def add_row(self, *cells: RenderableType | None, style: StyleType | None = None, end_section: bool = False) -> None:
        """Add a row; see rich. Numbers and short names remain on one line; longer texts fold."""
        shown = [excerpt(cell, LONGEST_CELL) if isinstance(cell, str) else cell for cell in cells]
        for column, cell in zip(self.columns, shown, strict=False):
            most = NUMBER if column.justify == "right" else NAME
            column.min_width = max(column.min_width or 0, min(len(str(cell)), most))
        super().add_row(*shown, style=style, end_section=end_section)


def plain_table(*columns: str, title: str = "", caption: str = "") -> Table:
    """Return a table without rules, `caption` below it; numbers are right-aligned."""
    title = visible(title)
    table = PlainTable(title=title or None, title_justify="left", box=None, pad_edge=False, header_style="bold")
    table.caption, table.caption_justify = caption or None, "left"
    for column in columns:
        longest = max(map(len, column.split()), default=0)
        justify: JustifyMethod = "left" if column in WORDS else "right"
        table.add_column(column, justify=justify, overflow="fold", min_width=longest)
    return table
