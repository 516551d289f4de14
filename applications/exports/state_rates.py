"""The derivatives of a tire's states by tirefmu's NumPy code: the reference of printed state functions."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from ...symbolic.added.state import SPEED, SPEED_ENDING
from ...symbolic.quantities import AT_ONCE
from ...tires import Tire
from ...tires.code import Code
from ...tires.states.transient import lateral_slip

FloatArray = npt.NDArray[np.float64]


def state_rates(
    tire: Tire, code: Code, inputs: FloatArray, parameters: FloatArray, labels: Sequence[str]
) -> FloatArray:
    """Return derivatives and decay rates of states, shape (rows, n_labels).

    `code`: of its model. `inputs`, shape (n_inputs, rows): the inputs of the model, then the lagged slips.
    `parameters`, shape (n_parameters,). `labels`: ``NAME_dot`` or ``NAME_decay`` of a state.
    """
    n = len(tire.inputs)
    row = dict(zip(tire.inputs, inputs, strict=False))
    given, acting = inputs[:n], inputs[:n].copy()
    rates: dict[str, FloatArray] = {}
    lagging = [label.removesuffix("_dot") for label in labels if label.endswith("lagged_dot")]
    if lagging:
        quantities = dict(zip(code.quantities_names, code.quantities(given, parameters), strict=True))
    for name, lagged in zip(lagging, inputs[n:], strict=True):
        along = name == "kappa_lagged"
        length = quantities[tire.symbolic_model.quantity("relaxation_x" if along else "relaxation_y")]
        decay = np.abs(row["V"]) / np.maximum(length, AT_ONCE)
        target = row["kappa"] if along else lateral_slip(row["alpha"])
        rates |= {f"{name}_decay": decay, f"{name}_dot": decay * (target - lagged)}
        acting[tire.inputs.index("kappa" if along else "alpha")] = lagged if along else np.arctan(lagged)
    at_given, at_acting = (
        dict(zip(tire.symbolic_model.drives, code.drives(rows, parameters), strict=True)) if tire.states else {}
        for rows in (given, acting)
    )
    for name in tire.states:
        state, x = tire.symbolic_model.states[name], row[name]
        lines = at_given if tire.symbolic_model.is_direct(state) or state.follows_a_path else at_acting
        target, rate, _, _ = state.line_names
        u, r = lines[target], lines[rate]
        if state.oscillates:
            decay, derivative = np.zeros_like(u), row[f"{name}{SPEED_ENDING}"]
        elif state.kind == SPEED:
            position = tire.symbolic_model.states[name.removesuffix(SPEED_ENDING)]
            target, frequency = (lines[line] for line in position.line_names[:2])
            decay, derivative = r, frequency**2 * (target - row[position.name]) - r * x
        elif state.settles:
            decay, derivative = r, r * (u - x)
        elif state.kind == "play":
            decay, derivative = np.zeros_like(u), np.where(x * np.sign(u) < 1.0, u * r, 0.0)
        elif state.follows_a_path:
            decay = np.abs(u) * r
            derivative = (np.sign(u) - x) * decay
        else:
            decay, derivative = np.zeros_like(u), u
        rates |= {f"{name}_decay": decay, f"{name}_dot": derivative}
    return np.stack([rates[label] for label in labels], axis=1)
