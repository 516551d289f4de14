"""Whether a property file is sound, whether a program accepts it, and which effects that does not evaluate."""

from __future__ import annotations

import re
from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path

from ...boundary.errors import UnknownName, path_from
from ...boundary.escaping import excerpt, quoted, visible
from ...boundary.named_options import named
from ...tires import Tire
from ...tires.description import ignored_coefficients
from ...tires.implausible import Doubt, implausible
from ...tires.property_file.reading import read_tir_with_notes
from .dialects import HOSTS, Dialect, Host
from .lacking import acting, lacked

#: Sections that other readers skip.
OWN = "TIREFMU"


@dataclass(frozen=True, repr=False)
class LintMessage:
    """What a check found.

    - `severity`: "error": the file is not sound, or the host refuses or misreads it. "note": anything else worth
      knowing.
    - `line`: of the file; 0: the file as a whole.
    """

    severity: str
    line: int
    text: str

    def __str__(self) -> str:
        """Return the message in one line.

        >>> print(LintMessage("note", 12, "the unit is not stated"))
        line 12: note: the unit is not stated
        """
        return f"{f'line {self.line}: ' * bool(self.line)}{self.severity}: {self.text}"

    __repr__ = __str__


@dataclass(frozen=True)
class _Entry:
    line: int
    section: str
    key: str
    value: str


@dataclass(frozen=True)
class _Row:
    """A row without a key; `heading` is the line of its section's title."""

    line: int
    section: str
    heading: int


def host_named(name: str) -> Host:
    """Return a host by name, or raise `UnknownName` with the nearest."""
    if name not in HOSTS:
        raise UnknownName("host", name, HOSTS)
    return HOSTS[name]


@named()
def lint(path: str | Path, host: str | None = None) -> list[LintMessage]:
    """Check a property file: whether it is sound, or whether a host accepts it.

    Parameters
    ----------
    path : str or Path
        A .tir file.
    host : str, optional
        One of `tirefmu.applications.exports.dialects.HOSTS`. By default the file itself is checked: values that no tire
        has are errors, and a note states which hosts accept the file.

    Returns
    -------
    list of LintMessage
        Errors first.

    Raises
    ------
    UnknownName
        If there is no such host.
    TirError
        If the file is no property file that tirefmu can read.

    Examples
    --------
    >>> from importlib.resources import files
    >>> path = files("tirefmu.tires.published_tires") / "trento_hoosier.tir"
    >>> [message.text for message in lint(path) if message.severity == "error"]
    []
    >>> [message.text for message in lint(path, "chrono") if message.severity == "error"]
    ['Project Chrono (ChPac02Tire, ChFialaTire) has no mf96: convert with --model mf52']
    """
    read = read_tir_with_notes(path_from(path))
    if host is not None:
        doubts = [LintMessage("note", 0, str(doubt)) for doubt in _doubts(read.tire)]
        return [*host_messages(path, host), *doubts]
    doubts = [LintMessage("error" if doubt.serious else "note", 0, str(doubt)) for doubt in _doubts(read.tire)]
    notes = [LintMessage("error" if note in read.typical else "note", 0, note) for note in read.notes]
    if ignored := ignored_coefficients(read.tire):
        listed = ", ".join(f"{entry['key']} = {entry['value']}" for entry in ignored)
        notes.append(LintMessage("note", 0, f"given but ignored by {read.tire.model}: {excerpt(listed)}"))
    numbers = [*_number_errors(read.tire), *_range_errors(read.tire, "note")]
    messages = [*numbers, *doubts, *notes, LintMessage("note", 0, _accepting(path))]
    return sorted(messages, key=lambda message: message.severity != "error")


def _doubts(tire: Tire) -> list[Doubt]:
    """Return the implausible values of a tire that can be evaluated."""
    return [] if _number_errors(tire) else implausible(tire)


def _accepting(path: str | Path) -> str:
    """Return which hosts accept a file as it is."""
    accepting = [
        host for host in HOSTS if not any(message.severity == "error" for message in host_messages(path, host))
    ]
    others = [host for host in HOSTS if host not in accepting]
    names = ", ".join(accepting) or "none of the known programs"
    return f"accepted as it is by {names}" + (f"; --for {'|'.join(others)} states what others refuse" if others else "")


