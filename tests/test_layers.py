"""Which package and sub-package may import which: the tables of ARCHITECTURE.md, read off every import statement."""

from __future__ import annotations

import ast
import sys
from collections.abc import Iterator
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]

#: The front door's own folder, the only one named like the package.
DOOR = "tirefmu"
MAY_IMPORT = {
    "symbolic": set(),
    "generated": set(),
    "tires": {"symbolic", "generated"},
    "measurements": {"tires"},
    "estimation": {"symbolic", "generated", "tires", "measurements"},
    "fitting": {"symbolic", "generated", "tires", "measurements", "estimation"},
    "fmu": {"symbolic", "generated", "tires", "measurements"},
    "diagnosis": {"symbolic", "generated", "tires", "measurements", "estimation", "fitting", "fmu"},
}
MAY_IMPORT[DOOR] = set(MAY_IMPORT)

#: Sub-packages, and which of their siblings each may import. Modules directly in the package may import all of them;
#: no sub-package imports these.
SUBPACKAGES = {
    "fitting": {
        "data": set(),
        "recipes": set(),
        "problem": set(),
        "constraints": {"problem"},
        "solvers": {"problem", "constraints"},
        "evidence": {"problem"},
        "results": {"data", "problem", "constraints", "evidence"},
        "reporting": {"constraints", "evidence", "results"},
    },
}

#: The most modules that a folder of a package with sub-packages has.
MOST_MODULES = 15

#: The kinds of misuse, and how text from files is escaped, belong to all; only machine-made code has no use for them.
COMMON = ("tirefmu.symbolic.errors", "tirefmu.symbolic.escaping")

#: Heavy or special packages stay where they are needed.
ONLY_IN = {
    "casadi": ("generated/casadi", "fitting"),
    "fmpy": ("fmu",),
    "pythonfmu": ("fmu",),
}

#: The book is mathematics and text; machine-made code needs what it is printed for.
ONLY_NEEDS = {"symbolic": {"sympy"}, "generated": {"numpy", "casadi"}}


def imported(tree: ast.Module, package: str) -> Iterator[tuple[int, str, bool | None]]:
    """Yield line, absolute name and whether it was written relatively (None: in a call) of every import."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from ((node.lineno, alias.name, False) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            above = package.split(".")[: len(package.split(".")) - node.level + 1] if node.level else []
            source = ".".join([*above, *filter(None, [node.module])])
            # "from tirefmu import tires" and "from . import tires" name a room only by what they take.
            for name in [f"{source}.{alias.name}" for alias in node.names] if source == DOOR else [source]:
                yield node.lineno, name, node.level > 0
        elif isinstance(node, ast.Call) and ast.unparse(node.func).endswith("import_module"):
            values = [part.value for part in ast.walk(node) if isinstance(part, ast.Constant)]
            texts = [value for value in values if isinstance(value, str)]
            # The text, or what an f-string starts with; a name worked out elsewhere cannot be read here.
            yield from ((node.lineno, text.rstrip("."), None) for text in texts[:1] if not text.startswith("."))


def room_of(name: str) -> str:
    """Return the room that an absolute name starting with tirefmu leads to."""
    second = name.split(".")[1] if "." in name else ""
    return second if second in MAY_IMPORT and second != DOOR else DOOR


def wrong_subpackage(package: str, folders: list[str], name: str) -> str:
    """Return what is wrong with a sub-package's import of a module of its own package; empty where nothing is."""
    allowed = SUBPACKAGES.get(package, {})
    own, reached = folders[0] if folders else "", name.split(".")[2] if name.count(".") > 1 else ""
    if not own or own == reached or reached in allowed.get(own, ()):
        return ""
    return f"{package}/{own} may not import {name}" if own in allowed else ""


