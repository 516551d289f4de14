"""Which package and sub-package may import which: the tables of ARCHITECTURE.md, checked on every import statement."""

from __future__ import annotations

import ast
import sys
from collections.abc import Iterator
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]

#: The folder of the command line and the public names, the only one named like the distribution.
TOP = "tirefmu"
MAY_IMPORT = {
    "symbolic": set(),
    "generated": set(),
    "tires": {"symbolic", "generated"},
    "measurements": {"tires"},
    "estimation": {"symbolic", "generated", "tires", "measurements"},
    "fitting": {"symbolic", "generated", "tires", "measurements", "estimation"},
    "fmu": {"symbolic", "generated", "tires", "measurements"},
    "hosts": {"symbolic", "generated", "tires", "measurements", "estimation", "fitting"},
    "batch": {"symbolic", "generated", "tires", "measurements", "estimation", "fitting", "fmu", "diagnosis"},
    "comparison": {"symbolic", "generated", "tires", "measurements"},
    "explorer": {"symbolic", "generated", "tires", "measurements"},
    "diagnosis": {"symbolic", "generated", "tires", "measurements", "estimation", "fitting", "fmu"},
}
MAY_IMPORT[TOP] = set(MAY_IMPORT)

#: Of each sub-package: the siblings and the modules directly in the package that it may import. Modules directly in a
#: package may import its sub-packages; the test of circles applies to all of them.
SUBPACKAGES = {
    "tires": {
        "code": set(),
        "drawing": {"definition", "evaluation", "signs", "tire_argument"},
        "property_file": {"code", "definition", "tire"},
        "published_tires": {"property_file", "tire"},
        "roads": set(),
    },
    "measurements": {
        "files": {"channels", "column_names", "quality", "recording", "thresholds", "units"},
        "operating_conditions": {"channels", "recording", "thresholds"},
        "row_selection": {"channels", "column_names", "operating_conditions", "recording", "units"},
        "virtual_bench": {"channels", "recording", "units"},
        "findings": {
            "channels",
            "column_names",
            "operating_conditions",
            "quality",
            "recording",
            "thresholds",
            "units",
        },
        "inspection": {"channels", "findings", "operating_conditions", "provenance", "quality", "recording"},
        "quality": {"channels", "operating_conditions", "recording", "thresholds"},
    },
    "fitting": {
        "data": set(),
        "recipes": set(),
        "problem": set(),
        "constraints": {"problem"},
        "solvers": {"problem", "constraints"},
        "evidence": {"problem"},
        "results": {"data", "problem", "constraints", "evidence"},
        "resampling": {"problem", "constraints", "solvers", "evidence", "results"},
        "reporting": {"constraints", "evidence", "results"},
    },
    "fmu": {
        "description": set(),
        "packaging": {"description", "simulation"},
        "simulation": set(),
        "comparison": {"simulation"},
    },
    "diagnosis": {
        "recording": {"thresholds"},
        "probing": {"least_squares", "recording", "thresholds"},
        "unexplained": {"least_squares", "probing", "recording", "thresholds"},
        "search": {"least_squares", "probing", "recording", "thresholds", "unexplained"},
        "verdict": {"least_squares", "probing", "recording", "search", "thresholds", "unexplained"},
        "reporting": {"thresholds", "verdict"},
    },
}

#: Upper limit of the modules in a folder of a package.
MAX_MODULES = 15

#: Exceptions and the escaping of texts are common to all packages except the generated code.
COMMON = ("tirefmu.symbolic.errors", "tirefmu.symbolic.escaping")

#: Third-party packages that only some folders may import.
ONLY_IN = {
    "casadi": ("tires/code/casadi_code.py", "fitting"),
    "fmpy": ("fmu",),
    "pythonfmu": ("fmu",),
}

#: The only third-party packages of these packages.
ONLY_NEEDS = {"symbolic": {"sympy"}, "generated": {"numpy"}}


