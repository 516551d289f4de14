"""The project file ``tirefmu.toml``: its sections and keys, read and written."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from tirefmu.boundary.bounded_file import toml_file
from tirefmu.boundary.errors import TirefmuError, UnknownName
from tirefmu.boundary.escaping import quoted, toml_string
from tirefmu.boundary.json_schema import document, is_of, object_schema, schema_of
from tirefmu.hosts.dialects import HOSTS
from tirefmu.measurements.files.formats import DEFAULT_SIGNS
from tirefmu.symbolic.printers.languages import LANGUAGES

#: Default time limit of a diagnosis, seconds. Judgement: longer than all other steps of a measured recording together.
TIME_LIMIT = 900.0
#: Kinds of values, as a message names them.
KINDS = {
    "text": "a text",
    "file": "the path of a file",
    "name or file": "a name, or the path of a file",
    "files": "a list of paths",
    "names": "a list of names",
    "number": "a number",
    "pairs": "a table of numbers, such as {Fz0 = 1000.0, R0 = 0.25}",
    "weights": 'a table of expressions and numbers, such as {"Fz in 200..240 N" = 2.0}',
    "texts": 'a table of texts, such as {Fy = "FYC", alpha = "-SA"}',
    "flag": "true or false",
}
#: Types of values; those of other kinds are texts.
TYPES: dict[str, Any] = {
    "files": list[str], "names": list[str], "number": float, "pairs": dict[str, float],
    "weights": dict[str, float], "texts": dict[str, str], "flag": bool,
}  # fmt: skip


@dataclass(frozen=True)
class Key:
    """A key of the project file: the kind of its value, and the option of the command that takes it, or its meaning.

    `names`: the possible names of a list; empty if they depend on other values.
    """

    kind: str
    option: str = ""
    meaning: str = ""
    names: Collection[str] = ()

    @property
    def type(self) -> Any:
        """The type of its value."""
        return TYPES.get(self.kind, str)


#: The keys of each section. Options are those of the command with the name of the section; those of [data] are options
#: of all commands that read tables.
SECTIONS: dict[str, dict[str, Key]] = {
    "data": {
        "tables": Key("files", meaning="Bench files."),
        "signs": Key("text", "--signs"),
        "where": Key("name or file", meaning="Rows to use: an expression, or a file with one (.where, .txt)."),
        "columns": Key("texts", "--columns"),
        "units": Key("texts", "--units"),
        "exclude": Key("names", meaning="Rows that no step uses: expressions."),
    },
    "fit": {
        "model": Key("text", "--model"),
        "nominal": Key("pairs", "--nominal"),
        "effects": Key("names", "--effects"),
        "without": Key("names", "--without"),
        "start": Key("name or file", "--start"),
        "recipe": Key("name or file", "--recipe"),
        "constraints": Key("names", "--constraint"),
        "without_constraints": Key("names", "--without-constraint"),
        "loss": Key("text", "--loss"),
        "rows": Key("text", "--rows"),
        "weights": Key("weights", "--weight"),
        "fixed": Key("pairs", "--fix"),
        "stiffness_weight": Key("number", "--stiffness-weight"),
        "temperature": Key("text", "--temperature"),
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
        "convert": Key("names", meaning="Programs for which property files are written.", names=tuple(HOSTS)),
        "generate": Key("names", meaning="Languages in which code is written.", names=tuple(LANGUAGES)),
    },
    "check": {"tolerance": Key("number", "--tolerance")},
    "diagnose": {
        "run": Key("flag", meaning="Whether recordings are diagnosed."),
        "tables": Key("files", meaning="Recordings to diagnose (default: all)."),
        "candidates": Key("names", "--candidates"),
        "time_limit": Key("number", meaning="Of each recording, s."),
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
        own = self.get("diagnose", "tables")
        return self.tables if own is None else tuple(map(self.located, own))

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

        `fitted`: that of the fit, without the rows that are held out.
        """
        where = self.get("data", "where")
        excluded = [*self.get("data", "exclude", ()), *(self.get("fit", "hold_out", ()) if fitted else ())]
        if not excluded:
            return None if where is None else self._argument("name or file", where)
        from tirefmu.measurements.row_selection.selected import expression_of  # loads NumPy

        # An expression may end in a comment.
        included = [] if where is None else [f"({expression_of(self._argument('name or file', where))}\n)"]
        return " and ".join([*included, *(f"not ({each})" for each in excluded)])

    def data_options(self, *, fitted: bool = False) -> list[str]:
        """Return the options of a command that reads the tables; `fitted` as for `rows`."""
        rows = self.rows(fitted=fitted)
        return self.options("data") + ([] if rows is None else ["--where", rows])

    def options(self, section: str) -> list[str]:
        """Return the options of a command: those of a section that the file has."""
        found: list[str] = []
        for name, key in SECTIONS[section].items():
            value = self.get(section, name)
            if key.kind == "weights" and value is not None:
                found += [part for each, factor in value.items() for part in (key.option, f"{factor!r}: {each}")]
            elif key.option and value is not None:
                found += [key.option, self._argument(key.kind, value)]
        return found

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

    Raises `TirefmuError` if it cannot be read, is not TOML, or has no tables. Raises `UnknownName` if a section or a
    key does not exist.
    """
    return checked_project(path, toml_file(path, TirefmuError))


def checked_project(path: Path, content: Mapping[str, Any], *, empty: bool = False) -> Project:
    """Return the project for the content of a project file.

    `empty`: whether it may be without tables. Raises as `read_project`.
    """
    for section, keys in content.items():
        if section not in SECTIONS:
            raise UnknownName(f"section of {path}", section, SECTIONS)
        if not isinstance(keys, dict):
            raise TirefmuError(f"{path}: {section} is a section: [{section}]")
        for name, value in keys.items():
            if name not in SECTIONS[section]:
                raise UnknownName(f"key of [{section}] of {path}", name, SECTIONS[section])
            if not is_of(value, SECTIONS[section][name].type):
                kind = KINDS[SECTIONS[section][name].kind]
                raise TirefmuError(f"{path}: [{section}] {name} is {quoted(value)}: expected {kind}")
            possible = SECTIONS[section][name].names
            for each in value if possible else ():
                if each not in possible:
                    raise UnknownName(f"name in [{section}] {name} of {path}", each, possible)
    if not content.get("diagnose", {}).get("time_limit", TIME_LIMIT) > 0:
        raise TirefmuError(f"{path}: [diagnose] time_limit is not positive: a number of seconds is expected")
    if not empty and not content.get("data", {}).get("tables"):
        raise TirefmuError(f"{path}: [data] tables is missing: the list of bench files")
    return Project(path, content)


def project_schema(facts: Callable[[str, str], Mapping[str, Any]]) -> dict[str, Any]:
    """Return the JSON Schema of a project file.

    `facts`: returns further keywords of the schema, such as the description, of an option of a section.
    """
    sections: dict[str, Any] = {
        section: object_schema(
            {
                name: {
                    **schema_of(key.type),
                    **(facts(section, key.option) if key.option else {"description": key.meaning}),
                }
                for name, key in keys.items()
            }
        )
        for section, keys in SECTIONS.items()
    }
    sections["data"] |= {"required": ["tables"]}
    return document("project", "1.0", "Project", object_schema(sections, ["data"]))


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
