"""Addition of a proof to an FMU."""

from __future__ import annotations

import hashlib
import json
import os
import zipfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from ...boundary.errors import FmuError, path_from
from ...boundary.named_options import named
from ...measurements.provenance import provenance
from ...measurements.recording import Recording
from ...measurements.table_argument import TableLike, recording_from
from ...tires import TABLE_INPUTS, TABLE_OUTPUTS, Tire
from ...tires.signs import convert_signs
from ..comparison.channel_errors import checked_channel
from ..comparison.check import columns_of, directly, times_of, unit_of
from ..comparison.compared import EVALUATION_TOLERANCE
from ..comparison.resources import declared_interface, embedded_tire
from ..packaging.export import write_zip
from ..simulation.archive import unpacked
from ..simulation.simulate import read_description, simulate
from . import layout
from .stimuli import proof_rows, stimuli


@named()
def add_proof(
    fmu_path: str | os.PathLike[str],
    recording: TableLike,
    path: str | os.PathLike[str] | None = None,
    *,
    signs: str | None = None,
    verdict: Sequence[str] | None = None,
) -> Path:
    """Add a proof to an FMU: stimuli, reference values, and digests of all files, in the layout of FMI-LS-REF.

    The layout, version 1.0.0-alpha.1, is experimental. The stimuli are rows of the recording, or a motion of the wheel
    that follows them. The reference of an FMU with slip inputs is the direct evaluation of its tire, that of other FMUs
    a simulation now. The proof has inputs of the recording but no measured outputs: it has their errors.

    Parameters
    ----------
    fmu_path : path-like
        An FMU that `export` wrote, with scalar inputs and a binary for this machine.
    recording : Recording, DataFrame or path-like
        At least one input of the FMU. At most about 2,000 of its rows are used, from all of its segments.
    path : path-like, optional
        The file to write; None: the FMU is replaced.
    signs : str, optional
        The convention of a file or a DataFrame, as in `check`.
    verdict : sequence of str, optional
        The verdict on the fit of the tire and its reasons, which the proof quotes.

    Returns
    -------
    Path
        The file written.

    Raises
    ------
    FmuError
        If the FMU cannot be read or run, has a proof already, has array inputs, or no tire; if the file cannot be
        written.
    DataError
        If the recording cannot be read.

    References
    ----------
    https://github.com/modelica/fmi-ls-ref

    Examples
    --------
    >>> from tirefmu.fmu import export, repeat_proof
    >>> table = pd.DataFrame({"alpha": [-0.1, 0.0, 0.1], "Fz": 900.0})
    >>> repeat_proof(add_proof(export("trento_hoosier", "tire.fmu"), table)).ok
    True
    """
    source = path_from(fmu_path, "fmu_path")
    given = recording_from(recording, signs=signs, parameter="recording").with_signs("iso")
    target = source if path is None else path_from(path)
    with unpacked(source) as folder:
        with zipfile.ZipFile(source) as archive:
            files = {name: archive.read(name) for name in archive.namelist() if not name.endswith("/")}
        if layout.PROOF in files:
            raise FmuError(f"{source}: has a proof already: export it again")
        added, content = _proof(source, folder, given)
    content["verdict"] = list(verdict or ())
    added[layout.PAGE] = layout.page(content)
    files |= added
    files[layout.INDEX] = files[layout.INDEX].replace(b"</body>", b'<p><a href="fmi-ls-ref.html">Proof</a></p></body>')
    content["files"] = {name: hashlib.sha256(part).hexdigest() for name, part in sorted(files.items())}
    files[layout.PROOF] = (json.dumps(content, indent=1, allow_nan=False) + "\n").encode()
    write_zip(target, files)
    return target


def _proof(source: Path, folder: Path, recording: Recording) -> tuple[dict[str, bytes], dict[str, Any]]:
    """Return the files of a proof, and the contents of proof.json without digests."""
    description, (inputs, axes) = read_description(source, folder), declared_interface(folder, source)
    variables = {variable.name: variable for variable in description.modelVariables}
    tire = embedded_tire(folder, source, columns_of(variables, TABLE_OUTPUTS, "output"))
    if tire is None or any(variable.dimensions for variable in variables.values() if variable.causality == "input"):
        raise FmuError(f"{source}: a proof needs scalar inputs and resources/tire.tir")
    starts = {n: float(v.start or 0.0) for n, v in variables.items() if v.causality == "input"}
    rows, first = proof_rows(recording)
    table = recording.table.iloc[rows].reset_index(drop=True)
    time = times_of(recording.table)[rows]
    runs = [slice(begin, end) for begin, end in zip(first, [*first[1:], len(rows)], strict=True)]
    driven = stimuli(table, starts, tire, inputs, axes)
    if inputs == "slip":
        present = [name for name in TABLE_INPUTS if name in driven]
        direct = directly(tire, [table[present].assign(t=time).iloc[run] for run in runs])
        reference = convert_signs(direct, "iso", axes)
    else:
        outputs = [n for n, v in variables.items() if v.causality == "output" and v.type in ("Real", "Float64")]
        simulated = simulate(source, folder, time, driven.to_numpy(), list(map(str, driven)), outputs, runs)
        reference = pd.DataFrame(simulated.outputs, columns=outputs)
    if not np.isfinite(reference.to_numpy()).all():
        raise FmuError(f"{source}: outputs over the table are not finite, so they prove nothing")
    content = {
        "format": layout.FORMAT, "layout": f"FMI-LS-REF {layout.LAYOUT} (experimental)",
        "reference": layout.DIRECT if inputs == "slip" else layout.SIMULATED, "inputs": inputs, "axes": axes,
        "tolerance": EVALUATION_TOLERANCE, "rows": len(rows), "segments": first, "ranges": _ranges(recording),
        "agreement": _agreement(tire, recording, variables), "tire": [list(row) for row in tire.about.items()],
        "provenance": [list(row) for row in provenance([recording])],
    }  # fmt: skip
    added = {
        layout.STIMULI: _csv(time, driven), layout.REFERENCE: _csv(time, reference), layout.MANIFEST: layout.manifest(),
        layout.SCRIPT: layout.script(),
    }  # fmt: skip
    return added, content


def _csv(time: Any, table: pd.DataFrame) -> bytes:
    """Return a table as CSV whose numbers are read back without a rounding error."""
    lines = [",".join(["time", *table])]
    lines += [",".join(map(repr, row)) for row in np.column_stack([time, table.to_numpy()]).tolist()]
    return ("\n".join(lines) + "\n").encode()


def _ranges(recording: Recording) -> list[list[Any]]:
    """Return name, smallest and largest value of each input of a recording, SI, ISO signs."""
    present = [name for name in TABLE_INPUTS if name in recording.table]
    return [[name, float(recording.table[name].min()), float(recording.table[name].max())] for name in present]


def _agreement(tire: Tire, recording: Recording, variables: Any) -> list[list[Any]]:
    """Return name, rows, RMSE, unit and R2 of each measured channel that the tire has, over all rows."""
    given = [name for name in tire.outputs if name in recording.table and recording.table[name].notna().any()]
    measured = [name for name in given if name in variables]
    if not measured:
        return []
    present = [name for name in TABLE_INPUTS if name in recording.table]
    used = recording.table[present].assign(t=times_of(recording.table))
    direct = directly(tire, [used.iloc[segment] for segment in recording.segments()])
    errors = [checked_channel(n, unit_of(variables[n]), recording.table, direct, present) for n in measured]
    return [[c.name, c.measured, c.rmse, c.unit, c.r2 if np.isfinite(c.r2) else None] for c in errors]