def imported(tree: ast.Module, package: str) -> Iterator[tuple[int, str, bool | None]]:
    """Yield line, absolute name and whether it was written relatively (None: in a call) of every import."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from ((node.lineno, alias.name, False) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            above = package.split(".")[: len(package.split(".")) - node.level + 1] if node.level else []
            source = ".".join([*above, *filter(None, [node.module])])
            # "from tirefmu import tires" and "from . import tires" name a package only by what they import.
            for name in [f"{source}.{alias.name}" for alias in node.names] if source == TOP else [source]:
                yield node.lineno, name, node.level > 0
        elif isinstance(node, ast.Call) and ast.unparse(node.func).endswith("import_module"):
            values = [part.value for part in ast.walk(node) if isinstance(part, ast.Constant)]
            texts = [value for value in values if isinstance(value, str)]
            # The text, or the first part of an f-string; a computed name is not visible here.
            yield from ((node.lineno, text.rstrip("."), None) for text in texts[:1] if not text.startswith("."))


def package_of(name: str) -> str:
    """Return the package that contains an absolute name that starts with tirefmu."""
    second = name.split(".")[1] if "." in name else ""
    return second if second in MAY_IMPORT and second != TOP else TOP


def wrong_subpackage(package: str, folders: list[str], name: str) -> str:
    """Return why a sub-package may not import a module of its own package; empty where it may."""
    allowed = SUBPACKAGES.get(package, {})
    own, reached = folders[0] if folders else "", name.split(".")[2] if name.count(".") > 1 else ""
    if not own or own == reached or reached in allowed.get(own, ()):
        return ""
    return f"{package}/{own} may not import {name}" if own in allowed else ""


def violations(path: str, source: str) -> list[str]:
    """Return the imports of a file that violate the rules; its path is relative to the root, with slashes."""
    root, *folders, _ = path.split("/")
    package = ".".join([root, *folders] if root in (TOP, "tests") else [TOP, root, *folders])
    found = []
    for line, name, relative in imported(ast.parse(source), package):
        top = name.split(".")[0]
        if top == TOP:
            reached = package_of(name)
            allowed = MAY_IMPORT.get(root, set(MAY_IMPORT))
            common = name in COMMON and root != "generated"
            inner = wrong_subpackage(root, folders, name) if reached == root else ""
            if inner:
                wrong = inner
            elif reached == root and relative is False:
                wrong = f"{name} is in this package: import it relatively"
            elif reached != root and relative:
                wrong = f"{name} is in another package: import it absolutely"
            elif reached != root and reached not in allowed and not common:
                wrong = f"{root} may not import {name}"
            else:
                continue
        elif top in MAY_IMPORT:
            wrong = f"{name} is imported as tirefmu.{name} only"
        elif root in MAY_IMPORT and not path.startswith(ONLY_IN.get(top, ("",))):
            wrong = f"{top} is imported in {' and '.join(ONLY_IN[top])} only"
        elif root in ONLY_NEEDS and top not in ONLY_NEEDS[root] | sys.stdlib_module_names:
            wrong = f"{root} may not import {top}"
        else:
            continue
        found.append(f"{path}:{line}: {wrong}")
    return found


def python_files() -> list[str]:
    """Return the files of all packages."""
    folders = [*MAY_IMPORT, "tests"]
    paths = (path.relative_to(ROOT).as_posix() for folder in folders for path in (ROOT / folder).rglob("*.py"))
    return sorted(paths)


def test_no_import_violates_the_tables():
    files = python_files()
    assert {path.split("/")[0] for path in files} == {*MAY_IMPORT, "tests"}
    found = [line for path in files for line in violations(path, (ROOT / path).read_text(encoding="utf-8"))]
    assert not found, "\n".join(found)


def test_every_sub_package_is_declared():
    for package, allowed in SUBPACKAGES.items():
        assert {path.parent.name for path in (ROOT / package).glob("*/__init__.py")} == set(allowed)


def test_folders_are_small():
    for path in python_files():
        folder = (ROOT / path).parent
        if path.split("/")[0] in MAY_IMPORT and "generated" not in path:
            assert len(list(folder.glob("*.py"))) <= MAX_MODULES, folder


def module_name(path: str) -> str:
    """Return the absolute name of a module from its path relative to the root."""
    parts = path.removesuffix(".py").removesuffix("/__init__").split("/")
    return ".".join(parts if parts[0] == TOP else [TOP, *parts])


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
                # A name that a package re-exports is imported from the package.
                reached |= {name if name in paths else source for name in names}
        graph[module] = (reached & paths.keys()) - {module}
    return graph


def circle_in(graph: dict[str, set[str]]) -> list[str]:
    """Return the modules of one circle of imports; empty if there is none."""
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        return list(error.args[1])
    return []


def test_no_modules_import_each_other_in_a_circle():
    files = [path for path in python_files() if path.split("/")[0] in MAY_IMPORT]
    graph = import_graph({path: (ROOT / path).read_text(encoding="utf-8") for path in files})
    assert not circle_in(graph), " -> ".join(circle_in(graph))


@pytest.mark.parametrize(
    "second",
    [
        "from .a import f",
        "def g():\n    from . import a",
        "if TYPE_CHECKING:\n    from .a import f",
        "import tirefmu.fmu.a",
    ],
)
def test_a_circle_is_found(second):
    sources = {"fmu/__init__.py": "from .a import f", "fmu/a.py": "from .b import g", "fmu/b.py": second}
    assert set(circle_in(import_graph(sources))) == {"tirefmu.fmu.a", "tirefmu.fmu.b"}
    assert circle_in(import_graph({**sources, "fmu/b.py": "import numpy"})) == []


@pytest.mark.parametrize(
    ("path", "source", "violation"),
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
        ("fmu/packaging/export.py", "import symbolic.model", "is imported as tirefmu.symbolic.model only"),
        ("tests/symbolic/test_model.py", "from symbolic import model", "is imported as tirefmu.symbolic only"),
        (
            "symbolic/printers/casadi.py",
            "import casadi",
            "casadi is imported in tires/code/casadi_code.py and fitting only",
        ),
        ("diagnosis/what.py", "from fmpy import simulate_fmu", "fmpy is imported in fmu only"),
        ("symbolic/model.py", "import pandas as pd", "symbolic may not import pandas"),
    ],
)
def test_a_forbidden_import_is_found(path, source, violation):
    (found,) = violations(path, source)
    assert violation in found


@pytest.mark.parametrize(
    ("path", "source"),
    [
        (
            "symbolic/mf96/side_force.py",
            "from ..notation import magic\nfrom .coefficients import Lateral\nimport sympy",
        ),
        ("tires/code/casadi_code.py", "import casadi"),
        (
            "fitting/solvers/ipopt.py",
            "from ..problem.loss import Loss\nfrom .convergence import settle",
        ),
        (
            "measurements/table.py",
            "from tirefmu.symbolic.errors import DataError\nfrom tirefmu.tires import Tire",
        ),
        ("fitting/problem.py", "import casadi\nfrom tirefmu.generated.numpy import mf96"),
        ("tires/code.py", "importlib.import_module(f'tirefmu.generated.numpy.{model}')"),
        ("tirefmu/__init__.py", "from tirefmu.fmu import export\nfrom .cli import main"),
        ("tests/fmu/test_check.py", "import fmpy\nimport tirefmu\nfrom tirefmu.fmu import check"),
    ],
)
def test_an_allowed_import_is_not_reported(path, source):
    assert violations(path, source) == []
