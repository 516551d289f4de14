"""The rows of a self-test: operating conditions, and the results and derivatives of states of tirefmu's NumPy code."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import numpy.typing as npt

from ...symbolic.added.state import SPEED, SPEED_ENDING
from ...symbolic.printers.languages.program import TOLERANCE, PrintedProgram
from ...symbolic.quantities import AT_ONCE
from ...tires import Tire
from ...tires.code import Code, code_for
from ...tires.states.equilibrium import equilibrium
from ...tires.states.transient import lateral_slip

FloatArray = npt.NDArray[np.float64]

#: How much more than a change in the last digit of the coefficients an ill-conditioned result may differ.
MARGIN = 5.0

#: The rows of the file that a printout contains.
ROWS = 40


def check_text(tire: Tire, program: PrintedProgram, rows: int = ROWS, seed: int = 0) -> str:
    """Return the text of a self-test's file: numbers separated by blanks.

    The first is the number of rows. The second line has the typical size of each result: a difference is relative to
    it or to the result, whichever is larger.
    Each further line has the inputs and the results of a row.

    `tire`: in ISO-W.
    """
    inputs = operating_conditions(tire, rows, seed)
    lagged = [quantity.name for quantity in program.inputs[len(inputs) :]]
    inputs = np.concatenate([inputs, _lagged(lagged, rows, seed)])
    inputs, results, sizes = reference(tire, program, inputs)
    lines = [str(inputs.shape[1]), _numbers(sizes)]
    lines += [f"{_numbers(row)} {_numbers(values)}" for row, values in zip(inputs.T, results, strict=True)]
    return "\n".join(lines) + "\n"


def _numbers(values: Sequence[float] | FloatArray) -> str:
    return " ".join(repr(float(value)) for value in values)


def operating_conditions(tire: Tire, rows: int, seed: int = 0) -> FloatArray:
    """Return operating conditions, shape (n_inputs, rows): special ones first, then random ones.

    Special are zero slip, no load, a tenth and three times the nominal load, a locked and a spinning wheel, slip angles
    up to 1.2 rad and beyond 90 deg, reverse, standstill. States of effects are between zero and 1.5 times their
    equilibrium.
    """
    rng = np.random.default_rng(seed)
    nominal = {name: tire.nominal(name) for name in tire.inputs}
    load = nominal["Fz"]
    special: list[dict[str, float]] = [
        {}, {"Fz": 0.0}, {"Fz": -0.1 * load}, {"Fz": 0.1 * load, "alpha": 0.1}, {"Fz": 3.0 * load, "kappa": -0.1},
        {"kappa": -1.0}, {"kappa": 2.0, "alpha": -0.2}, {"alpha": 1.2}, {"alpha": -1.2, "kappa": 0.5},
        {"V": -10.0, "alpha": 0.1, "kappa": 0.1}, {"V": 0.0, "alpha": 0.1, "kappa": 0.1}, {"V": -3.0, "gamma": 0.1},
        {"Fz": 0.0, "alpha": 0.1, "kappa": 0.1, "gamma": 0.1}, {"alpha": 2.0, "kappa": 0.1}, {"alpha": -3.0},
    ]  # fmt: skip
    random = {
        "kappa": rng.uniform(-0.9, 1.5, rows),
        "alpha": rng.uniform(-0.8, 0.8, rows),
        "gamma": rng.uniform(-0.2, 0.2, rows),
        "Fz": rng.uniform(0.02, 2.5, rows) * load,
        "V": rng.uniform(-40.0, 40.0, rows),
        "phit": rng.uniform(-0.3, 0.3, rows) * (rng.random(rows) < 0.3),
    }
    table = np.empty((len(tire.inputs), rows))
    for row, name in zip(table, tire.inputs, strict=True):
        row[:] = random.get(name, nominal[name] * rng.uniform(0.7, 1.3, rows))
        for i, given in enumerate(special[:rows]):
            row[i] = given.get(name, nominal[name])
    table = tire.effective_inputs(table)
    if not tire.states:
        return table
    settled = equilibrium(
        tire.symbolic_model, code_for(tire.symbolic_model, "numpy"), table, tire.parameters(), tire.states
    )
    for i, name in enumerate(tire.inputs):
        if name in tire.states:
            state = tire.symbolic_model.states[name]
            table[i] = settled[i] * rng.uniform(0.0, 1.5, rows) if state.settles else rng.uniform(-1.0, 1.0, rows)
    return table


def _lagged(names: Sequence[str], rows: int, seed: int) -> FloatArray:
    """Return lagged slips, shape (n_names, rows)."""
    rng = np.random.default_rng([seed, 1])
    return np.array([rng.uniform(-0.8, 0.8, rows) for _ in names]).reshape(len(names), rows)


def reference(tire: Tire, program: PrintedProgram, inputs: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return well-conditioned rows of inputs, results by tirefmu's NumPy code, and the size of each result.

    A derivative may be a small difference of large terms: its size contains a hundredth of the force per argument. The
    accuracy of an ill-conditioned result, such as the deflection by a quadratic equation with a tiny leading
    coefficient, is limited by its change with the last digit of the coefficients: its size is larger accordingly.
    Single rows in which a result is ill-conditioned are omitted, such as rows next to a jump.

    Returns `inputs`, shape (n_inputs, n). Returns `results`, shape (n, n_results). Returns `sizes`, shape (n_results,).
    """
    parameters = tire.parameters()
    parts, sizes = [], []
    well_conditioned = np.ones(inputs.shape[1], dtype=np.bool_)
    forces = _results(tire, program, "forces", (), inputs, parameters)
    signs = np.random.default_rng(0).choice([-1.0, 1.0], len(parameters))
    rounded = parameters * (1.0 + signs * np.finfo(float).eps)
    for routine in program.routines:
        values = _results(tire, program, routine.name, routine.labels, inputs, parameters)
        changed = _results(tire, program, routine.name, routine.labels, inputs, rounded)
        size = _typical(values)
        if routine.name == "jacobian_inputs":
            size += _force_per(forces, np.abs(inputs).max(axis=1))
        elif routine.name == "jacobian_parameters":
            size += _force_per(forces, np.abs(np.array([program.coefficients[label] for label in routine.labels])))
        needed = MARGIN * np.abs(changed - values) / TOLERANCE[routine.name]
        if routine.name == "quantities" and tire.values.get("Q_FZ2"):
            rounding = _rounding_of_deflection(tire, dict(zip(routine.labels, values.T, strict=True)))
            lost = np.array([rounding.get(label, 0.0) for label in routine.labels])
            size = np.maximum(size, MARGIN * lost / TOLERANCE[routine.name])
        size = np.maximum(size, 5 * np.median(needed, axis=0))
        well_conditioned &= (needed <= np.maximum(size, np.abs(values))).all(axis=1)
        parts.append(values)
        sizes.append(size)
    return inputs[:, well_conditioned], np.concatenate(parts, axis=1)[well_conditioned], np.concatenate(sizes)