def complaints(path: str, source: str) -> list[str]:
    """Return what a file of the given path (relative to the root, with slashes) imports against the rules."""
    room, *folders, _ = path.split("/")
    package = ".".join([room, *folders] if room in (DOOR, "tests") else [DOOR, room, *folders])
    found = []
    for line, name, relative in imported(ast.parse(source), package):
        top = name.split(".")[0]
        if top == DOOR:
            reached = room_of(name)
            allowed = MAY_IMPORT.get(room, set(MAY_IMPORT))
            common = name in COMMON and room != "generated"
            inner = wrong_subpackage(room, folders, name) if reached == room else ""
            if inner:
                wrong = inner
            elif reached == room and relative is False:
                wrong = f"{name} is in this room: import it relatively"
            elif reached != room and relative:
                wrong = f"{name} is in another room: import it absolutely"
            elif reached != room and reached not in allowed and not common:
                wrong = f"{room} may not import {name}"
            else:
                continue
        elif top in MAY_IMPORT:
            wrong = f"{name} is met as tirefmu.{name} only"
        elif room in MAY_IMPORT and not path.startswith(ONLY_IN.get(top, ("",))):
            wrong = f"{top} is imported in {' and '.join(ONLY_IN[top])} only"
        elif room in ONLY_NEEDS and top not in ONLY_NEEDS[room] | sys.stdlib_module_names:
            wrong = f"{room} does without {top}"
        else:
            continue
        found.append(f"{path}:{line}: {wrong}")
    return found


def python_files() -> list[str]:
    folders = [*MAY_IMPORT, "tests"]
    return sorted(path.relative_to(ROOT).as_posix() for folder in folders for path in (ROOT / folder).rglob("*.py"))


def test_every_room_keeps_to_its_walls():
    files = python_files()
    assert {path.split("/")[0] for path in files} == {*MAY_IMPORT, "tests"}
    found = [line for path in files for line in complaints(path, (ROOT / path).read_text(encoding="utf-8"))]
    assert not found, "\n".join(found)


def test_sub_packages_are_declared_and_small():
    for package, allowed in SUBPACKAGES.items():
        assert {path.parent.name for path in (ROOT / package).glob("*/__init__.py")} == set(allowed)
        for folder in (ROOT / package, *(ROOT / package / name for name in allowed)):
            assert len(list(folder.glob("*.py"))) <= MOST_MODULES, folder


def module_name(path: str) -> str:
    """Return the absolute name of a module from its path relative to the root."""
    parts = path.removesuffix(".py").removesuffix("/__init__").split("/")
    return ".".join(parts if parts[0] == DOOR else [DOOR, *parts])


def import_graph(sources: dict[str, str]) -> dict[str, set[str]]:
    """Return which of the modules each imports, by name; imports for type checking and inside functions count."""
    paths = {module_name(path): path for path in sources}
    graph: dict[str, set[str]] = {}
    for module, path in paths.items():
        package = module if path.endswith("/__init__.py") else module.rpartition(".")[0]
        reached = set()
        for node in ast.walk(ast.parse(sources[path])):
            if isinstance(node, ast.Import):
                reached |= {alias.name for alias in node.names}
            elif isinstance(node, ast.ImportFrom):
                above = package.split(".")[: len(package.split(".")) - node.level + 1] if node.level else []
                source = ".".join([*above, *filter(None, [node.module])])
                names = {f"{source}.{alias.name}" for alias in node.names}
                # What a package only passes on comes from the package.
                reached |= {name if name in paths else source for name in names}
        graph[module] = (reached & paths.keys()) - {module}
    return graph


def circle_in(graph: dict[str, set[str]]) -> list[str]:
    """Return the modules of one circle of imports; empty where there is none."""
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        return list(error.args[1])
    return []


#: Packages with circles between their own modules (a class and its summary, a tire and its files).
CIRCULAR = {"symbolic"}


def test_no_modules_import_each_other_in_a_circle():
    files = [path for path in python_files() if path.split("/")[0] in MAY_IMPORT]
    graph = import_graph({path: (ROOT / path).read_text(encoding="utf-8") for path in files})
    within: dict[str, dict[str, set[str]]] = {package: {} for package in CIRCULAR}
    for module, reached in graph.items():
        package = room_of(module)
        if package in CIRCULAR:
            within[package][module] = {name for name in reached if room_of(name) == package}
            graph[module] = reached - within[package][module]
    assert not circle_in(graph), " -> ".join(circle_in(graph))
    for package, own in within.items():
        assert circle_in(own), f"{package} has no circle any more: take it out of CIRCULAR"


