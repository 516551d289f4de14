"""Comparison of an FMU with a recording and with its embedded tire."""

from __future__ import annotations

import os
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd

from ...boundary.errors import DataError, FmuError, path_from
from ...boundary.escaping import excerpt
from ...boundary.named_options import named
from ...measurements.checks.columns.check import check_columns
from ...measurements.checks.rows.coverage import outputs_without_slip
from ...measurements.recording import Recording
from ...measurements.table_argument import TableLike, recording_from
from ...tires import TABLE_INPUTS, TABLE_OUTPUTS, Tire
from ...tires.evaluation import Conventions, evaluate
from ...tires.property_file.names import unmeasured_outputs
from ...tires.signs import convert_signs
from ..simulation.archive import unpacked
from ..simulation.simulate import read_description, simulate
from .channel_errors import checked_channel
from .resources import axes_of_inputs, embedded_tire
from .result import CheckResult

FloatArray = npt.NDArray[np.float64]

#: Time step for a table without a column t, s.
STEP = 0.01
#: Largest number of characters of a unit.
LONGEST_UNIT = 20
#: Variables of an FMU that a message lists.
SHOWN_NAMES = 8


@named()
def check(
    fmu_path: str | os.PathLike[str],
    recording: TableLike,
    *,
    signs: str | None = None,
    tolerance: float | None = None,
    timeout: float | None = None,
) -> CheckResult:
    """Simulate an FMU over a recording and compare it with the data and with its embedded tire.

    The FMU may come from an untrusted source: it runs in a separate process, and `tirefmu.fmu.simulation.archive`
    limits its size. It still has the permissions of the user's own programs.

    The output of a row belongs to the inputs of that row. The inputs are constant over the step to the next row. The
    FMU is initialized again at the start of each segment of the recording, in steady state.

    Parameters
    ----------
    fmu_path : path-like
        An FMU for Co-Simulation with the input and output names of the tables, such as `export` writes.
    recording : Recording, DataFrame or path-like
        An input that it lacks has the FMU's start value. A column that the FMU lacks is ignored. NaN in an output means
        "not measured".
    signs : str, optional
        The convention of a file or a DataFrame; None for that of the file's format, or iso for a DataFrame.
    tolerance : float, optional
        Largest RMSE of a channel for `CheckResult.ok`, as a share of its largest measured magnitude.
    timeout : float, optional
        Time limit of the simulation, s; None for 60 s plus 5 ms per row.

    Returns
    -------
    CheckResult
        Errors of each channel, and whether the simulation agrees with direct evaluation.

    Raises
    ------
    FmuError
        If the FMU cannot be read, loaded or run, crashes, or exceeds the time limit.
    DataError
        If the recording cannot be read, has implausible units or signs, lacks an input in too many rows, or has none of
        the FMU's inputs or outputs.
    WrongType
        If the path or the recording is of another type.

    Examples
    --------
    >>> from tirefmu.tires import published
    >>> from tirefmu.fmu import export
    >>> tire = published("trento_hoosier").in_signs("iso")
    >>> table = pd.DataFrame({"alpha": [-0.1, 0.0, 0.1], "Fz": 900.0})
    >>> table["Fy"] = tire.forces(alpha=table["alpha"], Fz=900.0)["Fy"]
    >>> result = check(export(tire, "tire.fmu"), table)
    >>> result.ok, round(result.channels[0].r2, 6)
    (True, 1.0)
    """
    fmu_path = path_from(fmu_path, "fmu_path")
    given = recording_from(recording, signs=signs, parameter="recording")
    check_columns(given, fitted=False)
    given = given.with_signs("iso")
    table, segments = given.table, given.segments()
    with unpacked(fmu_path) as folder:
        description = read_description(fmu_path, folder)
        variables = {variable.name: variable for variable in description.modelVariables}
        axes = axes_of_inputs(folder, fmu_path)
        present, measured, outputs = compared_columns(variables, given, fmu_path)
        time = times_of(table)
        tire = embedded_tire(folder, fmu_path, outputs)
        rows = convert_signs(table, "iso", axes)[present].to_numpy(dtype=np.float64)
        simulation = simulate(fmu_path, folder, time, rows, present, outputs, segments, timeout)
    used = table[present].assign(t=time)
    inputs_of_runs = [used.iloc[segment] for segment in segments]
    simulated = convert_signs(pd.DataFrame(simulation.outputs, columns=outputs, index=table.index), axes, "iso")
    return CheckResult(
        fmu=Path(fmu_path).name,
        source=given.source,
        fmi_version=excerpt(description.fmiVersion),
        rows=len(table),
        segments=len(segments),
        channels=tuple(checked_channel(name, unit_of(variables[name]), table, simulated, present) for name in measured),
        evaluation_difference=None if tire is None else largest_difference(directly(tire, inputs_of_runs), simulated),
        problems=simulation.problems,
        tolerance=tolerance,
        simulated=simulated,
        recording=table[[*present, *measured]].assign(t=time),
        starts=tuple(segment.start for segment in segments),
        not_fitted=tuple(name for name in measured if tire is not None and name in unmeasured_outputs(tire)),
        without_slip=outputs_without_slip(given),
    )


