"""Tires as .tir files: complete, in ISO-W and SI, every digit of every value."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from pathlib import Path

from ...boundary.bounded_file import write_whole
from ...boundary.errors import TirError, path_from, writing
from ...boundary.escaping import visible
from ...symbolic.added import effect_text, packaged_library
from ..definition import RANGES, TireDefinition
from .names import (
    ADDED,
    ASSUMED,
    HEADER,
    OWN_RANGES,
    RANGE_SECTIONS,
    assumed_lines,
    in_written_order,
    model_lines,
    not_given,
    silent_coefficients,
    unmeasured_coefficients,
    written_sections,
)
from .text import without_comment
from .units import WRITTEN

#: Comments behind the values of a section that have none of their own.
REMARKS = {
    "MDI_HEADER": "this file", "UNITS": "of every value", "MODEL": "of the model", "": "entry without description",
} | {title: "valid range" for title, _ in RANGE_SECTIONS.values()}  # fmt: skip


def write_tir(tire: TireDefinition, path: str | Path, *, line_end: str = "\n") -> None:
    """Write a tire as a .tir file, completely or not at all.

    Parameters
    ----------
    tire : TireDefinition
        In any signs; it is written in ISO-W.
    path : str or Path
        The file to write; an existing one is replaced.
    line_end : str
        CRLF for readers that expect it.

    Raises
    ------
    TirError
        If the file cannot be written.
    """
    path = path_from(path)
    text = tir_text(tire).replace("\n", line_end)
    with writing(path, TirError):
        write_whole(path, text.encode())


def tir_text(tire: TireDefinition) -> str:
    """Return the text of a tire's .tir file.

    Returns: other entries of the file that the tire was read from are in their former sections. Information that only
    tirefmu uses is at the end, in sections [TIREFMU...], which other readers skip.

    >>> from tirefmu.tires import published
    >>> tir_text(published("trento_hoosier")).splitlines()[0]
    '[MDI_HEADER]'
    """
    tire = tire.in_signs("iso")
    entries = [line for line in in_written_order(tire.other_entries, tire.symbolic_model) if line[0] != ASSUMED]
    replaced = {(section, key) for section, key, _ in entries if key}
    sections: dict[str, list[str]] = {title: [] for title in ("", *written_sections(tire.symbolic_model))}
    for section, key, line in _own_lines(tire):
        if (section, key) not in replaced:
            sections[section].append(_with_comment(section, line))
    for section, key, value in entries:
        line = _with_comment(section, f"{key} = {value}") if key else value
        sections.setdefault(section, []).append(line)
    lines = sections.pop("")
    for title, content in sections.items():
        lines += ["", _heading(title, content), *content] if content else []
    lines += ["", "$ What follows is tirefmu's own; other readers skip it.", *_only_here(tire)]
    return "\n".join(lines[not lines[0] :]) + "\n"


def _heading(title: str, content: Sequence[str]) -> str:
    """Return the first line of a section; that of a table ends with a blank: the same readers skip [SHAPE]."""
    return f"[{title}]" + " " * any("=" not in line for line in content)


def _with_comment(section: str, line: str) -> str:
    """Return an entry with a comment behind its value: readers that expect CRLF cut off the end of other lines."""
    return f"{line}  $ {REMARKS.get(section, REMARKS[''])}" if without_comment(line) == line else line


def _own_lines(tire: TireDefinition) -> Iterable[tuple[str, str, str]]:
    """Yield section, key and line of all entries that other programs read."""
    model = tire.symbolic_model
    yield from (("MDI_HEADER", key, f"{key} = {value}") for key, value in HEADER.items())
    yield from (("UNITS", key, f"{key} = '{unit}'") for key, unit in WRITTEN.items())
    yield from (("MODEL", key, f"{key} = {value}") for key, value in model_lines(model).items())
    if tire.side:
        yield "MODEL", "TYRESIDE", f"TYRESIDE = '{tire.side.upper()}'"
    values = tire.parameters()[: len(model.coefficients)].tolist()  # options are not properties of a tire
    written = dict(zip(model.coefficients, values, strict=True))
    silent, unmeasured = silent_coefficients(tire), unmeasured_coefficients(tire)
    for section in model.sections:
        for name, declaration in section.coefficients.items():
            if name in written and name not in silent:
                yield (
                    section.title,
                    name,
                    f"{name} = {written[name]!r}  $ {visible(f'{declaration.description} [{declaration.unit}]')}"
                    + ", not measured" * (name in unmeasured),
                )
    for name, (title, _) in RANGE_SECTIONS.items():
        for key, bound in zip(RANGES[name], tire.ranges.get(name, ()), strict=False):
            if key not in written:
                yield title, key, f"{key} = {bound!r}"


def _only_here(tire: TireDefinition) -> list[str]:
    """Return the lines with information that a .tir file cannot state otherwise."""
    entries = {"TIREFMU_MODEL": f"'{tire.model}'", "NAME": _quoted(tire.name)}
    absent = [effect for name, effect in tire.symbolic_model.effects.items() if name not in tire.has]
    if tire.has != tire.symbolic_model.default_effects:
        entries["EFFECTS"] = f"'{','.join(name for name in tire.symbolic_model.effects if name in tire.has)}'"
    # An absent effect may rescale a coefficient for other readers; its own value is stored here with every digit.
    entries |= {f"CORE_{name}": repr(tire.values[name]) for effect in absent for name, _ in effect.rescales}
    own_files = [effect for effect in tire.added if packaged_library().get(effect.name) != effect]
    ranges = {key: tire.ranges[name] for name, key in OWN_RANGES.items() if name in tire.ranges}
    assumed = {key: text for _, key, text in assumed_lines(not_given(tire), tire.symbolic_model)}
    return [
        "[TIREFMU]",
        *(f"{key} = {value}" for key, value in entries.items()),
        *_section(ADDED, {effect.name.upper(): _quoted(effect_text(effect)) for effect in own_files}),
        *_section("TIREFMU_ABOUT", {key.upper(): _quoted(str(value)) for key, value in tire.about.items()}),
        *_section("TIREFMU_RANGES", {key: f"'{low!r},{high!r}'" for key, (low, high) in ranges.items()}),
        *_section(ASSUMED, assumed),
    ]


def _section(title: str, values: dict[str, str]) -> list[str]:
    return ["", f"[{title}]", *(f"{key} = {value}" for key, value in values.items())] if values else []


def _quoted(text: str) -> str:
    """Return a text of tirefmu's sections on one line, without a character that starts a comment or ends a quote."""
    if text.isprintable() and not set(text) & set("'\"$!\\"):
        return f"'{text}'"
    inner = json.dumps(text)[1:-1].replace('\\"', "\\u0022")
    for sign in "'$!":
        inner = inner.replace(sign, f"\\u{ord(sign):04x}")
    return f'"{inner}"'