def host_messages(path: str | Path, host: str) -> list[LintMessage]:
    """Check a property file for a host: errors first. Raises `UnknownName` and `TirError`, as `lint` does."""
    rules, read = host_named(host), read_tir_with_notes(path_from(path))
    tire = read.tire
    if tire.model not in rules.dialects:
        model = next(iter(rules.dialects))
        return [LintMessage("error", 0, f"{rules.title} has no {tire.model}: convert with --model {model}")]
    text = Path(path).read_text(encoding="utf-8", errors="replace")
    entries = _entries(text)
    errors = [*_model_errors(entries, rules.dialects[tire.model]), *_unit_errors(entries, rules)]
    errors += [*_layout_errors(text, rules), *_number_errors(tire), *_range_errors(tire, "error")]
    errors += [*_line_end_errors(path, text, rules), *_table_errors(text, rules)]
    errors += _lacking_errors(entries, tire, lacked(rules, tire.model))
    notes = [*_line_end_notes(path, rules), *lost_effects(tire, rules), *read.disputed, *rules.notes]
    return errors + [LintMessage("note", 0, note) for note in notes]


def lost_effects(tire: Tire, rules: Host, folded: Collection[str] = ()) -> list[str]:
    """Return a sentence for each effect of a tire that a host does not evaluate.

    Added effects in `folded` change coefficients that it evaluates.
    """
    added = {effect.name for effect in tire.symbolic_model.added}
    lost = []
    for name in sorted(tire.has):
        if name in folded:
            lost.append(f"the added effect {name} is folded into the coefficients: its forces at nominal conditions")
        elif name in added:
            lost.append(f"the added effect {name} is not evaluated: the forces are those without it")
        elif name in rules.ignored and any(tire.values[key] != tire.symbolic_model.coefficients[key].neutral
                                           for key in tire.symbolic_model.owned(name)):  # fmt: skip
            lost.append(f"{name} is not evaluated")
    return lost


def _entries(text: str) -> list[_Entry]:
    """Return the entries of a file, without those of tirefmu's own sections."""
    entries, section = [], ""
    for number, line in enumerate(text.splitlines(), 1):
        plain = re.split(r"[$!]", line, maxsplit=1)[0].strip()
        if plain.startswith("["):
            section = plain.strip("[] ").upper()
        elif "=" in plain and not section.startswith(OWN):
            key, _, value = plain.partition("=")
            entries.append(_Entry(number, section, key.strip(), value.strip()))
    return entries


def _model_errors(entries: list[_Entry], dialect: Dialect) -> list[LintMessage]:
    """Check [MODEL] and the required keys."""
    by_key = {entry.key.upper(): entry for entry in entries}
    values = {
        "PROPERTY_FILE_FORMAT": dialect.formats,
        "FITTYP": tuple(map(str, dialect.fittyp)),
        "USE_MODE": tuple(map(str, dialect.use_modes)),
        "FE_METHOD": dialect.fe_methods,
    }
    expected = {key: f": {' or '.join(accepted)} expected" for key, accepted in values.items() if accepted}
    messages = [
        LintMessage("error", 0, f"{key} is missing{expected.get(key, '')}")
        for key in dialect.required
        if key not in by_key
    ]
    for key in [key for key in expected if key in by_key]:
        entry = by_key[key]
        value = entry.value.strip("'\" ").upper()
        number = str(abs(int(float(value)))) if re.fullmatch(r"-?\d+(\.0*)?", value) else value
        if number not in values[key]:
            messages.append(LintMessage("error", entry.line, f"{key} is {quoted(value)}{expected[key]}"))
    return messages


def _lacking_errors(entries: list[_Entry], tire: Tire, lacking: Collection[str]) -> list[LintMessage]:
    """Check coefficients that the host ignores."""
    lines = {entry.key.upper(): entry.line for entry in entries}
    neutral = {key: tire.symbolic_model.coefficients[key].neutral for key in acting(tire, lacking)}
    return [
        LintMessage(
            "error", lines.get(key, 0), f"{key} is {tire.values[key]:g}: the host lacks it, as if it were {value:g}"
        )
        for key, value in neutral.items()
    ]


def _unit_errors(entries: list[_Entry], rules: Host) -> list[LintMessage]:
    messages = []
    for entry in entries:
        accepted = rules.units.get(entry.key.upper()) if entry.section == "UNITS" else None
        value = entry.value.strip("'\" ").upper()
        if accepted and value not in accepted:
            text = f"{entry.key} is {quoted(value)}: {' or '.join(accepted)} expected"
            messages.append(LintMessage("error", entry.line, text))
    return messages


