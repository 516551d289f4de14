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
from ...fmu.comparison.check import compared_columns, directly, largest_difference, times_of
from ...fmu.comparison.compared import EVALUATION_TOLERANCE
from ...fmu.simulation.simulate import loaded
from ...measurements import Recording, TableLike, recording_from, recordings_from
from ...measurements.recording import distinct
from ...measurements.turn_slip import with_turn_slip
from ...tires.tire import Tire
from ..verdict.result import Diagnosis


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

    `tire`: the one in the FMU, for direct evaluation. Returns: measured minus simulated by measured channel, ISO signs;
    the largest |FMU - direct| / (1 + |direct|).
    """
    recording = recording.with_signs("iso")
    table, time = recording.table, times_of(recording.table)
    cuts = [0, *(np.flatnonzero(np.diff(time) < 0.0) + 1).tolist(), len(table)]
    runs = [slice(first, last) for first, last in pairwise(cuts)]
    with loaded(path) as slave:
        variables = {variable.name: variable for variable in slave.description.modelVariables}
        present, measured, outputs = compared_columns(variables, recording, path)
        rows = table[present].to_numpy(dtype=np.float64)
        if not np.isfinite(rows).all():
            row, column = np.argwhere(~np.isfinite(rows))[0]
            raise DataError(f"{recording.source}: row {row + 1}: {present[column]} is not a finite number")
        simulated = pd.DataFrame(
            np.vstack([slave.run(run, time, rows, present, outputs) for run in runs]), columns=outputs
        )
    given = table[present].assign(t=time)
    difference = largest_difference(directly(tire, (given.iloc[run] for run in runs)), simulated)
    return table[measured] - simulated.set_index(table.index)[measured], difference


def _rms(error: pd.DataFrame) -> dict[str, float]:
    return {str(name): float(np.sqrt(np.nanmean(error[name] ** 2))) for name in error if error[name].notna().any()}
