"""The names in the text of a formula, without SymPy."""

from __future__ import annotations

import ast
from functools import lru_cache


@lru_cache(maxsize=1024)  # states ask for them in every simulation
def names_in(text: str) -> frozenset[str]:
    """Return the names that a formula reads, functions excluded.

    >>> sorted(names_in("abs(Fy)*V + TAU"))
    ['Fy', 'TAU', 'V']
    """
    nodes = list(ast.walk(ast.parse(f"({text.strip()}\n)", mode="eval")))
    functions = {id(node.func) for node in nodes if isinstance(node, ast.Call)}
    return frozenset(node.id for node in nodes if isinstance(node, ast.Name) and id(node) not in functions)