@pytest.mark.parametrize(
    "second",
    [
        "from .a import f",
        "def g():\n    from . import a",
        "if TYPE_CHECKING:\n    from .a import f",
        "import tirefmu.fmu.a",
    ],
)
def test_a_planted_circle_is_found(second):
    sources = {"fmu/__init__.py": "from .a import f", "fmu/a.py": "from .b import g", "fmu/b.py": second}
    assert set(circle_in(import_graph(sources))) == {"tirefmu.fmu.a", "tirefmu.fmu.b"}
    assert circle_in(import_graph({**sources, "fmu/b.py": "import numpy"})) == []


@pytest.mark.parametrize(
    ("path", "source", "complaint"),
    [
        ("symbolic/model.py", "from tirefmu.tires import Tire", "symbolic may not import tirefmu.tires"),
        ("symbolic/model.py", "def f():\n    import tirefmu.fmu", "symbolic may not import tirefmu.fmu"),
        (
            "generated/numpy/mf96.py",
            "from tirefmu.symbolic.errors import TireError",
            "generated may not import",
        ),
        ("fmu/packaging/export.py", "from tirefmu import fitting", "fmu may not import tirefmu.fitting"),
        (
            "fitting/problem.py",
            "from tirefmu.fmu.comparison.check import check",
            "fitting may not import tirefmu.fmu.comparison.check",
        ),
        ("estimation/noise_model.py", "from tirefmu.fitting import fit", "estimation may not import tirefmu.fitting"),
        ("fitting/problem/loss.py", "from ..solvers.ipopt import solve", "fitting/problem may not import"),
        ("fitting/evidence/residuals.py", "from ..fit import fit", "fitting/evidence may not import"),
        ("tires/tire.py", "from tirefmu import load", "tires may not import tirefmu.load"),
        ("tires/tire.py", "import tirefmu", "tires may not import tirefmu"),
        ("fmu/packaging/export.py", "import_module(f'tirefmu.fitting.{name}')", "fmu may not import tirefmu.fitting"),
        ("tires/tire.py", "from tirefmu.tires.signs import flip", "import it relatively"),
        ("tirefmu/cli.py", "from tirefmu.demo import run", "import it relatively"),
        ("tires/tire.py", "from ..symbolic.model import Model", "import it absolutely"),
        ("tirefmu/cli.py", "from . import fmu", "import it absolutely"),
        ("fmu/packaging/export.py", "import symbolic.model", "is met as tirefmu.symbolic.model only"),
        ("tests/symbolic/test_model.py", "from symbolic import model", "is met as tirefmu.symbolic only"),
        (
            "symbolic/printers/casadi.py",
            "import casadi",
            "casadi is imported in generated/casadi and fitting only",
        ),
        ("diagnosis/what.py", "from fmpy import simulate_fmu", "fmpy is imported in fmu only"),
        ("symbolic/model.py", "import pandas as pd", "symbolic does without pandas"),
    ],
)
def test_a_planted_import_is_found(path, source, complaint):
    (found,) = complaints(path, source)
    assert complaint in found


@pytest.mark.parametrize(
    ("path", "source"),
    [
        (
            "symbolic/mf96/side_force.py",
            "from ..notation import magic\nfrom .coefficients import Lateral\nimport sympy",
        ),
        ("generated/casadi/mf96.py", "import casadi"),
        (
            "fitting/solvers/ipopt.py",
            "from ..problem.loss import Loss\nfrom .convergence import settle",
        ),
        (
            "measurements/table.py",
            "from tirefmu.symbolic.errors import DataError\nfrom tirefmu.tires import Tire",
        ),
        ("fitting/problem.py", "import casadi\nfrom tirefmu.generated.casadi import mf96"),
        ("tires/code.py", "importlib.import_module(f'tirefmu.generated.numpy.{model}')"),
        ("tirefmu/__init__.py", "from tirefmu.fmu import export\nfrom .cli import main"),
        ("tests/fmu/test_check.py", "import fmpy\nimport tirefmu\nfrom tirefmu.fmu import check"),
    ],
)
def test_a_proper_import_is_not(path, source):
    assert complaints(path, source) == []
