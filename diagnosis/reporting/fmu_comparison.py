"""Both tires exported as FMUs and simulated by fmpy: errors on training and hold-out rows, and FMU against tire."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from ...boundary.errors import DataError
from ...fmu import export
from ...fmu.comparison.compared import EVALUATION_TOLERANCE
from ...fmu.simulation.simulate import loaded
from ...measurements import Recording, TableLike, recording_from, recordings_from
from ...measurements.recording import distinct
from ...measurements.turn_slip import with_turn_slip
from ...tires import TABLE_INPUTS
from ...tires.evaluation import Conventions, evaluate
from ...tires.tire import Tire
from ..verdict.result import Diagnosis

#: Time step of a table without a column t, s.
STEP = 0.01


def export_and_simulate(
    diagnosis: Diagnosis, recording: TableLike, folder: str | Path, others: TableLike | Iterable[TableLike] = ()
) -> dict[str, Any]:
    """Write base.fmu and improved.fmu, simulate both, and return the error of every measured channel.

    Inputs are constant over each step, and a gap in time is one long step. The simulation equals
    ``tirefmu evaluate --hold`` of the tire files to `tirefmu.fmu.comparison.compared.EVALUATION_TOLERANCE`.

    Parameters
    ----------
    diagnosis : Diagnosis
    recording : path, DataFrame or Recording
        The diagnosed recording.
    folder : str or Path
        Existing folder.
    others : path, DataFrame or Recording, or a sequence of them
        Additional recordings that the diagnosis did not use.

    Returns
    -------
    dict
        ``ok``; and ``before`` and ``after``, each with ``rmse`` (all rows), ``training``, ``holdout``, ``recordings``
        (by source), all by channel in N and N m, disturbances included, and ``difference_from_direct_evaluation``:
        the largest |FMU - evaluate --hold| / (1 + |evaluate --hold|).

    Raises
    ------
    DataError
        If an input is not finite, or no measured channel is an output of the tire.
    FmuError
        If an FMU cannot be built or run.
    """
    recording, additional = recording_from(recording, parameter="recording"), recordings_from(others)
    if "phit" in diagnosis.recording["derived_columns"]:
        recording, *additional = (with_turn_slip(simulated) for simulated in (recording, *additional))
    holdout = diagnosis.holdout_mask(len(recording))
    summary: dict[str, Any] = {}
    for when, tire, name in (("before", diagnosis.base_tire, "base"), ("after", diagnosis.tire, "improved")):
        path = export(replace(tire.in_signs("iso"), name=tire.name or name), Path(folder) / f"{name}.fmu", fmi=3)
        error, difference = simulated_error(path, tire, recording)
        summary[when] = {"rmse": _rms(error), "training": _rms(error[~holdout]), "holdout": _rms(error[holdout])}
        summary[when]["recordings"] = {}
        for source, other in zip(distinct([other.source for other in additional]), additional, strict=True):
            error, other_difference = simulated_error(path, tire, other)
            summary[when]["recordings"][source] = _rms(error)
            difference = max(difference, other_difference)
        summary[when]["difference_from_direct_evaluation"] = difference
    summary["ok"] = all(
        summary[when]["difference_from_direct_evaluation"] <= EVALUATION_TOLERANCE for when in ("before", "after")
    )
    return summary


def simulated_error(path: str | Path, tire: Tire, recording: Recording) -> tuple[pd.DataFrame, float]:
    """Simulate an FMU over a recording; a new run starts where time decreases.

    Parameters
    ----------
    path : str or Path
    tire : Tire
        The tire in the FMU, for direct evaluation.
    recording : Recording

    Returns
    -------
    DataFrame
        Measured minus simulated, ISO signs, by measured channel.
    float
        Largest |FMU - direct| / (1 + |direct|).
    """
    table = recording.with_signs("iso").table
    measured = [name for name in recording.measured() if name in tire.outputs]
    if not measured:
        raise DataError(f"{recording.source}: no measured output that the tire computes ({', '.join(tire.outputs)})")
    time = table["t"].to_numpy(dtype=np.float64) if "t" in table else STEP * np.arange(len(table), dtype=np.float64)
    cuts = [0, *(np.flatnonzero(np.diff(time) < 0.0) + 1).tolist(), len(table)]
    runs = [slice(first, last) for first, last in pairwise(cuts)]
    outputs = list(tire.outputs)
    with loaded(path) as slave:
        inputs = {variable.name for variable in slave.description.modelVariables if variable.causality == "input"}
        present = [name for name in TABLE_INPUTS if name in inputs and name in table]
        rows = table[present].to_numpy(dtype=np.float64)
        if not np.isfinite(rows).all():
            row, column = np.argwhere(~np.isfinite(rows))[0]
            raise DataError(f"{recording.source}: row {row + 1}: {present[column]} is not a finite number")
        simulated = np.vstack([slave.run(run, time, rows, present, outputs) for run in runs])
    given = table[present].assign(t=time)
    direct = np.vstack([evaluate(tire, given.iloc[run], Conventions(hold=True))[outputs].to_numpy() for run in runs])
    difference = float(np.max(np.abs(simulated - direct) / (1.0 + np.abs(direct))))
    answer = pd.DataFrame(simulated, columns=outputs, index=table.index)
    return table[measured] - answer[measured], difference if np.isfinite(difference) else float("inf")


def _rms(error: pd.DataFrame) -> dict[str, float]:
    return {str(name): float(np.sqrt(np.nanmean(error[name] ** 2))) for name in error if error[name].notna().any()}
