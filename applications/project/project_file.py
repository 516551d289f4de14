"""The project file ``tirefmu.toml``: its sections and keys, read and written."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from ...boundary.bounded_file import toml_file
from ...boundary.errors import TirefmuError
from ...boundary.escaping import toml_string
from ...boundary.json_schema import document, object_schema, one_of
from ...boundary.schema_check import check_content
from ...fitting.options import VERSIONS, declared_options
from ...measurements.files.formats import DEFAULT_SIGNS
from ...symbolic.printers.languages import LANGUAGES
from ..exports.dialects import HOSTS

#: Default time limit of a diagnosis, seconds. Judgement: longer than all other steps of a measured recording together.
TIME_LIMIT = 900.0
_TEXT: dict[str, Any] = {"type": "string"}
_TEXTS: dict[str, Any] = {"type": "array", "items": _TEXT}
_NUMBERS: dict[str, Any] = {"type": "object", "additionalProperties": {"type": "number"}}
#: Kinds of values and the JSON Schemas of their values.
KINDS: dict[str, dict[str, Any]] = {
    "text": _TEXT,
    "file": _TEXT,
    "name or file": _TEXT,
    "files": _TEXTS,
    "names": _TEXTS,
    "number": {"type": "number"},
    "integer": {"type": "integer"},
    "pairs": {**_NUMBERS, "examples": [{"Fz0": 1000.0, "R0": 0.25}]},
    "weights": {**_NUMBERS, "examples": [{"Fz in 200..240 N": 2.0}]},
    "texts": {"type": "object", "additionalProperties": _TEXT, "examples": [{"Fy": "FYC", "alpha": "-SA"}]},
    "flag": {"type": "boolean"},
}


@dataclass(frozen=True)
class Key:
    """A key of the project file: the kind of its value, and the option of the command that takes it, or its meaning.

    An option of a flag is given if the value is false.

    `limits`: further keywords of the JSON Schema of its value.
    """

    kind: str
    option: str = ""
    meaning: str = ""
    limits: Mapping[str, Any] = field(default_factory=dict)

    @property
    def schema(self) -> dict[str, Any]:
        """The JSON Schema of its value."""
        return {**KINDS[self.kind], **({"description": self.meaning} if self.meaning else {}), **self.limits}


#: The keys of each section. Options are those of the command with the name of the section; those of [data] are options
#: of all commands that read tables.
SECTIONS: dict[str, dict[str, Key]] = {
    "data": {
        "tables": Key("files", meaning="Bench files.", limits={"minItems": 1}),
        "signs": Key("text", "--signs"),
        "where": Key("name or file", meaning="Rows to use: an expression, or a file with one (.where, .txt)."),
        "columns": Key("texts", "--columns"),
        "units": Key("texts", "--units"),
        "exclude": Key("names", meaning="Rows that no step uses: expressions."),
    },
    "fit": {
        "model": Key("text", "--model"),
        "start": Key("name or file", "--start"),
        **{name: Key(option.kind, option.flag) for name, (option, _) in declared_options("project").items()},
        "cross_validate": Key("number", "--cross-validate"),
        "hold_out": Key("names", meaning="Rows that are checked but not fitted: expressions."),
    },
    "export": {
        "fmi": Key("text", "--fmi"),
        "inputs": Key("text", "--inputs"),
        "axes": Key("text", "--axes"),
        "platforms": Key("text", "--platforms"),
        "kind": Key("text", "--kind"),
        "proof": Key("name or file", "--proof"),
        "convert": Key(
            "names", meaning="Programs for which property files are written.", limits={"items": one_of(HOSTS)}
        ),
        "generate": Key("names", meaning="Languages in which code is written.", limits={"items": one_of(LANGUAGES)}),
    },
    "check": {"tolerance": Key("number", "--tolerance")},
    "diagnose": {
        "run": Key("flag", meaning="Whether recordings are diagnosed."),
        "tables": Key("files", meaning="Recordings to diagnose (default: all)."),
        "candidates": Key("names", "--candidates"),
        "time_limit": Key("number", meaning="Of each recording, s.", limits={"exclusiveMinimum": 0.0}),
    },
    "output": {"folder": Key("file", meaning="Folder of the results.")},
}


@dataclass(frozen=True)
class Project:
    """A project.

    - `path`: of the file.
    - `sections`: the given values; paths are relative to the folder of the file.
    """

    path: Path
    sections: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)

    def get(self, section: str, key: str, default: Any = None) -> Any:
        """Return a value, or a default."""
        return self.sections.get(section, {}).get(key, default)

    def located(self, name: str) -> Path:
        """Return a path of the file as seen from the current folder."""
        return self.path.parent / name

    @property
    def tables(self) -> tuple[Path, ...]:
        """The tables of the fit and the checks."""
        return tuple(map(self.located, self.get("data", "tables", ())))

    @property
    def diagnosed(self) -> tuple[Path, ...]:
        """The tables of the diagnosis: all, unless the file has a list of its own or none is diagnosed."""
        if not self.get("diagnose", "run", True):
            return ()
        listed = self.get("diagnose", "tables")
        return self.tables if listed is None else tuple(map(self.located, listed))

    @property
    def time_limit(self) -> float:
        """The time limit of each diagnosis, seconds."""
        return float(self.get("diagnose", "time_limit", TIME_LIMIT))

    @property
    def folder(self) -> Path:
        """The folder of all results."""
        return self.located(self.get("output", "folder", "results"))

    def rows(self, *, fitted: bool = False) -> str | None:
        """Return the expression or file that selects the rows of all steps; None for all rows.

        `fitted`: that of the fit, without the hold-out set.
        """
        where = self.get("data", "where")
        excluded = [*self.get("data", "exclude", ()), *(self.get("fit", "hold_out", ()) if fitted else ())]
        if not excluded:
            return None if where is None else self._argument("name or file", where)
        from ...measurements.row_selection.selected import expression_of  # loads NumPy

        # An expression may end in a comment.
        included = [] if where is None else [f"({expression_of(self._argument('name or file', where))}\n)"]
        return " and ".join([*included, *(f"not ({expression})" for expression in excluded)])

    def data_options(self, *, fitted: bool = False) -> list[str]:
        """Return the options of a command that reads the tables; `fitted` as for `rows`."""
        rows = self.rows(fitted=fitted)
        return self.options("data") + ([] if rows is None else ["--where", rows])

    def options(self, section: str) -> list[str]:
        """Return the options of a command: those of a section that the file has."""
        options: list[str] = []
        for name, key in SECTIONS[section].items():
            value = self.get(section, name)
            if key.kind == "weights" and value is not None:
                options += [
                    part for expression, factor in value.items() for part in (key.option, f"{factor!r}: {expression}")
                ]
            elif key.kind == "flag" and key.option:
                options += [] if value in (None, True) else [key.option]
            elif key.option and value is not None:
                options += [key.option, self._argument(key.kind, value)]
        return options

    def files_of(self, section: str) -> list[Path]:
        """Return the files, other than tables, that a section names and that exist."""
        named = [self.get(section, name) for name, key in SECTIONS[section].items() if key.kind == "name or file"]
        return [self.located(name) for name in named if name is not None and self._is_file(name)]

    def _argument(self, kind: str, value: Any) -> str:
        if kind == "names":
            return ",".join(value) or "none"
        if kind == "pairs":
            return ",".join(f"{name}={number!r}" for name, number in value.items())
        if kind == "texts":
            return ",".join(f"{name}={text}" for name, text in value.items())
        if kind == "name or file" and self._is_file(value):
            return str(self.located(value))
        return str(value)

    def _is_file(self, name: str) -> bool:
        try:
            return self.located(name).is_file()
        except (OSError, ValueError):  # an expression is too long for a name, or has a character that no name has
            return False


def read_project(path: Path) -> Project:
    """Read a project file.

    Raises `TirefmuError` if it cannot be read, is not TOML, has no tables, an unknown key or an invalid value.
    """
    return checked_project(path, toml_file(path, TirefmuError))


def checked_project(path: Path, content: Mapping[str, Any], *, empty: bool = False) -> Project:
    """Return the project for the content of a project file.

    `empty`: whether it may be without tables. Raises as `read_project`.
    """
    check_content(content, project_schema(empty=empty), str(path), TirefmuError)
    return Project(path, content)


def project_schema(
    facts: Callable[[str, str], Mapping[str, Any]] = lambda section, option: {}, *, empty: bool = False
) -> dict[str, Any]:
    """Return the JSON Schema of a project file.

    `facts`: returns further keywords of the schema, such as the description, of an option of a section. `empty`:
    whether a project may be without tables.
    """
    sections: dict[str, Any] = {
        section: object_schema(
            {name: {**key.schema, **(facts(section, key.option) if key.option else {})} for name, key in keys.items()}
        )
        for section, keys in SECTIONS.items()
    }
    if empty:
        sections["data"]["properties"]["tables"]["minItems"] = 0
    else:
        sections["data"]["required"] = ["tables"]
    return document("project", VERSIONS["project"], "Project", object_schema(sections, [] if empty else ["data"]))


def project_text(
    tables: Sequence[str], model: str, nominal: Mapping[str, float], effects: Sequence[str] | None, signs: str | None
) -> str:
    """Return the text of a new project file, with remarks for what may be added.

    >>> print(project_text(["run.csv"], "mf61", {"Fz0": 1000.0}, None, None).splitlines()[2])
    tables = ["run.csv"]
    """
    listed = ", ".join(map(toml_string, tables))
    values = ", ".join(f"{name} = {value!r}" for name, value in nominal.items())
    chosen = None if effects is None else ", ".join(map(toml_string, effects))
    lines = [
        "# tirefmu run: inspects the data, fits, exports, checks, diagnoses; redoes what has changed.",
        "[data]",
        f"tables = [{listed}]",
        f"signs = {toml_string(signs)}" if signs else f'# signs = "sae"  # default: {DEFAULT_SIGNS}',
        '# where = "t > 120 and p in 70..90 kPa"',
        '# columns = {Fy = "FYC"}  # and units = {Fz = "lbf"}, where headers differ',
        "",
        "[fit]",
        f"model = {toml_string(model)}",
        f"nominal = {{{values}}}" if nominal else "# nominal = {Fz0 = 1000.0, R0 = 0.25, p0 = 80000.0}  # N, m, Pa",
        f"effects = [{chosen}]"
        if chosen is not None
        else '# effects = ["load_friction"]  # tirefmu effects lists them',
        '# recipe = "progressive"',
        '# constraints = ["extrapolation"]',
        "",
        "[export]",
        'inputs = "slip"  # or "wheel", "hub", "hub-torque"',
        '# fmi = "3"',
        '# platforms = "all"',
        '# convert = ["adams"]  # property files; generate = ["cpp"]: code',
        '# proof = "none"  # or a table; by default the first one, whose inputs become part of the FMU',
        "",
        "[check]",
        "# tolerance = 0.05  # share of the largest value of a channel",
        "",
        "[diagnose]",
        "run = true",
        f"# time_limit = {TIME_LIMIT:g}  # s, of each recording",
        "",
        "[output]",
        'folder = "results"',
    ]
    return "\n".join(lines) + "\n"
