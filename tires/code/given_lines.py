"""Some lines of a model apart from the rest of it: a slice of its printed Python code.

A time constant changes a few lines of a state or of a relaxation length. Forces and quantities that these lines read
are given.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Mapping
from functools import lru_cache
from typing import Any

import numpy as np
import numpy.typing as npt

from ...symbolic.model import Model
from .modules import numpy_module
from .printed import code_file

FloatArray = npt.NDArray[np.float64]


class GivenLines:
    """Lines of a model as a function of what they read.

    - `reads`: the names that they read: inputs, coefficients, and quantities and forces that are given.
    """

    def __init__(self, model: Model, routine: str, results: tuple[str, ...], changing: frozenset[str]) -> None:
        module = vars(numpy_module(model))
        given = {*module["INPUTS"], *module["PARAMETERS"], *module["QUANTITIES"], *module["FORCES"]} - {*results}
        lines = {name: (value, _names_in(value)) for name, value in _lines(model, routine)}
        follow = set(changing)  # names that change with them: these lines are not given
        for name, (_, read) in lines.items():
            follow |= {name} if read & follow else set()
        given -= follow - changing
        chosen, needed = list[str](), set(results)
        for name, (_, read) in reversed(lines.items()):
            if name in needed - given:
                chosen.insert(0, name)
                needed |= read
        self.reads, self._results = frozenset(needed & given), results
        body = [f"    {name} = {ast.unparse(lines[name][0])}" for name in chosen]
        text = [f"def lines({', '.join((*sorted(self.reads), 'xp'))}):", *body, f"    return {', '.join(results)},"]
        namespace: dict[str, Any] = dict(module)
        exec(compile("\n".join(text), f"<{', '.join(results)}>", "exec"), namespace)  # of the printed code
        self._function: Callable[..., tuple[Any, ...]] = namespace["lines"]

    def __call__(self, values: Mapping[str, Any], n: int) -> dict[str, FloatArray]:
        """Return the lines by name, shape (n,), for the values of the names that they read."""
        with np.errstate(all="ignore"):  # far outside a tire's range a line may divide by zero
            results = self._function(**{name: values[name] for name in self.reads}, xp=np)
        return {name: np.broadcast_to(value, n) for name, value in zip(self._results, results, strict=True)}


@lru_cache(maxsize=64)
def given_lines(
    model: Model, routine: str, results: tuple[str, ...], changing: frozenset[str] = frozenset()
) -> GivenLines:
    """Return lines of a model, one object for each.

    `routine`: the printed function that has them, "state_lines" or "relaxation". `results`: names of lines. `changing`:
    coefficients; other lines that read these are computed as well, not given.
    """
    return GivenLines(model, routine, results, changing)


@lru_cache(maxsize=2)  # a whole module is parsed
def _lines(model: Model, routine: str) -> list[tuple[str, ast.expr]]:
    """Return name and expression of each line of a printed function."""
    tree = ast.parse(code_file(model, f"numpy/{model.name}.py").read_text(encoding="ascii"))
    (function,) = (node for node in tree.body if isinstance(node, ast.FunctionDef) and node.name == routine)
    assigned = [node for node in function.body if isinstance(node, ast.Assign)]
    return [(node.targets[0].id, node.value) for node in assigned if isinstance(node.targets[0], ast.Name)]


def _names_in(expression: ast.expr) -> set[str]:
    return {node.id for node in ast.walk(expression) if isinstance(node, ast.Name)}
