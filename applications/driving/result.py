"""The answer to a drive: numbers for machines, tires and tables as files."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any, TypedDict

import numpy as np
import numpy.typing as npt
import pandas as pd

from ...boundary.errors import TirefmuError, path_from
from ...boundary.json_schema import document, json_value, schema_of
from ...fmu.packaging.export import export
from ...measurements import Recording, write_table
from ...tires import Tire
from .estimate import Estimate
from .factors import Factor
from .inputs.car import Car
from .inputs.grid import Grid
from .inputs.log import Log
from .inputs.unknowns import AXLES, Unknowns
from .interval import OUTPUTS
from .simulation import VehicleSimulation
from .verdict import CarFinding, DriveVerdict, EffectFinding, TireDifference

FloatArray = npt.NDArray[np.float64]

#: Time between the last row of the front axle and the first one of the rear axle, s: a gap, so that they are segments.
GAP = 10.0


@dataclass(frozen=True, repr=False)
class Drive:
    """The answer to a drive.

    Parameters
    ----------
    log, car, grid, unknowns, estimate
        What was estimated from what.
    tires, scaled : mapping of str to Tire
        The tires of the axles "front" and "rear" as given, and with the determined factors and the effect that they
        lacked.
    factors : mapping of str to mapping of str to Factor
        By axle and name.
    wheels : pandas.DataFrame
        The forces at the wheels, ISO-W signs: `wheel_table`.
    before, after : Simulation
        The vehicle as given, and with the estimated car on the scaled tires.
    lacking : ndarray, shape (2, n, 2)
        Side force of each axle (last index) that the motion requires beyond the tires, as given and new, N.
    verdict : Verdict
        Findings and sentences.
    """

    log: Log
    car: Car
    grid: Grid
    unknowns: Unknowns
    estimate: Estimate
    tires: Mapping[str, Tire]
    scaled: Mapping[str, Tire]
    factors: Mapping[str, Mapping[str, Factor]]
    wheels: pd.DataFrame
    before: VehicleSimulation
    after: VehicleSimulation
    lacking: FloatArray
    verdict: DriveVerdict

    @property
    def ok(self) -> bool:
        """Whether the numbers can be used: the estimate converged, and does not contradict the car."""
        return self.estimate.converged and not self.verdict.contradiction.certain

    @property
    def written(self) -> bool:
        """Whether there are new tires: something was found of them, and they predict better what was left out."""
        return self.ok and self.verdict.better

    def __repr__(self) -> str:
        """Return the verdict."""
        return "\n".join(
            [f"Drive {self.log.source}: {len(self.grid.t)} intervals of {self.grid.step:g} s", *self.verdict.lines]
        )

    def recording(self) -> Recording:
        """Return the forces at the wheels as a recording, which `fit`, `inspect`, `diagnose` and `draw` accept."""
        return Recording(self.wheels, "iso", f"drive {Path(self.log.source).name}")

    def to_json(self) -> dict[str, Any]:
        """Return the contents of drive.json; a number that does not exist is null."""
        deviation = np.sqrt(np.diag(self.estimate.covariance))
        values = self.unknowns.car_values(self.car, self.estimate.z)
        entries: dict[str, CarEntry] = {
            name: {
                "value": values[name], "uncertainty": float(self.unknowns.spread[i] * deviation[i]),
                "given": self.car.values[name], "given_uncertainty": self.car.uncertainties[name],
            }
            for i, name in enumerate(self.unknowns.car)
        }  # fmt: skip
        contradiction, left_out = self.verdict.contradiction, self.verdict.left_out
        content: DriveContent = {
            "version": VERSION,
            "ok": self.ok,
            "written": self.written,
            "verdict": list(self.verdict.lines),
            "log": self.log.source,
            "duration": len(self.grid.t) * self.grid.step,
            "factors": self.factors,
            "found": self.verdict.tires,
            "unknown": bool(self.verdict.unknown),
            "unexplained": {axle: float(self.estimate.unexplained[i]) for i, axle in enumerate(AXLES)},
            "effect": self.verdict.effect,
            "effects": self.verdict.effects,
            "lacking": self.verdict.lacking,
            "car": {
                "found": self.verdict.car,
                "contradiction": {
                    "deviation": contradiction.deviation,
                    "p": contradiction.p,
                    "degrees_of_freedom": contradiction.degrees_of_freedom,
                    "unless": list(contradiction.unless),
                    "explained": contradiction.explained,
                },
                "entries": entries,
            },
            "left_out": {"before": left_out.before, "after": left_out.after, "better": left_out.better}
            if left_out
            else None,
            "axle_forces": {
                name: dict(zip(AXLES, np.sqrt(np.mean(lacking**2, axis=0)).tolist(), strict=True))
                for name, lacking in zip(("before", "after"), self.lacking, strict=True)
            },
            "correlations": self._correlations(),
            "simulation": {"before": self.before.rms, "after": self.after.rms, "fmus": self.after.fmus},
            "converged": self.estimate.converged,
        }
        return dict(json_value(content))

    def _correlations(self) -> dict[str, dict[str, float]]:
        """Return the correlation of each determined factor with the entries of the car, where it exceeds 0.3."""
        deviation = np.sqrt(np.diag(self.estimate.covariance))
        correlation = self.estimate.covariance / np.outer(deviation, deviation)
        strong: dict[str, dict[str, float]] = {}
        for axle, name in self.unknowns.factors:
            if self.factors[axle][name].determined:
                row = correlation[self.unknowns.factor(axle, name)]
                pairs = zip(self.unknowns.car, row.tolist(), strict=False)
                strong[f"{name} {axle}"] = {entry: value for entry, value in pairs if abs(value) > 0.3}
        return strong

    def save(self, folder: str | Path) -> list[Path]:
        """Write the recording and, if there are new tires (`written`), these into a folder.

        Parameters
        ----------
        folder : str or Path
            Created if it does not exist.

        Returns
        -------
        list of Path
            ``wheels.csv``, then ``front.tir`` and ``rear.tir``, each with its FMU if the vehicle was simulated on FMUs.

        Raises
        ------
        TirefmuError
            If a file cannot be written.
        """
        folder = path_from(folder, "folder")
        written = [folder / "wheels.csv"]
        try:
            folder.mkdir(parents=True, exist_ok=True)
            write_table(self.wheels, written[0])
            for axle in AXLES if self.written else ():
                path = folder / f"{axle}.tir"
                note = "; ".join(line for line in self.verdict.lines if line.startswith((axle, "the tires lack")))
                replace(self.scaled[axle], about={**self.scaled[axle].about, "drive": note}).save(path)
                written += [path, *([export(path, path.with_suffix(".fmu"))] if self.after.fmus else [])]
        except OSError as error:
            raise TirefmuError(f"{folder}: cannot be written ({error.strerror or error})") from error
        return written


def wheel_table(grid: Grid, estimate: Estimate) -> pd.DataFrame:
    """Return the recording in ISO-W signs: rows of the front axle, then of the rear axle, whose time goes on.

    Columns: ``t kappa alpha gamma Fz V Fy``; the standard deviations ``Fy_sd`` (N) and ``alpha_sd`` (rad); ``axle`` 1
    for front and 2 for rear; ``t_log``, the time in the log, s. There is no Fx: kappa is the slip at which the tire has
    the force that the motion requires.
    """
    deviation = np.sqrt(np.maximum(estimate.variances(estimate.outputs.jacobian), 0.0))
    parts = []
    for number, axle in enumerate(AXLES):
        columns = {
            name: estimate.outputs.values[:, OUTPUTS.index(f"{name}_{axle}")]
            for name in ("kappa", "alpha", "Fz", "V", "Fy")
        }
        spread = {f"{name}_sd": deviation[:, OUTPUTS.index(f"{name}_{axle}")] for name in ("Fy", "alpha")}
        start = number * (grid.t[-1] - grid.t[0] + GAP)
        table = pd.DataFrame(
            {"t": grid.t + start, **columns, "gamma": 0.0, **spread, "axle": number + 1, "t_log": grid.t}
        )
        parts.append(table[["t", "kappa", "alpha", "gamma", "Fz", "V", "Fy", "Fy_sd", "alpha_sd", "axle", "t_log"]])
    return pd.concat(parts, ignore_index=True)


#: Version of drive.json. New keys increment the second number, changed meanings the first.
VERSION = "3.0"


class CarEntry(TypedDict):
    """An estimated entry of the car, in the unit of the car file, and what the file states."""

    value: float
    uncertainty: Annotated[float, "standard deviation"]
    given: float
    given_uncertainty: float


class ContradictionContent(TypedDict):
    """The joint deviation of the entries of the car from their file, in the estimate without an effect."""

    deviation: Annotated[float, "chi-squared"]
    degrees_of_freedom: int
    p: Annotated[float, "probability of a larger deviation if the file is right"]
    explained: Annotated[bool, "whether another car would explain the drive"]
    unless: Annotated[list[str], "effects with which the car agrees with its file, if the tires lack one"]


class LeftOutContent(TypedDict):
    """Root mean squares of the errors of the simulated vehicle in parts that its estimate did not see, by signal."""

    before: Annotated[Mapping[str, float], "tires as given"]
    after: Annotated[Mapping[str, float], "new tires"]
    better: Annotated[bool, "whether the new tires are better, beyond the scatter over the parts"]


class CarContent(TypedDict):
    """Entries that contradict the car file, one by one and together, and all estimated entries by name."""

    found: Sequence[CarFinding]
    contradiction: ContradictionContent
    entries: dict[str, CarEntry]


class SimulationContent(TypedDict):
    """Root mean squares of the errors of the simulated vehicle by signal, as given and with the estimate."""

    before: Mapping[str, float]
    after: Mapping[str, float]
    fmus: Annotated[bool, "whether the tires of the vehicle were FMUs"]


class DriveContent(TypedDict):
    """The keys of drive.json; see `Drive`."""

    version: str
    ok: Annotated[bool, "whether the numbers can be used"]
    written: Annotated[bool, "whether there are new tires"]
    verdict: list[str]
    log: str
    duration: Annotated[float, "s"]
    factors: Annotated[Mapping[str, Mapping[str, Factor]], "scaling factors by axle and name"]
    found: Annotated[Sequence[TireDifference], "differences of the tires"]
    unknown: Annotated[bool, "whether the tires do not explain the side force of an axle"]
    unexplained: Annotated[dict[str, float], "deviation of the balance of forces per load by axle"]
    effect: Annotated[str | None, "of the library, that the new tires have"]
    effects: Annotated[Sequence[EffectFinding], "of the library, likely ones first"]
    lacking: Annotated[float, "probability that the tires lack an effect of the library"]
    car: CarContent
    axle_forces: Annotated[dict[str, dict[str, float]], "rms of lacking side force before and after, by axle, N"]
    correlations: Annotated[dict[str, dict[str, float]], "of determined factors with entries of the car, above 0.3"]
    simulation: SimulationContent
    left_out: LeftOutContent | None
    converged: bool


def drive_schema() -> dict[str, Any]:
    """Return the JSON Schema of drive.json."""
    return document("drive", VERSION, "Answer to a drive", schema_of(DriveContent, missing=True))
