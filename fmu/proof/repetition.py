"""Repetition of the proof inside an FMU, and the verdict on the fit that the proof states."""

from __future__ import annotations

import hashlib
import json
import os
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import Any, ClassVar

import numpy as np
import pandas as pd

from ...boundary.bounded_file import read_bounded
from ...boundary.errors import FmuError, path_from
from ...boundary.escaping import excerpt, visible
from ...boundary.json_schema import json_value
from ...boundary.named_options import named
from ..comparison.check import largest_difference
from ..comparison.compared import EVALUATION_TOLERANCE
from ..simulation.archive import unpacked
from ..simulation.simulate import read_description, simulate
from . import layout

#: The largest file of a proof, bytes.
LARGEST = 20_000_000
#: Largest number of changed files that are listed.
MAX_NAMES = 5


@dataclass(frozen=True)
class ProofResult:
    """The result of `repeat_proof`.

    Attributes
    ----------
    fmu : str
        Name of the FMU.
    reference : str
        What computed the reference.
    digest : str
        SHA-256 of proof.json, which has the digests of all other files.
    changed : tuple of str
        Files that were changed, added or removed after the proof was written.
    rows : int
        Number of simulated rows; 0 if files were changed: such an FMU is not run.
    difference : float or None
        Largest |FMU - reference| / (1 + |reference|); None if it was not run.
    problems : tuple of str
        Problems found by fmpy's validation.
    """

    tolerance: ClassVar[float] = EVALUATION_TOLERANCE
    JSON_KEYS: ClassVar = (
        "ok", "fmu", "reference", "digest", "rows", "changed", "difference", "tolerance", "problems",
    )  # fmt: skip

    fmu: str
    reference: str
    digest: str
    changed: tuple[str, ...]
    rows: int = 0
    difference: float | None = None
    problems: tuple[str, ...] = ()

    @property
    def ok(self) -> bool:
        """True if no file was changed, the FMU is valid, and reproduces the reference."""
        accurate = self.difference is not None and self.difference <= EVALUATION_TOLERANCE
        return not self.changed and not self.problems and accurate

    def to_json(self) -> dict[str, Any]:
        """Return the result as plain values for json.dump; a difference that is not finite becomes None."""
        return dict(json_value(self))

    def __str__(self) -> str:
        lines = [f"verdict: proof {'repeated' if self.ok else 'failed'}"]
        if self.changed:
            more = len(self.changed) - MAX_NAMES
            shown = ", ".join(self.changed[:MAX_NAMES]) + (f" and {more} more" if more > 0 else "")
            lines.append(f"changed after the proof was written: {shown}. The FMU was not run")
        if self.difference is not None:
            lines.append(f"{self.rows} rows, largest relative difference from the reference: {self.difference:.1e}")
        lines += [f"invalid: {problem}" for problem in self.problems]
        lines += [f"reference: {self.reference}", f"digest of the proof: {self.digest}"]
        return "\n".join(visible(line) for line in lines)


