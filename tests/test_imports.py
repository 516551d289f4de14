"""Imports, sizes of folders, classes and signatures, names of variables.

import-linter checks who may import whom (`make check`).
"""

from __future__ import annotations

import ast
from collections import Counter
from collections.abc import Mapping
from os.path import commonpath
from pathlib import Path

import pytest

from tirefmu.boundary.on_demand import imports_for_type_checkers

from .rooms import ROOMS

ROOT = Path(__file__).parents[1]
MAX_MODULES = 15
MAX_FIELDS, MAX_PARAMETERS = 15, 12
MAX_MODULES_OF_TESTS = 200
FILES = [path.relative_to(ROOT).as_posix() for room in ROOMS for path in sorted((ROOT / room).rglob("*.py"))]


@pytest.fixture(scope="module")
def trees() -> dict[str, ast.Module]:
    """Return the syntax trees of the product's files: to parse them takes seconds."""
    return {path: ast.parse((ROOT / path).read_text(encoding="utf-8")) for path in [*FILES, "__init__.py"]}


def absolute_imports(tree: ast.Module) -> list[str]:
    """Return the imports of the package by its name, or of a room as a top-level package."""
    wrong = []
    for node in ast.walk(tree):
        if isinstance(node, ast.Import) or (isinstance(node, ast.ImportFrom) and not node.level):
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else [node.module or ""]
            if {name.split(".")[0] for name in names} & {"tirefmu", *ROOMS}:
                wrong.append(ast.unparse(node))
    return wrong


def test_imports_are_relative(trees):
    assert not {path: wrong for path, tree in trees.items() if (wrong := absolute_imports(tree))}


@pytest.mark.parametrize("source", ["from tirefmu.tires.signs import flip", "import symbolic.model"])
def test_a_wrong_import_is_found(source):
    assert absolute_imports(ast.parse(source))
    assert not absolute_imports(ast.parse("from ..signs import flip\nimport numpy"))


def fronts() -> dict[str, set[str]]:
    """Return, by folder, the names that its ``__init__.py`` loads at their first access."""
    folders = {Path(path).parent for path in FILES if path.endswith("__init__.py")}
    loading = [
        folder for folder in folders if "on_demand(__name__)" in (ROOT / folder / "__init__.py").read_text("utf-8")
    ]
    return {
        folder.as_posix(): set(imports_for_type_checkers(f"tirefmu.{'.'.join(folder.parts)}")) for folder in loading
    }


def test_a_name_of_a_front_is_not_that_of_a_module_beside_it():
    """Once the module is imported, the name would be the module."""
    modules = {folder: {path.stem for path in (ROOT / folder).iterdir()} for folder in fronts()}
    assert not {folder: both for folder, names in fronts().items() if (both := names & modules[folder])}


def product_modules_imported_by_tests() -> set[str]:
    """Return the modules and packages of the product that files in ``tests/`` import."""
    modules = {path.removesuffix(".py").removesuffix("/__init__").replace("/", ".") for path in FILES}
    imported = set()
    for path in (ROOT / "tests").rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("tirefmu."):
                module = node.module.removeprefix("tirefmu.")
                names = {f"{module}.{alias.name}" for alias in node.names}
                imported |= names & modules or {module}
    return imported


def test_tests_import_the_fronts_of_packages():
    """A move inside a package then changes no test."""
    assert len(product_modules_imported_by_tests()) <= MAX_MODULES_OF_TESTS


def test_folders_are_small():
    """Of commands, each has a module."""
    modules = Counter((ROOT / path).parent for path in FILES if not path.startswith(("commands/", "generated/")))
    assert max(modules.values()) <= MAX_MODULES, modules.most_common(1)


def fields_of(trees: Mapping[str, ast.Module]) -> dict[str, int]:
    """Return the number of fields of each class, with those of the nearest class that it extends."""
    classes = {
        (path, node.name): node for path, tree in trees.items() for node in ast.walk(tree)
        if isinstance(node, ast.ClassDef)
    }  # fmt: skip

    def declared(path: str, name: str) -> set[str]:
        node = classes[path, name]
        statements = [part for part in node.body if isinstance(part, ast.AnnAssign)]
        fields = {ast.unparse(part.target) for part in statements if "ClassVar" not in ast.unparse(part.annotation)}
        for base in {ast.unparse(base) for base in node.bases} - {name}:
            of_name = [key for key in classes if key[1] == base]
            if of_name:
                fields |= declared(*max(of_name, key=lambda key: len(commonpath([key[0], path]))))
        return fields

    return {f"{path}: {name}": len(declared(path, name)) for path, name in classes}


def test_classes_have_few_fields(trees):
    """Each field of `FitOptions` is a keyword of `tirefmu.fit`."""
    counts = fields_of({path: tree for path, tree in trees.items() if not path.startswith("generated/")})
    many = {name for name, count in counts.items() if count > MAX_FIELDS}
    assert many == {"fitting/options.py: FitOptions"}


def test_fields_are_counted_with_those_of_the_classes_that_are_extended():
    source = "class A:\n a: int\n b: ClassVar[int]\nclass B(A):\n c: int"
    counts = fields_of({"x": ast.parse(source), "y": ast.parse("class C(A):\n d: int\nclass A:\n pass")})
    assert counts == {"x: A": 1, "x: B": 2, "y: C": 1, "y: A": 0}


def test_functions_have_few_parameters(trees):
    """The keywords of a printed routine are the inputs of the model; those of a command are its options."""
    many = {
        f"{path}: {node.name}"
        for path, tree in trees.items()
        if not path.startswith(("generated/", "commands/"))
        for node in ast.walk(tree)
        if isinstance(node, ast.FunctionDef)
        and len([*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs]) > MAX_PARAMETERS
    }
    assert not many


#: Words that do not say what a variable is, and folders in which variables may still have one of them as a name.
EMPTY_WORDS = {"each", "one", "own", "found", "known"}
NOT_NAMED = ("benchmarks", "examples", "tests", "generated")
#: The field `Diagnosis.found`, and keys of the JSON of a diagnosis and of a drive.
AS_THEY_ARE = {
    "applications/batch/diagnose_many.py: found", "applications/driving/result.py: found",
    "diagnosis/verdict/composition.py: found", "diagnosis/verdict/result.py: found",
}  # fmt: skip


def test_names_of_variables_say_what_they_are(trees):
    empty = {
        f"{path}: {name}"
        for path, tree in trees.items()
        if not path.startswith(tuple(f"{folder}/" for folder in NOT_NAMED))
        for node in ast.walk(tree)
        for name in EMPTY_WORDS & {getattr(node, "arg", None), node.id if _is_stored(node) else None}
    }
    assert empty == AS_THEY_ARE


def _is_stored(node: ast.AST) -> bool:
    return isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)
