"""Virtual test bench: applies a test program to a tire and records inputs and outputs with sensor noise."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np
import pandas as pd

from ...boundary.errors import DataError
from ...symbolic.channels import CHANNELS, OUTPUTS
from ...tires import Tire, tire_from
from ...tires.signs import convert_signs
from ..recording import Recording
from .programs import Program
from .sensor_noise import Noise


class TestedTire(Protocol):
    """The interface of a tire on the virtual bench."""

    @property
    def signs(self) -> str:
        """The convention in which the tire is evaluated."""

    @property
    def inputs(self) -> tuple[str, ...]:
        """The inputs of the tire."""

    def forces(self, **inputs: Any) -> Mapping[str, Any]:
        """Return the outputs by contract name, as arrays of the shape of the inputs."""


@dataclass(frozen=True)
class VirtualBench:
    """A simulated test bench for a tire with known coefficients.

    Parameters
    ----------
    tire : Tire, path of a .tir file, name of a published tire, or TestedTire
        The tire to measure, which is the truth.
    noise : Noise
        Of inputs and outputs. Default: similar to an FSAE TTC bench.
    seed : int
        The same seed gives the same recording. The noise of a channel does not depend on the other channels.

    Examples
    --------
    >>> from types import SimpleNamespace
    >>> def forces(alpha, Fz):
    ...     return {"Fy": -10.0 * alpha * Fz}
    >>> tire = SimpleNamespace(signs="iso", inputs=("alpha", "Fz"), forces=forces)
    >>> from tirefmu.measurements import alpha_sweeps
    >>> recording = VirtualBench(tire, Noise.none()).run(alpha_sweeps([900.0]))
    >>> recording.source, recording.signs, len(recording)
    ('virtual bench: alpha sweeps', 'iso', 1201)
    """

    tire: Any  # as given by the user; a TestedTire after initialization
    noise: Noise = field(default_factory=Noise)
    seed: int = 0

    def __post_init__(self) -> None:
        if not all(hasattr(self.tire, name) for name in ("signs", "inputs", "forces")):
            object.__setattr__(self, "tire", tire_from(self.tire))

    def run(self, program: Program) -> Recording:
        """Run a test program and return the recording.

        The tire is evaluated at the exact inputs; effects with memory act over the time of the program. Recorded inputs
        and outputs are noisy.

        Parameters
        ----------
        program : Program
            The inputs over time.

        Returns
        -------
        Recording
            In the sign convention of the program, by default that of the tire.

        Raises
        ------
        DataError
            If the tire has no output of the contract.
        """
        exact = self.truth(program)
        t = exact["t"].to_numpy(dtype=np.float64)
        recorded = exact.copy()
        for name in exact.columns.drop("t"):
            recorded[name] = self.noise.record(name, exact[name].to_numpy(dtype=np.float64), t, self._rng(name))
        signs = program.signs or self.tire.signs
        about = {"program": program.name, "seed": str(self.seed)}
        table = convert_signs(recorded, "iso", signs)
        return Recording(table, signs, f"virtual bench: {program.name}", about)

    def truth(self, program: Program) -> pd.DataFrame:
        """Return inputs and outputs without noise, in iso.

        Parameters
        ----------
        program : Program
            The inputs over time.

        Returns
        -------
        pandas.DataFrame
            Inputs and outputs without noise, ISO-W, SI.

        Raises
        ------
        DataError
            If the tire has no output of the contract.
        """
        imposed = convert_signs(program.table, "iso", self.tire.signs)
        inputs = {name: imposed[name].to_numpy(dtype=np.float64) for name in self.tire.inputs if name in imposed}
        if isinstance(self.tire, Tire) and (self.tire.states or self.tire.lags):
            forces = self.tire.evaluate(imposed, signs=self.tire.signs)
        else:
            forces = self.tire.forces(**inputs)
        outputs = {
            name: np.broadcast_to(np.asarray(forces[name], dtype=np.float64), len(imposed))
            for name in OUTPUTS
            if name in forces
        }
        if not outputs:
            raise DataError(f"virtual bench: the tire has none of the outputs {', '.join(OUTPUTS)}")
        return convert_signs(imposed.assign(**outputs), self.tire.signs, "iso")

    def _rng(self, name: str) -> np.random.Generator:
        """Return the random generator of a channel, which does not depend on the other channels."""
        return np.random.default_rng([self.seed, CHANNELS[name].stream])
