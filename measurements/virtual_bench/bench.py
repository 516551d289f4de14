"""The virtual bench: runs a program on a tire and records it with noise."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np
import pandas as pd

from tirefmu.symbolic.errors import DataError
from tirefmu.tires import tire_from
from tirefmu.tires.signs import convert_signs

from ..channels import CHANNELS, OUTPUTS
from ..recording import Recording
from .programs import Program
from .sensor_noise import Noise


class TestedTire(Protocol):
    """What the bench needs of a tire."""

    @property
    def signs(self) -> str:
        """The convention in which the tire is evaluated."""

    @property
    def inputs(self) -> tuple[str, ...]:
        """The inputs that the tire answers to."""

    def forces(self, **inputs: Any) -> Mapping[str, Any]:
        """Return the outputs by contract name, arrays like the inputs."""


@dataclass(frozen=True)
class VirtualBench:
    """A test bench made of numbers: the truth is known.

    Parameters
    ----------
    tire : Tire, path of a .tir file, name of a published tire, or TestedTire
    noise : Noise
        Of inputs and outputs; default about an FSAE TTC bench.
    seed : int
        The same seed gives the same recording. Each channel draws its own noise, whatever else is recorded.

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

    tire: Any  # of the user: a TestedTire once the bench is made
    noise: Noise = field(default_factory=Noise)
    seed: int = 0

    def __post_init__(self) -> None:
        if not all(hasattr(self.tire, name) for name in ("signs", "inputs", "forces")):
            object.__setattr__(self, "tire", tire_from(self.tire))

    def run(self, program: Program) -> Recording:
        """Run a program and return its recording.

        The tire answers to the inputs as imposed; what is recorded of them is noisy like the outputs.

        Parameters
        ----------
        program : Program

        Returns
        -------
        Recording
            In the program's signs, or where it names none, in the tire's.

        Raises
        ------
        DataError
            If the tire answers with no output of the contract.
        """
        true = self.truth(program)
        t = true["t"].to_numpy(dtype=np.float64)
        recorded = true.assign(
            **{
                name: self.noise.record(name, true[name].to_numpy(dtype=np.float64), t, self._rng(name))
                for name in true.columns
                if name != "t"
            }
        )
        signs = program.signs or self.tire.signs
        about = {"program": program.name, "seed": str(self.seed)}
        table = convert_signs(recorded, "iso", signs)
        return Recording(table, signs, f"virtual bench: {program.name}", about)

    def truth(self, program: Program) -> pd.DataFrame:
        """Return imposed inputs and true outputs, without noise, in iso.

        Parameters
        ----------
        program : Program

        Returns
        -------
        pandas.DataFrame

        Raises
        ------
        DataError
            If the tire answers with no output of the contract.
        """
        imposed = convert_signs(program.table, "iso", self.tire.signs)
        inputs = {name: imposed[name].to_numpy(dtype=np.float64) for name in self.tire.inputs if name in imposed}
        answer = self.tire.forces(**inputs)
        outputs = {
            name: np.broadcast_to(np.asarray(answer[name], dtype=np.float64), len(imposed))
            for name in OUTPUTS
            if name in answer
        }
        if not outputs:
            raise DataError(f"virtual bench: the tire answers with none of {', '.join(OUTPUTS)}")
        return convert_signs(imposed.assign(**outputs), self.tire.signs, "iso")

    def _rng(self, name: str) -> np.random.Generator:
        """Return the channel's own stream: recording one more channel changes no other."""
        return np.random.default_rng([self.seed, list(CHANNELS).index(name)])
