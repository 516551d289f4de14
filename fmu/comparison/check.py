"""An FMU held against a recording, and against the tire that it carries."""

from __future__ import annotations

import json
import os
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from math import isfinite, isnan, nan
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd

from tirefmu.measurements.table_argument import TableLike, recording_from
from tirefmu.symbolic.bounded_file import read_bounded
from tirefmu.symbolic.errors import DataError, FmuError, TirefmuError, path_from
from tirefmu.symbolic.escaping import excerpt, visible
from tirefmu.tires import TABLE_INPUTS, TABLE_OUTPUTS, Tire, read_tir
from tirefmu.tires.notebook import html_summary, html_table
from tirefmu.tires.signs import convert_signs

from .archive import unpacked
from .simulation import read_description, simulate

FloatArray = npt.NDArray[np.float64]

#: Largest |difference| / (1 + |direct|) between the FMU and its tire's own code.
EVALUATION_TOLERANCE = 1e-9
#: Step of a table without a column t, s.
STEP = 0.01
#: The largest resources/interface.json, bytes.
LARGEST_INTERFACE = 1_000_000
#: Characters of a unit that are shown.
LONGEST_UNIT = 20


@dataclass(frozen=True)
class WorstPoint:
    """Where a channel is farthest from the data.

    Attributes
    ----------
    row : int
        Of the recording, counted from 0.
    t : float or None
        s; None where the recording has no time.
    condition : mapping of str to float
        The inputs there, SI, ISO signs.
    measured, simulated : float
    """

    row: int
    t: float | None
    condition: Mapping[str, float]
    measured: float
    simulated: float


@dataclass(frozen=True)
class Channel:
    """How an output of the FMU compares with the data.

    Attributes
    ----------
    name, unit : str
    measured : int
        Number of rows that have a measured value.
    rmse : float
        Root mean squared error, in the channel's unit.
    relative_rmse : float
        The same as a share of the largest measured magnitude.
    r2, r2_uncentred : float
        1 - SSE / sum of squares about the mean, about zero; NaN where that sum is 0.
    worst : WorstPoint
    """

    name: str
    unit: str
    measured: int
    rmse: float
    relative_rmse: float
    r2: float
    r2_uncentred: float
    worst: WorstPoint