@named()
def repeat_proof(fmu_path: str | os.PathLike[str], *, timeout: float | None = None) -> ProofResult:
    """Repeat the proof inside an FMU, which `add_proof` wrote.

    The digests of all files are compared first. An FMU with a changed file is not run. Digests detect changes, they do
    not identify an author: compare `ProofResult.digest` with the one that the author states.

    Parameters
    ----------
    fmu_path : path-like
        An FMU with a proof. It may come from an untrusted source, as in `check`.
    timeout : float, optional
        Time limit of the simulation, s, as in `check`.

    Returns
    -------
    ProofResult
        Changed files, and the difference from the reference.

    Raises
    ------
    FmuError
        If the FMU cannot be read or run, has no proof, or an invalid one.

    Examples
    --------
    >>> from tirefmu.fmu import add_proof, export
    >>> table = pd.DataFrame({"alpha": [-0.1, 0.0, 0.1], "Fz": 900.0})
    >>> repeat_proof(add_proof(export("trento_hoosier", "tire.fmu"), table)).ok
    True
    """
    source = path_from(fmu_path, "fmu_path")
    with unpacked(source) as folder:
        if not (folder / layout.PROOF).is_file():
            raise FmuError(f"{source}: has no proof: give a TABLE to compare it with, or export it with --proof TABLE")
        try:
            text = read_bounded(folder / layout.PROOF, LARGEST)
            proof = json.loads(text)
            if proof["format"] != layout.FORMAT:
                raise ValueError(f"format {proof['format']!r}, known is {layout.FORMAT}")
            changed, reference = _changed(folder, dict(proof["files"])), excerpt(str(proof["reference"]))
            digest = hashlib.sha256(text).hexdigest()
            if changed:
                return ProofResult(source.name, reference, digest, changed)
            driven, expected = (_table(folder / name) for name in (layout.STIMULI, layout.REFERENCE))
            runs = _runs(proof["segments"], driven, expected)
        except (OSError, ValueError, KeyError, TypeError, RecursionError) as error:
            raise FmuError(f"{source}: its proof is invalid ({excerpt(error)})") from error
        names = {variable.name for variable in read_description(source, folder).modelVariables}
        inputs, outputs = [list(map(str, table))[1:] for table in (driven, expected)]
        if unknown := {*inputs, *outputs} - names:
            raise FmuError(f"{source}: its proof is invalid (no variable {excerpt(min(unknown))})")
        time, rows = driven["time"].to_numpy(), driven[inputs].to_numpy()
        simulation = simulate(source, folder, time, rows, inputs, outputs, runs, timeout)
    difference = largest_difference(expected[outputs], pd.DataFrame(simulation.outputs, columns=outputs))
    return ProofResult(source.name, reference, digest, (), len(driven), difference, simulation.problems)


def _changed(folder: Path, digests: dict[str, str]) -> tuple[str, ...]:
    """Return the files of an unpacked FMU that differ from their digests, are new or are missing."""
    present = {
        path.relative_to(folder).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in folder.rglob("*")
        if path.is_file()
    }
    del present[layout.PROOF]
    return tuple(sorted({excerpt(name) for name, _ in present.items() ^ digests.items()}))


def _table(path: Path) -> pd.DataFrame:
    """Return a table of finite numbers with a first column ``time`` and distinct names."""
    content = read_bounded(path, LARGEST)
    header = content.partition(b"\n")[0].decode().strip().split(",")
    rows = np.loadtxt(BytesIO(content), delimiter=",", skiprows=1, ndmin=2)
    if header[0] != "time" or len(header) < 2 or len({*header}) != len(header) or not np.isfinite(rows).all():
        raise ValueError(f"{path.name} is no table of finite numbers over time")
    return pd.DataFrame(rows, columns=header)


def _runs(segments: list[int], driven: pd.DataFrame, expected: pd.DataFrame) -> list[slice]:
    """Return the rows of each segment, which together are all rows."""
    if not (segments and all(type(first) is int for first in segments)):
        raise ValueError("segments are no list of rows")
    ends = [*segments[1:], len(driven)]
    if len(driven) != len(expected) or segments[0] != 0 or any(a >= b for a, b in zip(segments, ends, strict=True)):
        raise ValueError("stimuli, reference and segments differ in their rows")
    return [slice(begin, end) for begin, end in zip(segments, ends, strict=True)]


def read_verdict(path: Path) -> tuple[str, ...]:
    """Return the verdict on a fit and its reasons.

    `path`: JSON of `tirefmu fit`. Raises `FmuError` if it is not that.
    """
    try:
        fit = json.loads(read_bounded(path, LARGEST))
        return (excerpt(str(fit["verdict"])), *(excerpt(str(reason)) for reason in fit["reasons"]))
    except OSError as error:
        raise FmuError(f"{path}: cannot be read ({error.strerror or error})") from error
    except (ValueError, KeyError, TypeError, RecursionError) as error:
        raise FmuError(f"{path}: not the JSON of a fit (no verdict with its reasons)") from error
