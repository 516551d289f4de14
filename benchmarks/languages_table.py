"""The table of docs/languages.md: largest differences by language and model; a run replaces what it computed."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path

PAGE = Path(__file__).parents[1] / "docs" / "languages.md"
BEGIN, END = "<!-- table of make bench-languages -->\n", "<!-- end of the table -->\n"
#: The functions behind each of the numbers of a cell.
NUMBERS = {
    "values": ("forces", "quantities"),
    "Jacobian": ("jacobian_inputs", "jacobian_parameters"),
    "states": ("states",),
}

#: The cell of a language that was not installed where the table was written.
NOT_INSTALLED = "not run (2)"

#: By language and model.
Cells = Mapping[tuple[str, str], str]


def cell(differences: Mapping[str, list[float]], remark: str = "") -> str:
    """Return the text of a cell.

    `differences`: by function, the largest differences of the printouts with values in the lines and with coefficients.
    `remark`: how the run differs from the others.

    >>> cell({"forces": [1e-15, 2e-15], "jacobian_inputs": [3e-14], "states": []}, "40 rows")
    '2e-15, 3e-14, - (40 rows)'
    """
    parts = []
    for functions in NUMBERS.values():
        found = [difference for name in functions for difference in differences.get(name, [])]
        parts.append(f"{max(found):.0e}" if found else "-")
    return ", ".join(parts) + (f" ({remark})" if remark else "")


def stored(page: str) -> dict[tuple[str, str], str]:
    """Return the cells in the text of the page.

    >>> stored(table({("c", "mf96"): "1e-15, 2e-15, -"}))
    {('c', 'mf96'): '1e-15, 2e-15, -'}
    """
    lines = re.findall(r"^\| (.*) \|$", page.split(BEGIN)[1].split(END)[0], re.MULTILINE)
    head, *rows = [line.split(" | ") for line in lines]
    return {(row[0], model): text for row in rows for model, text in zip(head[1:], row[1:], strict=True)}


def table(cells: Cells) -> str:
    """Return the table between its marks; languages and models have the order in which they occur first."""
    languages, models = (list(dict.fromkeys(key[i] for key in cells)) for i in (0, 1))
    rows = [["language", *models]]
    rows += [[name, *(cells.get((name, model), NOT_INSTALLED) for model in models)] for name in languages]
    text = [f"| {' | '.join(row)} |\n" for row in rows]
    return "".join([BEGIN, text[0], f"|{'---|' * len(rows[0])}\n", *text[1:], END])


def update(cells: Cells) -> None:
    """Write cells into the page; the others stay."""
    page = PAGE.read_text(encoding="utf-8")
    before, rest = page.split(BEGIN)
    after = rest.split(END)[1]
    PAGE.write_text(f"{before}{table({**stored(page), **cells})}{after}", encoding="utf-8")
