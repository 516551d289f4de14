"""The lines of states apart from the rest of a model: a slice of its printed Python code.

A time constant changes a few lines of its state only. Forces and quantities that these lines read are given.
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


class StateLines:
    """Target, rate and start of some states of a model.

    - `reads`: the names that their lines read: inputs, coefficients, quantities and forces.
    """

    def __init__(self, model: Model, states: tuple[str, ...]) -> None:
        module = vars(numpy_module(model))
        self._names = [line for name in states for line in model.states[name].line_names[:3]]
        known = {*module["INPUTS"], *module["PARAMETERS"], *module["QUANTITIES"], *module["FORCES"]} - {*self._names}
        body, needed = list[ast.stmt](), set(self._names)
        for line in reversed(_assignments(model)):
            if line.targets[0].id in needed - known:
                body.insert(0, line)
                needed |= {node.id for node in ast.walk(line.value) if isinstance(node, ast.Name)}
        self.reads = frozenset(needed & known)
        body.append(ast.Return(ast.parse(f"({', '.join(self._names)},)", mode="eval").body))
        function: Any = ast.parse(f"def lines({', '.join((*sorted(self.reads), 'xp'))}): pass").body[0]
        function.body = body
        whole = ast.fix_missing_locations(ast.Module([function], []))
        namespace: dict[str, Any] = dict(module)
        exec(compile(whole, f"<lines of {', '.join(states)}>", "exec"), namespace)  # the printed code, less of it
        self._function: Callable[..., tuple[Any, ...]] = namespace["lines"]

    def __call__(self, known: Mapping[str, Any], n: int) -> dict[str, FloatArray]:
        """Return the lines by name, shape (n,), for the values of the names that they read."""
        with np.errstate(all="ignore"):
            values = self._function(**{name: known[name] for name in self.reads}, xp=np)
        return {name: np.broadcast_to(value, n) for name, value in zip(self._names, values, strict=True)}


@lru_cache(maxsize=64)
def state_lines(model: Model, states: tuple[str, ...]) -> StateLines:
    """Return the lines of some states of a model, one object for each."""
    return StateLines(model, states)


@lru_cache(maxsize=8)
def _assignments(model: Model) -> list[Any]:
    """Return the assignments to single names in the printed function of the drives of states."""
    tree = ast.parse(code_file(model, f"numpy/{model.name}.py").read_text(encoding="ascii"))
    (drives,) = (node for node in tree.body if isinstance(node, ast.FunctionDef) and node.name == "drives")
    return [node for node in drives.body if isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name)]