def compared_columns(
    variables: Mapping[str, Any], recording: Recording, fmu_path: str | os.PathLike[str]
) -> tuple[list[str], list[str], list[str]]:
    """Return the inputs of an FMU and the measured outputs in a recording, and all outputs of the FMU.

    Raises `FmuError` if the FMU has no input or output with a name of `TABLE_INPUTS` or `TABLE_OUTPUTS`, `DataError` if
    the recording has none of those that the FMU has.
    """
    inputs, outputs = (
        columns_of(variables, names, kind) for names, kind in ((TABLE_INPUTS, "input"), (TABLE_OUTPUTS, "output"))
    )
    present = [name for name in inputs if name in recording.table]
    measured = [name for name in recording.measured() if name in outputs]
    sides = (("input", inputs, TABLE_INPUTS, present), ("measured output", outputs, TABLE_OUTPUTS, measured))
    for kind, needed, readable, recorded in sides:
        if not needed:
            causality = kind.split()[-1]
            names = [excerpt(name) for name, variable in variables.items() if variable.causality == causality]
            listed = f"{', '.join(names[:SHOWN_NAMES])}{', ...' if names[SHOWN_NAMES:] else ''}" or "none"
            proof = "; a proof inside it checks such an FMU (export --proof)" if kind == "input" else ""
            raise FmuError(
                f"{fmu_path}: no {causality} named {', '.join(readable)}: its {causality}s are {listed}{proof}"
            )
        if not recorded:
            raise DataError(f"{recording.source}: no {kind} of the FMU ({', '.join(needed)})")
    return present, measured, outputs


def unit_of(variable: Any) -> str:
    """Return the unit of a variable as declared by the FMU, limited in length."""
    return excerpt(variable.unit or "", LONGEST_UNIT)


def columns_of(variables: Mapping[str, Any], names: Iterable[str], causality: str) -> list[str]:
    """Return the names that are variables of the FMU with this causality."""
    return [name for name in names if name in variables and variables[name].causality == causality]


def times_of(table: pd.DataFrame) -> FloatArray:
    """Return the time of every row; equal steps for a table without times."""
    if "t" in table:
        return table["t"].to_numpy(dtype=np.float64)
    return STEP * np.arange(len(table), dtype=np.float64)


def directly(tire: Tire, runs: Iterable[pd.DataFrame]) -> pd.DataFrame:
    """Return the tire's outputs by direct evaluation of every run, with inputs constant over each step."""
    results = (evaluate(tire, run, Conventions(hold=True)) for run in runs)
    return pd.concat([result[list(tire.outputs)] for result in results], ignore_index=True)


def largest_difference(direct: pd.DataFrame, simulated: pd.DataFrame) -> float:
    """Return the largest |FMU - direct| / (1 + |direct|)."""
    worst = 0.0
    for name in simulated:
        expected = direct[name].to_numpy()
        # Equal if both are NaN or both are infinite: the formula gives such values.
        with np.errstate(invalid="ignore"):
            difference = np.abs(simulated[name].to_numpy() - expected) / (1.0 + np.abs(expected))
        same = np.isclose(simulated[name].to_numpy(), expected, rtol=0.0, atol=0.0, equal_nan=True)
        # Infinite if only one of them is a number.
        finite = np.where(same, 0.0, np.where(np.isnan(difference), np.inf, difference))
        worst = max(worst, float(np.max(finite, initial=0.0)))
    return worst