def _results(
    tire: Tire, program: PrintedProgram, name: str, labels: Sequence[str], inputs: FloatArray, parameters: FloatArray
) -> FloatArray:
    """Return the results of one function, shape (rows, n_results)."""
    code = code_for(tire.symbolic_model, "numpy")
    if name == "states":
        return state_rates(tire, code, inputs, parameters, labels)
    inputs = inputs[: len(tire.inputs)]
    outputs = [tire.outputs.index(quantity.name) for quantity in program.outputs]
    if name == "forces":
        return code.forces(inputs, parameters)[outputs].T
    if name == "quantities":
        return code.quantities(inputs, parameters)[[code.quantities_names.index(label) for label in labels]].T
    if name == "jacobian_inputs":
        matrix = code.jacobian_inputs(inputs, parameters)[:, outputs]
        lagged = len(labels) - len(tire.inputs)  # the forces do not read them
        return np.pad(matrix, ((0, 0), (0, 0), (0, lagged))).reshape(inputs.shape[1], -1)
    columns = [list(tire.symbolic_model.coefficients).index(label) for label in labels]
    return code.jacobian_parameters(inputs, parameters)[:, outputs][:, :, columns].reshape(inputs.shape[1], -1)


def _rounding_of_deflection(tire: Tire, quantities: Mapping[str, FloatArray]) -> dict[str, float]:
    """Return the rounding errors of the quantities of MF-Tyre that lose digits if Q_FZ2 is small, as in files of MF5.2.

    The closed form of the deflection, R0 (sqrt(Q_FZ1^2 + 4 Q_FZ2 F) - Q_FZ1) / (2 Q_FZ2), subtracts almost equal
    numbers: every other order of roundings gives other digits, whatever the coefficients.
    """
    values = tire.values
    radius = values["UNLOADED_RADIUS"]
    linear = values["VERTICAL_STIFFNESS"] * radius / values["FNOMIN"]
    deflection = float(np.finfo(float).eps * radius * linear / abs(values["Q_FZ2"]))
    sizes = {"rho": deflection, "R_l": deflection}
    if "rho" in quantities and "c_z" in quantities and (loaded := quantities["rho"] > 0).any():
        # The load over the deflection.
        sizes["c_z"] = float(np.max(deflection * np.abs(quantities["c_z"][loaded] / quantities["rho"][loaded])))
    return sizes


def _typical(values: FloatArray) -> FloatArray:
    """Return the median size of the values of each column that are not 0, 1 if all are."""
    sizes = np.where(values == 0, np.nan, np.abs(values))
    sizes[0, np.isnan(sizes).all(axis=0)] = 1.0
    median: FloatArray = np.nanmedian(sizes, axis=0)
    return median


def _force_per(forces: FloatArray, arguments: FloatArray) -> FloatArray:
    ratios: FloatArray = 1e-2 * _typical(forces)[:, None] / np.where(arguments == 0, np.inf, arguments)
    return ratios.ravel()


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
        dict(zip(tire.symbolic_model.state_lines, code.state_lines(rows, parameters), strict=True))
        if tire.states
        else {}
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