@dataclass(frozen=True, repr=False)
class CheckResult:
    """The answer of `check`.

    Attributes
    ----------
    fmu, source : str
        What was checked against what.
    fmi_version : str
    rows, segments : int
        Simulated rows, and the stretches that each began anew.
    channels : tuple of Channel
        Outputs of the FMU that were measured.
    evaluation_difference : float or None
        Largest |FMU - direct| / (1 + |direct|) over all rows and outputs, where direct is the evaluation of
        the tire that the FMU carries; None if it carries none.
    problems : tuple of str
        What fmpy's validation found wrong with the FMU.
    tolerance : float or None
        Largest `Channel.relative_rmse` asked for.
    simulated : pandas.DataFrame
        The FMU's outputs by row, ISO signs.
    recording : pandas.DataFrame
        The same rows of the recording: ``t`` (made up where there was none), inputs and measured outputs, ISO signs.
    starts : tuple of int
        The row at which each segment begins.
    """

    fmu: str
    source: str
    fmi_version: str
    rows: int
    segments: int
    channels: tuple[Channel, ...]
    evaluation_difference: float | None
    problems: tuple[str, ...]
    tolerance: float | None = None
    simulated: pd.DataFrame = field(default_factory=pd.DataFrame, repr=False)
    recording: pd.DataFrame = field(default_factory=pd.DataFrame, repr=False)
    starts: tuple[int, ...] = ()

    @property
    def ok(self) -> bool:
        """True if the FMU is valid, does what its tire says, and keeps the tolerance where one was given."""
        faithful = self.evaluation_difference is None or self.evaluation_difference <= EVALUATION_TOLERANCE
        near = self.tolerance is None or all(c.relative_rmse <= self.tolerance for c in self.channels)
        return not self.problems and faithful and near

    def to_json(self) -> dict[str, Any]:
        """Return the result as plain values for json.dump; NaN and infinity become None."""
        return {
            "fmu": self.fmu,
            "source": self.source,
            "fmi_version": self.fmi_version,
            "signs": "iso",
            "rows": self.rows,
            "segments": self.segments,
            "ok": self.ok,
            "tolerance": self.tolerance,
            "problems": list(self.problems),
            "evaluation_difference": self.evaluation_difference
            if isfinite(self.evaluation_difference or 0.0)
            else None,
            "channels": {channel.name: _channel_json(channel) for channel in self.channels},
        }

    def __repr__(self) -> str:
        """Return the comparison as a table of a few lines."""
        return str(self)

    def _repr_html_(self) -> str:
        """Return the same as HTML, for a notebook."""
        first, _, *rest = str(self).split("\n")
        rows = [(c.name, c.measured, c.rmse, c.unit, c.relative_rmse, c.r2, c.r2_uncentred) for c in self.channels]
        header = ["channel", "rows", "RMSE", "unit", "of max", "R2", "R2 uncentred"]
        return html_summary(first, html_table(header, rows), html_summary("\n".join(rest[len(rows) :])))

    def __str__(self) -> str:
        lines = [
            f"{self.fmu} (FMI {self.fmi_version}) against {self.source}: {self.rows} rows, "
            f"{self.segments} segment{'s'[: self.segments != 1]}, ISO signs",
            f"{'channel':<8}{'rows':>8}{'RMSE':>14}{'of max':>10}{'R2':>10}{'R2 uncentred':>14}  worst point",
        ]
        for channel in self.channels:
            worst = channel.worst
            at = ", ".join(f"{name} {value:.4g}" for name, value in worst.condition.items())
            lines.append(
                f"{channel.name:<8}{channel.measured:>8}{channel.rmse:>10.4g} {channel.unit:<3}"
                f"{channel.relative_rmse:>10.2%}{channel.r2:>10.4f}{channel.r2_uncentred:>14.4f}"
                f"  row {worst.row}: measured {worst.measured:.4g}, FMU {worst.simulated:.4g} at {at}"
            )
        if self.evaluation_difference is not None:
            lines.append(f"largest difference from direct evaluation: {self.evaluation_difference:.1e}")
        lines += [f"not valid: {problem}" for problem in self.problems] or ["fmpy's validation: no problems"]
        return "\n".join(visible(line) for line in lines)