def _layout_errors(text: str, rules: Host) -> list[LintMessage]:
    """Check what simple readers stumble over: long lines, keys in lower case, several entries with one key."""
    messages: list[LintMessage] = []
    seen: dict[tuple[str, str], int] = {}
    # A cut line of tirefmu's own sections, which are last, only adds lines to sections that the host skips.
    begin = text.find(f"\n[{OWN}")
    for number, line in enumerate(text[: begin if begin >= 0 else None].splitlines(), 1):
        if rules.longest_line and len(line) > rules.longest_line:
            messages.append(
                LintMessage("error", number, f"the line has {len(line)} characters: {rules.longest_line} at most")
            )
        if re.search(r"[^\s=]\$", line) and not line.lstrip().startswith(("$", "!")):
            messages.append(LintMessage("error", number, "a comment needs a blank before $"))
    for entry in _entries(text):
        if entry.key != entry.key.upper():
            messages.append(LintMessage("error", entry.line, f"{quoted(entry.key)} is not in capital letters"))
        if not re.match(r"[A-Z_0-9]+$", entry.key.upper()):
            messages.append(LintMessage("error", entry.line, f"{quoted(entry.key)} is no key"))
        first = seen.setdefault((entry.section, entry.key), entry.line)
        if first != entry.line:
            messages.append(LintMessage("error", entry.line, f"{entry.key} is in line {first} already"))
    return messages


def _has_only_lf(path: str | Path) -> bool:
    content = Path(path).read_bytes()
    return b"\n" in content and b"\r" not in content


def _line_end_errors(path: str | Path, text: str, rules: Host) -> list[LintMessage]:
    """Check values, and headings of tables, that lose their last characters to a reader which takes these for CRLF."""
    if not (rules.cuts_lines and _has_only_lf(path)):
        return []
    lines = text.splitlines()
    lost = [(entry.line, entry.key) for entry in _entries(text) if lines[entry.line - 1].endswith(entry.value)]
    headings = {row.heading: f"[{row.section}]" for row in _table_rows(text)}
    lost += [(number, name) for number, name in headings.items() if lines[number - 1].endswith("]")]
    return [
        LintMessage("error", number, f"{name} loses its last characters: the line ends with LF, not with CRLF")
        for number, name in lost
    ]


def _table_errors(text: str, rules: Host) -> list[LintMessage]:
    """Check rows without a key in sections where the host expects keys."""
    rows = {row.section: row for row in reversed(_table_rows(text)) if rules.tables and row.section not in rules.tables}
    return [
        LintMessage("error", row.line, f"a row without '=' in [{visible(row.section)}]: the program stops here")
        for row in rows.values()
    ]


def _table_rows(text: str) -> list[_Row]:
    """Return the rows of a file that are neither entries nor comments."""
    rows, section, heading = [], "", 0
    for number, line in enumerate(text.splitlines(), 1):
        plain = re.split(r"[$!]", line, maxsplit=1)[0].strip()
        if plain.startswith("["):
            section, heading = plain.strip("[] ").upper(), number
        elif plain and "=" not in plain:
            rows.append(_Row(number, section, heading))
    return rows


def _line_end_notes(path: str | Path, rules: Host) -> list[str]:
    if not (rules.expects_crlf and _has_only_lf(path)):
        return []
    return ["lines end with LF; the program's own tools write CRLF: convert the file, or its line ends"]


def _number_errors(tire: Tire) -> list[LintMessage]:
    """Check values that every host uses as a divisor."""
    return [
        LintMessage("error", 0, f"{key} is {tire.values[key]:g}: a positive value expected")
        for key in ("VERTICAL_STIFFNESS", "LONGVL", "NOMPRES")
        if key in tire.values and not tire.values[key] > 0
    ]


def _range_errors(tire: Tire, constant: str) -> list[LintMessage]:
    """Check the limits of ranges; `constant`: severity of a range of one value, such as of the pressure of a test."""
    return [
        LintMessage("error" if low > high else constant, 0, f"the range of {name} is empty: {low:g} to {high:g}")
        for name, (low, high) in tire.ranges.items()
        if not low < high
    ]
