"""Imports, sizes of folders, and names of variables. import-linter checks who may import whom (`make check`)."""

from __future__ import annotations

import ast
from collections import Counter
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
PACKAGES = {path.parent.name for path in ROOT.glob("*/__init__.py")}
FILES = sorted(path.relative_to(ROOT).as_posix() for package in PACKAGES for path in (ROOT / package).rglob("*.py"))
MAX_MODULES = 15


def wrong_imports(path: str, source: str) -> list[str]:
    """Return the imports that are not relative in a package, or not ``tirefmu.PACKAGE`` of another one."""
    root, *folders, _ = path.split("/")
    wrong = []
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.ImportFrom) and node.level > len(folders) + 1:
            wrong.append(ast.unparse(node))
        elif isinstance(node, ast.Import) or (isinstance(node, ast.ImportFrom) and not node.level):
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else [node.module or ""]
            tops = {name.split(".")[0] for name in names}
            inside = any(f"{name}.".startswith(f"tirefmu.{root}.") for name in names)
            if inside or tops & PACKAGES - {"tirefmu"}:
                wrong.append(ast.unparse(node))
    return wrong


def test_imports_are_relative_inside_a_package_and_absolute_across_packages():
    assert {"symbolic", "tirefmu"} <= PACKAGES
    found = {path: wrong_imports(path, (ROOT / path).read_text(encoding="utf-8")) for path in FILES}
    assert not {path: wrong for path, wrong in found.items() if wrong}


@pytest.mark.parametrize(
    "source",
    [
        "from tirefmu.tires.signs import flip",
        "from ...fmu import export",
        "import symbolic.model",
        "from symbolic import a",
    ],
)
def test_a_wrong_import_is_found(source):
    assert wrong_imports("tires/code/kernel.py", source)
    assert not wrong_imports("tires/code/kernel.py", "from ..signs import flip\nimport tirefmu.symbolic.model")


def test_folders_are_small():
    modules = Counter((ROOT / path).parent for path in FILES if not path.startswith("generated/"))
    assert max(modules.values()) <= MAX_MODULES, modules.most_common(1)


#: Words that do not say what a variable is, and folders in which variables may still have one of them as a name.
EMPTY_WORDS = {"each", "one", "own", "found", "known"}
NOT_NAMED = ("benchmarks", "examples", "tests", "generated")
#: The field `Diagnosis.found`, and keys of the JSON of a diagnosis and of a drive.
AS_THEY_ARE = {
    "applications/batch/diagnose_many.py: found", "diagnosis/verdict/composition.py: found", "diagnosis/verdict/content.py: found",
    "diagnosis/verdict/result.py: found", "applications/driving/drive_content.py: found",
}  # fmt: skip


def test_names_of_variables_say_what_they_are():
    empty = {
        f"{path}: {name}"
        for path in FILES
        if not path.startswith(tuple(f"{folder}/" for folder in NOT_NAMED))
        for node in ast.walk(ast.parse((ROOT / path).read_text(encoding="utf-8")))
        for name in EMPTY_WORDS & {getattr(node, "arg", None), node.id if _is_stored(node) else None}
    }
    assert empty == AS_THEY_ARE


def _is_stored(node: ast.AST) -> bool:
    return isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)