def check(
    fmu_path: str | os.PathLike[str],
    recording: TableLike,
    *,
    signs: str | None = None,
    tolerance: float | None = None,
    timeout: float | None = None,
) -> CheckResult:
    """Simulate an FMU over a recording and compare it with the data and with its own tire.

    The FMU may come from anywhere: it runs in a process of its own, and `tirefmu.fmu.archive` bounds its size. It can
    still do what any program of the user's can.

    The output at a row belongs to the inputs of that row; inputs are held over the step to the next one.
    Each segment of the recording begins anew, in steady state.

    Parameters
    ----------
    fmu_path : path-like
        An FMU for Co-Simulation with inputs and outputs named as in the tables, such as `export` writes.
    recording : Recording, DataFrame or path-like
        An input that it lacks keeps the FMU's start value, one that the FMU lacks has no influence. NaN in
        an output is "not measured".
    signs : str, optional
        The convention of a file or a DataFrame; where None that of the file's format, for a DataFrame iso.
    tolerance : float, optional
        What `CheckResult.ok` asks of every channel: RMSE as a share of the largest measured magnitude.
    timeout : float, optional
        Time that the simulation may take, s; 60 s and 5 ms for each row where None.

    Returns
    -------
    CheckResult

    Raises
    ------
    FmuError
        If the FMU cannot be read, loaded or run, crashes or does not end in time.
    DataError
        If the recording cannot be read, is in units or signs that cannot be meant, has a NaN in an input, or
        none of the FMU's inputs or outputs.
    WrongType
        If the path or the recording is of another type.

    Examples
    --------
    >>> from tirefmu.tires import published
    >>> from .build import export
    >>> tire = published("trento_hoosier").in_signs("iso")
    >>> table = pd.DataFrame({"alpha": [-0.1, 0.0, 0.1], "Fz": 900.0})
    >>> table["Fy"] = tire.forces(alpha=table["alpha"], Fz=900.0)["Fy"]
    >>> result = check(export(tire, "tire.fmu"), table)
    >>> result.ok, round(result.channels[0].r2, 6)
    (True, 1.0)
    """
    fmu_path = path_from(fmu_path, "fmu_path")
    given = recording_from(recording, signs=signs, parameter="recording").with_signs("iso")
    table, segments = given.table, given.segments()
    with unpacked(fmu_path) as folder:
        description = read_description(fmu_path, folder)
        variables = {variable.name: variable for variable in description.modelVariables}
        inputs, outputs = (
            _columns(variables, TABLE_INPUTS, "input"),
            _columns(variables, TABLE_OUTPUTS, "output"),
        )
        present = [name for name in inputs if name in table]
        measured = [name for name in given.measured() if name in outputs]
        for kind, needed, found in (("input", inputs, present), ("measured output", outputs, measured)):
            if not found:
                raise DataError(f"{given.source}: no {kind} of the FMU ({', '.join(needed)})")
        time = _time(table)
        axes = _axes(folder, fmu_path)
        tire = _carried_tire(folder, fmu_path, outputs)
        rows = convert_signs(table, "iso", axes)[present].to_numpy(dtype=np.float64)
        simulation = simulate(fmu_path, folder, time, rows, present, outputs, segments, timeout)
    seen = table[present].assign(t=time)
    inputs_of_runs = [seen.iloc[segment] for segment in segments]
    simulated = convert_signs(pd.DataFrame(simulation.outputs, columns=outputs, index=table.index), axes, "iso")
    return CheckResult(
        fmu=Path(fmu_path).name,
        source=given.source,
        fmi_version=excerpt(description.fmiVersion),
        rows=len(table),
        segments=len(segments),
        channels=tuple(_channel(name, _unit(variables[name]), table, simulated, present) for name in measured),
        evaluation_difference=None if tire is None else _difference(_direct(tire, inputs_of_runs), simulated),
        problems=simulation.problems,
        tolerance=tolerance,
        simulated=simulated,
        recording=table[[*present, *measured]].assign(t=time),
        starts=tuple(segment.start for segment in segments),
    )


def _axes(folder: Path, fmu_path: str | os.PathLike[str]) -> str:
    """Return the convention of the FMU's inputs and outputs, or raise where it takes no slips."""
    path = folder / "resources" / "interface.json"
    place = f"{fmu_path}: resources/interface.json"
    if not path.is_file():
        return "iso"
    try:
        interface = json.loads(read_bounded(path, LARGEST_INTERFACE))
    except OSError as error:
        raise FmuError(f"{place}: {error.strerror or error}") from error
    except (ValueError, RecursionError) as error:
        raise FmuError(f"{place}: not JSON ({excerpt(error)})") from error
    if not isinstance(interface, dict):
        raise FmuError(f"{place}: not an object")
    if interface.get("inputs", "slip") != "slip":
        raise FmuError(
            f"{fmu_path}: it takes velocities of the wheel, and tables have slips: export it with slip inputs"
        )
    axes = interface.get("axes", "iso")
    if axes not in ("iso", "sae"):
        raise FmuError(f"{place}: unknown axes '{excerpt(axes)}': known are iso and sae")
    return str(axes)


