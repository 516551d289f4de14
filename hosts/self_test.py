"""The rows of a self-test: operating conditions and the results of tirefmu's NumPy code."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from tirefmu.symbolic.printers.languages.program import Program
from tirefmu.tires import Tire
from tirefmu.tires.code import code_for

FloatArray = npt.NDArray[np.float64]

#: The rows of the file that a printout contains.
ROWS = 40


def check_text(tire: Tire, program: Program, rows: int = ROWS, seed: int = 0) -> str:
    """Return the text of a self-test's file: numbers separated by blanks.

    The first is the number of rows. The second line has the typical size of each result: a difference is relative to
    it or to the result, whichever is larger.
    Each further line has the inputs and the results of a row.

    Parameters
    ----------
    tire : Tire
        In ISO-W.
    program : Program
    rows, seed : int

    Returns
    -------
    str
    """
    inputs = operating_conditions(tire, rows, seed)
    results, sizes = reference(tire, program, inputs)
    lines = [str(inputs.shape[1]), _numbers(sizes)]
    lines += [f"{_numbers(row)} {_numbers(values)}" for row, values in zip(inputs.T, results, strict=True)]
    return "\n".join(lines) + "\n"


def _numbers(values: Sequence[float] | FloatArray) -> str:
    return " ".join(repr(float(value)) for value in values)


def operating_conditions(tire: Tire, rows: int, seed: int = 0) -> FloatArray:
    """Return operating conditions, shape (n_inputs, rows): special ones first, then random ones.

    Special are zero slip, no load, a tenth and three times the nominal load, a locked and a spinning wheel, slip angles
    up to 1.2 rad, reverse, standstill.
    """
    rng = np.random.default_rng(seed)
    nominal = {name: tire.nominal(name) for name in tire.inputs}
    load = nominal["Fz"]
    special: list[dict[str, float]] = [
        {}, {"Fz": 0.0}, {"Fz": -0.1 * load}, {"Fz": 0.1 * load, "alpha": 0.1}, {"Fz": 3.0 * load, "kappa": -0.1},
        {"kappa": -1.0}, {"kappa": 2.0, "alpha": -0.2}, {"alpha": 1.2}, {"alpha": -1.2, "kappa": 0.5},
        {"V": -10.0, "alpha": 0.1, "kappa": 0.1}, {"V": 0.0, "alpha": 0.1, "kappa": 0.1}, {"V": -3.0, "gamma": 0.1},
        {"Fz": 0.0, "alpha": 0.1, "kappa": 0.1, "gamma": 0.1},
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
    return tire.effective_inputs(table.T).T


def reference(tire: Tire, program: Program, inputs: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return results by tirefmu's NumPy code, shape (rows, n_results), and the size of each result.

    A derivative may be a small difference of large terms: its size contains a hundredth of the force per argument.
    """
    code, parameters = code_for(tire.book, "numpy"), tire.parameters()
    outputs = [tire.outputs.index(quantity.name) for quantity in program.outputs]
    forces = code.forces(inputs, parameters)[outputs]
    parts, sizes = [], []
    for routine in program.routines:
        if routine.name == "forces":
            values = forces.T
        elif routine.name == "quantities":
            index = [code.quantities_names.index(label) for label in routine.labels]
            values = code.quantities(inputs, parameters)[index].T
        elif routine.name == "jacobian_inputs":
            values = code.jacobian_inputs(inputs, parameters)[:, outputs]
        else:
            columns = [list(tire.book.coefficients).index(label) for label in routine.labels]
            values = code.jacobian_parameters(inputs, parameters)[:, outputs][:, :, columns]
        parts.append(values.reshape(inputs.shape[1], -1))
        size = _typical(parts[-1])
        if routine.name == "jacobian_inputs":
            size += _force_per(forces, np.abs(inputs).max(axis=1))
        elif routine.name == "jacobian_parameters":
            size += _force_per(forces, np.abs(np.array([program.coefficients[label] for label in routine.labels])))
        sizes.append(size)
    return np.concatenate(parts, axis=1), np.concatenate(sizes)


def _typical(values: FloatArray) -> FloatArray:
    """Return the median size of the values of each column that are not 0, 1 if all are."""
    sizes = np.where(values == 0, np.nan, np.abs(values))
    sizes[0, np.isnan(sizes).all(axis=0)] = 1.0
    median: FloatArray = np.nanmedian(sizes, axis=0)
    return median


def _force_per(forces: FloatArray, arguments: FloatArray) -> FloatArray:
    ratios: FloatArray = 1e-2 * _typical(forces.T)[:, None] / np.where(arguments == 0, np.inf, arguments)
    return ratios.ravel()
