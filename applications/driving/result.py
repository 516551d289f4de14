"""The answer to a drive: numbers for machines, tires and tables as files."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any, ClassVar

import numpy as np
import numpy.typing as npt
import pandas as pd

from ...boundary.errors import TirefmuError, path_from
from ...boundary.json_schema import document, json_value, schema_of
from ...measurements import Recording, write_table
from ...tires import Tire
from .estimate import Estimate
from .factors import Factor
from .inputs.car import Car
from .inputs.grid import Grid
from .inputs.log import Log
from .inputs.unknowns import AXLES, Unknowns
from .interval import OUTPUTS, UNCERTAIN
from .simulation import VehicleSimulation
from .trust.contradiction import Contradiction
from .verdict import CarFinding, DriveVerdict

FloatArray = npt.NDArray[np.float64]

#: Time between the last row of the front axle and the first one of the rear axle, s: a gap, so that they are segments.
GAP = 10.0


@dataclass(frozen=True)
class CarEntry:
    """An estimated entry of the car, in the unit of the car file, and what the file states."""

    value: float
    uncertainty: Annotated[float, "standard deviation"]
    given: float
    given_uncertainty: float


@dataclass(frozen=True)
class EstimatedCar:
    """Entries that contradict the car file, those to be checked, their joint deviation, and all that are estimated."""

    found: Sequence[CarFinding]
    check: Annotated[Sequence[CarFinding], "entries that may be wrong"]
    contradiction: Contradiction
    entries: Mapping[str, CarEntry]


@dataclass(frozen=True)
class SimulationErrors:
    """Root mean squares of the errors of the simulated vehicle by signal, as given and with the estimate."""

    before: Mapping[str, float]
    after: Mapping[str, float]
    fmus: Annotated[bool, "whether the tires of the vehicle were FMUs"]


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

    #: Version of drive.json. New keys increment the second number, changed meanings the first.
    version: ClassVar[str] = "3.2"
    JSON_KEYS: ClassVar = (
        "version", "ok", "written", "verdict.lines as verdict", "log.source as log", "duration", "factors",
        "verdict.tires as found", "unknown", "unexplained", "verdict.effect", "verdict.effects", "verdict.lacking",
        "estimated_car as car", "axle_forces", "correlations", "simulation", "verdict.left_out", "estimate.converged",
    )  # fmt: skip

    log: Log
    car: Car
    grid: Grid
    unknowns: Unknowns
    estimate: Estimate
    tires: Mapping[str, Tire]
    scaled: Mapping[str, Tire]
    factors: Annotated[Mapping[str, Mapping[str, Factor]], "scaling factors by axle and name"]
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

    @property
    def duration(self) -> float:
        """Time of the intervals, s."""
        return len(self.grid.t) * self.grid.step

    @property
    def unknown(self) -> bool:
        """Whether the tires do not explain the side force of an axle."""
        return bool(self.verdict.unknown)

    @property
    def unexplained(self) -> dict[str, float]:
        """Deviation of the balance of forces per load by axle."""
        return dict(zip(AXLES, self.estimate.unexplained[: len(AXLES)].tolist(), strict=True))

    @property
    def estimated_car(self) -> EstimatedCar:
        """The car that the drive shows, beside its file."""
        deviation = self.unknowns.spread * np.sqrt(np.diag(self.estimate.covariance))[: len(self.unknowns)]
        values = self.unknowns.car_values(self.car, self.estimate.z)
        entries = {
            name: CarEntry(values[name], float(sd), self.car.values[name], self.car.uncertainties[name])
            for name, sd in zip(self.unknowns.car, deviation, strict=False)
        }
        return EstimatedCar(self.verdict.car, self.verdict.check, self.verdict.contradiction, entries)

    @property
    def axle_forces(self) -> dict[str, dict[str, float]]:
        """Root mean squares of the lacking side force before and after, by axle, N."""
        return {
            name: dict(zip(AXLES, np.sqrt(np.mean(lacking**2, axis=0)).tolist(), strict=True))
            for name, lacking in zip(("before", "after"), self.lacking, strict=True)
        }

    @property
    def correlations(self) -> dict[str, dict[str, float]]:
        """Correlation of each determined factor with the entries of the car, where it exceeds 0.3."""
        deviation = np.sqrt(np.diag(self.estimate.covariance))
        correlation = self.estimate.covariance / np.outer(deviation, deviation)
        strong: dict[str, dict[str, float]] = {}
        for axle, name in self.unknowns.factors:
            if self.factors[axle][name].determined:
                row = correlation[self.unknowns.factor(axle, name)]
                pairs = zip(self.unknowns.car, row.tolist(), strict=False)
                strong[f"{name} {axle}"] = {entry: value for entry, value in pairs if abs(value) > 0.3}
        return {factor: pairs for factor, pairs in strong.items() if pairs}

    @property
    def simulation(self) -> SimulationErrors:
        """Errors of the simulated vehicle."""
        return SimulationErrors(self.before.rms, self.after.rms, self.after.fmus)

    def to_json(self) -> dict[str, Any]:
        """Return the contents of drive.json; a number that does not exist is null."""
        return dict(json_value(self))

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
                written.append(path)
                if self.after.fmus:
                    from ...fmu.packaging.export import export  # imports FMPy, which is large

                    written.append(export(path, path.with_suffix(".fmu")))
        except OSError as error:
            raise TirefmuError(f"{folder}: cannot be written ({error.strerror or error})") from error
        return written


def wheel_table(grid: Grid, outputs: FloatArray, deviation: FloatArray) -> pd.DataFrame:
    """Return the recording in ISO-W signs: rows of the front axle, then of the rear axle, whose time goes on.

    Columns: ``t kappa alpha gamma Fz V Fy``; the standard deviations ``Fy_sd`` (N) and ``alpha_sd`` (rad); ``axle`` 1
    for front and 2 for rear; ``t_log``, the time in the log, s. There is no Fx: kappa is the slip at which the tire has
    the force that the motion requires.
    """
    parts = []
    for number, axle in enumerate(AXLES):
        columns = {name: outputs[:, OUTPUTS.index(f"{name}_{axle}")] for name in ("kappa", "alpha", "Fz", "V", "Fy")}
        spread = {f"{name}_sd": deviation[:, UNCERTAIN.index(f"{name}_{axle}")] for name in ("Fy", "alpha")}
        start = number * (grid.t[-1] - grid.t[0] + GAP)
        table = pd.DataFrame(
            {"t": grid.t + start, **columns, "gamma": 0.0, **spread, "axle": number + 1, "t_log": grid.t}
        )
        parts.append(table[["t", "kappa", "alpha", "gamma", "Fz", "V", "Fy", "Fy_sd", "alpha_sd", "axle", "t_log"]])
    return pd.concat(parts, ignore_index=True)


def drive_schema() -> dict[str, Any]:
    """Return the JSON Schema of drive.json."""
    return document("drive", Drive.version, "Answer to a drive", schema_of(Drive, missing=True))
