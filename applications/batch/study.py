"""Studies: thousands of simulations of an FMU with other parameters, over one or several manoeuvres."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd

from ...boundary.errors import DataError, FmuError, UnknownName, path_from
from ...boundary.named_options import named
from ...fmu.comparison.resources import axes_of_inputs
from ...fmu.simulation.archive import unpacked
from ...fmu.simulation.simulate import read_description, simulate
from ...measurements import Recording, recording_from
from ...symbolic.channels import OUTPUTS
from ...tires.signs import convert_signs
from .execution import Lost, Progress, results
from .resumable import made_folder, write_table
from .study_file import Study, read_study

FloatArray = npt.NDArray[np.float64]

#: Simulated rows of a task: enough that starting its process does not count.
ROWS_OF_TASK = 200_000
#: What is stored of an output of a run.
STATISTICS: Mapping[str, Callable[[FloatArray], FloatArray]] = {
    "min": lambda x: x.min(axis=0), "max": lambda x: x.max(axis=0), "mean": lambda x: x.mean(axis=0),
    "rms": lambda x: np.sqrt(np.mean(x**2, axis=0)), "end": lambda x: x[-1],
}  # fmt: skip


@dataclass(frozen=True)
class StudyTask:
    """Some runs of a study: what a worker needs.

    - `first`: number of the first run.
    - `content`: the FMU.
    - `table`: time and inputs in the convention of the FMU.
    - `axes`: convention of the FMU.
    - `values`: parameters of each run.
    """

    first: int
    content: bytes
    table: pd.DataFrame
    outputs: tuple[str, ...]
    axes: str
    values: tuple[Mapping[str, float], ...]


@named()
def study(
    fmu: str | Path,
    plan: str | Path | Study,
    folder: str | Path,
    *,
    scheduler: str | None = None,
    workers: int | None = None,
    progress: Progress | None = None,
) -> pd.DataFrame:
    """Simulate an FMU with many values of its parameters.

    Parameters
    ----------
    fmu : path
        An FMU for Co-Simulation with slip inputs, such as `tirefmu.export` writes.
    plan : path or Study
        As for `read_study`.
    folder : path
        For ``study.parquet`` (without pyarrow ``study.csv``), and ``series-NUMBER.parquet`` if the study stores series.
    scheduler : str, optional
        Address of a Dask scheduler. Default: processes of this machine.
    workers : int, optional
        Number of local processes. Default: one for each processor.
    progress : callable, optional
        Called with the numbers of finished and of all runs.

    Returns
    -------
    pandas.DataFrame
        A row for each run: ``run``, ``table``, parameters, ``reason`` of a run that failed, and of each output minimum,
        maximum, mean, root mean square and last value (``Fy_max``), in ISO-W.

    Raises
    ------
    FmuError
        If the file is not such an FMU.
    FitError, UnknownName, DataError
        As for `read_study`; if a parameter or an output does not exist, or a table cannot be used.

    Examples
    --------
    docs/many_tires.md has a study with its results.

    >>> study("tire.fmu", "missing.toml", "runs")
    Traceback (most recent call last):
    tirefmu.boundary.errors.FitError: missing.toml: cannot be read (No such file or directory)
    """
    fmu, folder = path_from(fmu), path_from(folder)
    plan = plan if isinstance(plan, Study) else read_study(plan)
    if plan.series and not find_spec("pyarrow"):
        raise DataError("series are stored as Parquet: pip install 'tirefmu[parquet]'")
    recordings = [recording_from(table, signs=plan.signs) for table in plan.tables]
    tasks = list(_tasks(fmu, plan, recordings))
    made_folder(folder)
    rows: list[dict[str, Any]] = []
    finished, total = 0, len(recordings) * len(plan.values)
    for number, outcome in results(run, tasks, scheduler, workers):
        task = tasks[number]
        source = recordings[task.first // len(plan.values)].source
        if isinstance(outcome, Lost):
            outcome = [outcome.reason] * len(task.values)
        rows += _rows(task, source, outcome)
        if plan.series:
            write_table(_series(task, outcome), folder / f"series-{task.first:07d}.parquet")
        finished += len(task.values)
        if progress:
            progress(finished, total)
    table = pd.DataFrame(rows).sort_values("run", ignore_index=True)
    write_table(table, folder / ("study.parquet" if find_spec("pyarrow") else "study.csv"))
    return table


def _tasks(path: Path, study: Study, recordings: Sequence[Recording]) -> Iterator[StudyTask]:
    """Yield the tasks of a study; raise for parameters, inputs and outputs that the FMU lacks."""
    with unpacked(path) as folder:
        variables = {variable.name: variable for variable in read_description(path, folder).modelVariables}
        axes = axes_of_inputs(folder, path)
    reals = {name for name, variable in variables.items() if variable.type in ("Real", "Float64")}
    settable = [name for name in variables if name in reals and variables[name].causality == "parameter"]
    available = [name for name in variables if name in reals and variables[name].causality == "output"]
    for name in study.values[0]:
        if name not in settable:
            raise UnknownName(f"parameter of {path.name}", name, settable)
    for name in study.outputs:
        if name not in available:
            raise UnknownName(f"output of {path.name}", name, available)
    outputs = study.outputs or tuple(name for name in OUTPUTS if name in available)
    content = path.read_bytes()
    for number, recording in enumerate(recordings):
        table = recording.with_signs("iso").table
        inputs = [name for name in table if name in reals and variables[name].causality == "input"]
        if not inputs or "t" not in table:
            raise DataError(f"{recording.source}: {'no time' if inputs else 'no input of the FMU'}")
        given = convert_signs(table, "iso", axes)[["t", *inputs]]
        count = max(1, ROWS_OF_TASK // len(table))
        for first in range(0, len(study.values), count):
            values = study.values[first : first + count]
            yield StudyTask(number * len(study.values) + first, content, given, outputs, axes, values)


def run(task: StudyTask) -> list[FloatArray | str]:
    """Simulate the runs of a task, in any process.

    Returns shape (n_rows, n_outputs): of each run: outputs in ISO-W, or the reason why the FMU fails.
    """
    with TemporaryDirectory(prefix="tirefmu-") as scratch:
        path = Path(scratch, "study.fmu")
        path.write_bytes(task.content)
        with unpacked(path) as folder:
            return _simulated(task, path.name, folder, task.values)


def _simulated(
    task: StudyTask, name: str, folder: Path, values: Sequence[Mapping[str, float]]
) -> list[FloatArray | str]:
    """Simulate some runs; if the FMU fails, halves of them, so that one run does not cost the others."""
    inputs = [str(column) for column in task.table if column != "t"]
    time, rows = (task.table[columns].to_numpy(dtype=np.float64) for columns in ("t", inputs))
    runs = [slice(0, len(time))] * len(values)
    try:
        simulated = simulate(name, folder, time, rows, inputs, task.outputs, runs, starts=values).outputs
    except FmuError as error:
        if len(values) == 1:
            return [str(error)]
        middle = len(values) // 2
        return [run for half in (values[:middle], values[middle:]) for run in _simulated(task, name, folder, half)]
    outputs = convert_signs(pd.DataFrame(simulated, columns=list(task.outputs)), task.axes, "iso")
    return list(outputs.to_numpy().reshape(len(values), len(time), len(task.outputs)))


def _rows(task: StudyTask, source: str, outcome: Sequence[FloatArray | str]) -> Iterator[dict[str, Any]]:
    for i, (values, outputs) in enumerate(zip(task.values, outcome, strict=True)):
        reason = outputs if isinstance(outputs, str) else ""
        row: dict[str, Any] = {"run": task.first + i, "table": source, **values, "reason": reason}
        if not isinstance(outputs, str):
            for what, function in STATISTICS.items():
                row |= {f"{name}_{what}": float(x) for name, x in zip(task.outputs, function(outputs), strict=True)}
        yield row


def _series(task: StudyTask, outcome: Sequence[FloatArray | str]) -> pd.DataFrame:
    """Return the outputs of all runs over time, NaN for those that failed."""
    runs, n = len(outcome), len(task.table)
    missing = np.full((n, len(task.outputs)), np.nan)
    outputs = np.vstack([missing if isinstance(run, str) else run for run in outcome])
    columns = {"run": np.repeat(np.arange(task.first, task.first + runs), n), "t": np.tile(task.table["t"], runs)}
    return pd.DataFrame(columns | dict(zip(task.outputs, outputs.T, strict=True)))