def _carried_tire(folder: Path, fmu_path: str | os.PathLike[str], outputs: Iterable[str]) -> Tire | None:
    """Return the tire that the FMU says it is, if it brings one."""
    path = folder / "resources" / "tire.tir"
    if not path.is_file():
        return None
    try:
        tire = read_tir(path)
    except TirefmuError as error:
        raise FmuError(f"{fmu_path}: {str(error).replace(str(path), 'resources/tire.tir')}") from error
    missing = [name for name in outputs if name not in tire.outputs]
    if missing:
        raise FmuError(f"{fmu_path}: resources/tire.tir is of {tire.model}, which has no output {missing[0]}")
    return tire


def _unit(variable: Any) -> str:
    """Return the unit of a variable as the FMU writes it, for a table's column."""
    return excerpt(variable.unit or "", LONGEST_UNIT)


def _columns(variables: Mapping[str, Any], names: Iterable[str], causality: str) -> list[str]:
    """Return the columns of the tables that are variables of the FMU with this causality."""
    return [name for name in names if name in variables and variables[name].causality == causality]


def _time(table: pd.DataFrame) -> FloatArray:
    """Return the time of every row, made up where the table has none."""
    if "t" in table:
        return table["t"].to_numpy(dtype=np.float64)
    return STEP * np.arange(len(table), dtype=np.float64)


def _direct(tire: Tire, runs: Iterable[pd.DataFrame]) -> pd.DataFrame:
    """Return what the tire's own code makes of inputs that are held over each step, run after run."""
    return pd.concat([tire.evaluate(run, hold=True)[list(tire.outputs)] for run in runs], ignore_index=True)


def _difference(direct: pd.DataFrame, simulated: pd.DataFrame) -> float:
    """Return the largest |FMU - direct| / (1 + |direct|)."""
    worst = 0.0
    for name in simulated:
        expected = direct[name].to_numpy()
        # Equal where both are not a number or both infinite: then the formula says so.
        with np.errstate(invalid="ignore"):
            difference = np.abs(simulated[name].to_numpy() - expected) / (1.0 + np.abs(expected))
        same = np.isclose(simulated[name].to_numpy(), expected, rtol=0.0, atol=0.0, equal_nan=True)
        # Where only one of them is a number they differ without measure.
        told = np.where(same, 0.0, np.where(np.isnan(difference), np.inf, difference))
        worst = max(worst, float(np.max(told, initial=0.0)))
    return worst


def _channel(name: str, unit: str, table: pd.DataFrame, simulated: pd.DataFrame, inputs: list[str]) -> Channel:
    """Compare one output with the data where it was measured."""
    data, model = table[name].to_numpy(dtype=np.float64), simulated[name].to_numpy()
    rows = np.flatnonzero(~np.isnan(data))
    y, error = data[rows], model[rows] - data[rows]
    squared = float(error @ error)
    rmse = float(np.sqrt(squared / len(rows)))
    about_mean, about_zero = float(((y - y.mean()) ** 2).sum()), float((y**2).sum())
    largest = float(np.abs(y).max())
    worst = int(rows[np.argmax(np.abs(error))])  # argmax takes a NaN of the FMU for the largest
    return Channel(
        name,
        unit,
        len(rows),
        rmse,
        rmse / largest if largest else nan,
        1.0 - squared / about_mean if about_mean else nan,
        1.0 - squared / about_zero if about_zero else nan,
        WorstPoint(
            worst,
            float(table["t"].iloc[worst]) if "t" in table else None,
            {column: float(table[column].iloc[worst]) + 0.0 for column in inputs},
            float(data[worst]),
            float(model[worst]),
        ),
    )


def _channel_json(channel: Channel) -> dict[str, Any]:
    """Return a channel as plain values."""
    numbers = {name: getattr(channel, name) for name in ("rmse", "relative_rmse", "r2", "r2_uncentred")}
    worst = channel.worst
    return {
        "unit": channel.unit,
        "measured": channel.measured,
        **{name: None if isnan(value) else value for name, value in numbers.items()},
        "worst": {
            "row": worst.row,
            "t": worst.t,
            "condition": dict(worst.condition),
            "measured": worst.measured,
            "simulated": None if isnan(worst.simulated) else worst.simulated,
        },
    }
