"""Names of a package that load at their first access: those that its ``__init__.py`` imports for type checkers."""

from __future__ import annotations

import ast
from collections.abc import Callable
from functools import cache
from importlib import import_module
from pkgutil import get_data
from typing import Any

from .errors import nearest


def on_demand(package: str) -> tuple[Callable[[str], Any], Callable[[], list[str]]]:
    """Return ``__getattr__`` and ``__dir__`` of a package: its names are the imports below ``if TYPE_CHECKING:``."""

    def get(name: str) -> Any:
        places = {} if name.startswith("__") else imports_for_type_checkers(package)
        if name not in places:
            raise AttributeError(f"module {package!r} has no attribute {name!r}{nearest(name, places)}")
        module, original = places[name]
        return getattr(import_module(module, package), original)

    return get, lambda: list(imports_for_type_checkers(package))


@cache
def imports_for_type_checkers(package: str) -> dict[str, tuple[str, str]]:
    """Return, by name, the module and the name in it of what the source of a package imports for type checkers."""
    blocks = ast.parse(get_data(package, "__init__.py") or b"").body
    return {
        alias.asname or alias.name: ("." * node.level + (node.module or ""), alias.name)
        for block in blocks
        if isinstance(block, ast.If) and ast.unparse(block.test) == "TYPE_CHECKING"
        for node in block.body
        if isinstance(node, ast.ImportFrom)
        for alias in node.names
    }
