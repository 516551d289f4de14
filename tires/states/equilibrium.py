"""The equilibrium of a tire's states at constant inputs."""

from __future__ import annotations

from collections.abc import Collection, Mapping

import numpy as np
import numpy.typing as npt

from ...symbolic.model import Model
from ..code import Code

FloatArray = npt.NDArray[np.float64]

#: Iterations end when no value changes by more than this share.
CONVERGED = 1e-13
#: The largest number of iterations of states that depend on one another.
MAX_ITERATIONS = 100


def equilibrium(
    model: Model,
    code: Code,
    rows: FloatArray,
    parameters: FloatArray,
    names: Collection[str],
    given: Mapping[str, FloatArray] | None = None,
    *,
    start: bool = False,
) -> FloatArray:
    """Return inputs with every state in equilibrium at constant inputs; a state that has none is at its start value.

    So is a temperature: a wheel in steady slip would heat far beyond any use of a tire.

    `rows`, shape (n_inputs, n). `parameters`, shape (n_parameters,). `names`: the states of the tire; the others are 0.
    `given`, shape (n,): values of states that are not computed. `start`: whether a state that declares a start value
    has that value, as at the start of a recording. Returns shape (n_inputs, n).
    """
    rows = rows.copy()
    inputs = [quantity.name for quantity in model.inputs]
    rows[[inputs.index(name) for name in model.states]] = 0.0
    states = [state for name, state in model.states.items() if name in names]
    indices = [inputs.index(state.name) for state in states]
    if not states:
        return rows
    moving = np.arange(rows.shape[1])  # the rows that have not converged
    for i in range(MAX_ITERATIONS):
        lines = dict(zip(model.state_lines, code.state_lines(rows[:, moving], parameters), strict=True))
        at = np.ix_(np.array(indices), moving)
        before = rows[at]
        after = before.copy()
        for k, state in enumerate(states):
            target, _, first, _ = state.line_names
            if given and state.name in given:
                after[k] = given[state.name][moving]
            elif state.settles and not (state.has_start_value and (start or state.is_temperature)):
                after[k] = lines[target] if i == 0 else (before[k] + lines[target]) / 2.0
            else:
                after[k] = lines[first]
        rows[at] = after
        moving = moving[~(np.abs(after - before) <= CONVERGED * np.abs(after)).all(axis=0)]
        if not len(moving):
            break
    return rows
