"""Programs of a test bench: what it imposes on the wheel over time.

Programs are commanded with Fz > 0 as load and with the TYDEX alpha: the inputs of ``iso`` and of
``adapted-sae`` are the same. The bench writes its recording in whatever convention is asked for.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from math import radians

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from tirefmu.symbolic.errors import DataError
from tirefmu.tires.signs import reversed_columns

from ..channels import INPUTS
from ..units import PSI

_Imposed = Mapping[str, float | NDArray[np.float64]]
PAUSE = 5.0  # s, between two sweeps: the bench sets the next condition and does not log
#: What an FSAE TTC bench holds: 12 psi and 25 mph.
TTC_HELD: Mapping[str, float] = {"p": 12.0 * PSI, "V": 25.0 * 0.44704}
_DEGREES_PER_SECOND = radians(4.0)


@dataclass(frozen=True, eq=False)
class Program:
    """The inputs that a bench imposes.

    Parameters
    ----------
    name : str
    table : pandas.DataFrame
        ``t`` and inputs of the contract, in SI, Fz > 0 as load.
    signs : str, optional
        The convention in which the bench writes its recording; default the tire's own.

    Raises
    ------
    DataError
        If there are no rows, a column is no input, a value is not finite, or ``t`` does not ascend.
    UnknownName
        If the signs are not one of the three conventions.
    """

    name: str
    table: pd.DataFrame
    signs: str | None = None

    def __post_init__(self) -> None:
        if self.signs is not None:
            reversed_columns(self.signs, "iso")
        if self.table.empty or "t" not in self.table:
            raise DataError(f"program {self.name}: no rows, or no column t")
        strangers = [str(name) for name in self.table if name not in INPUTS]
        if strangers:
            raise DataError(f"program {self.name}: {strangers[0]!r} is no input: known are {', '.join(INPUTS)}")
        if not np.isfinite(self.table.to_numpy(dtype=np.float64)).all():
            raise DataError(f"program {self.name}: an input is NaN or infinite")
        if not (np.diff(self.table["t"]) > 0.0).all():
            raise DataError(f"program {self.name}: t does not ascend")

    def __len__(self) -> int:
        """Return the number of rows."""
        return len(self.table)


def alpha_sweeps(
    loads: Iterable[float],
    cambers: Iterable[float] = (0.0,),
    *,
    amplitude: float = radians(12.0),
    rate: float = _DEGREES_PER_SECOND,
    sample_rate: float = 100.0,
    kappa: float = 0.0,
    held: Mapping[str, float] = TTC_HELD,
    name: str = "alpha sweeps",
) -> Program:
    """Return slip angle sweeps 0, +amplitude, -amplitude, 0 at each load and camber.

    Parameters
    ----------
    loads : iterable of float, N
    cambers : iterable of float, rad
    amplitude : float, rad
    rate : float, rad/s
    sample_rate : float, Hz
    kappa : float
        Held.
    held : mapping of str to float
        Further inputs and their values, as p, V, T.
    name : str

    Returns
    -------
    Program
        The camber changes slowest.

    Examples
    --------
    >>> program = alpha_sweeps([220.0, 700.0], sample_rate=50.0)
    >>> len(program), list(program.table)
    (1202, ['t', 'kappa', 'alpha', 'gamma', 'Fz', 'p', 'V'])
    """
    clock, swept = _triangle(-amplitude, amplitude, rate, sample_rate)
    sweeps: Iterable[_Imposed] = (
        {"kappa": kappa, "alpha": swept, "gamma": camber, "Fz": load, **held}
        for camber, load in product(cambers, list(loads))
    )
    return _in_sequence(name, clock, sweeps)


def kappa_sweeps(
    loads: Iterable[float],
    slip_angles: Iterable[float] = (0.0,),
    cambers: Iterable[float] = (0.0,),
    *,
    lowest: float = -0.3,
    highest: float = 0.3,
    rate: float = 0.2,
    sample_rate: float = 100.0,
    held: Mapping[str, float] = TTC_HELD,
    name: str = "kappa sweeps",
) -> Program:
    """Return slip sweeps 0, highest, lowest, 0 at each load, camber and slip angle.

    Parameters
    ----------
    loads : iterable of float, N
    slip_angles, cambers : iterable of float, rad
    lowest, highest : float
        Turning points of kappa; zero lies between them.
    rate : float, 1/s
    sample_rate : float, Hz
    held : mapping of str to float
        Further inputs and their values, as p, V, T.
    name : str

    Returns
    -------
    Program
        The slip angle changes slowest, then the camber.

    Examples
    --------
    >>> program = kappa_sweeps([220.0], slip_angles=[0.0, 0.05])
    >>> program.table["kappa"].agg(["min", "max"]).round(6).tolist()
    [-0.3, 0.3]
    """
    clock, swept = _triangle(lowest, highest, rate, sample_rate)
    sweeps: Iterable[_Imposed] = (
        {"kappa": swept, "alpha": angle, "gamma": camber, "Fz": load, **held}
        for angle, camber, load in product(slip_angles, list(cambers), list(loads))
    )
    return _in_sequence(name, clock, sweeps)


def steady_points(
    kappas: Iterable[float],
    slip_angles: Iterable[float],
    loads: Iterable[float],
    cambers: Iterable[float] = (0.0,),
    *,
    dwell: float = 1.0,
    held: Mapping[str, float] | None = None,
    name: str = "steady points",
) -> Program:
    """Return all combinations as steady points, one reading each.

    Parameters
    ----------
    kappas : iterable of float
    slip_angles : iterable of float, rad
    loads : iterable of float, N
    cambers : iterable of float, rad
    dwell : float, s
        From one reading to the next.
    held : mapping of str to float, optional
        Further inputs and their values.
    name : str

    Returns
    -------
    Program
        kappa changes fastest, then the slip angle.

    Examples
    --------
    >>> len(steady_points([-0.1, 0.0, 0.1], [0.0, 0.1], [60.0, 110.0]))
    12
    """
    points = list(product(cambers, list(loads), list(slip_angles), list(kappas)))
    table = pd.DataFrame(points, columns=["gamma", "Fz", "alpha", "kappa"], dtype=np.float64)
    table = table.assign(t=dwell * np.arange(len(points)), **(held or {}))
    return Program(name, table[["t", "kappa", "alpha", "gamma", "Fz", *(held or {})]])


def small_tire_program() -> Program:
    """Return the program of the UNICAMP bench for small tires: 9 slip angles x 3 loads x 11 slips.

    -20 to 20 deg by 5, 60/110/160 N, -50 % to 100 %, no camber, 30 psi: 297 steady points. The paper does
    not print its 11 slips; these are dense near free rolling and hold kappa = 0, since it fits pure side
    force from the same points.

    Returns
    -------
    Program

    Examples
    --------
    >>> len(small_tire_program())
    297
    """
    kappas = (-0.5, -0.35, -0.2, -0.1, 0.0, 0.1, 0.2, 0.35, 0.5, 0.75, 1.0)
    angles = [radians(angle) for angle in range(-20, 21, 5)]
    loads = (60.0, 110.0, 160.0)
    return steady_points(kappas, angles, loads, held={"p": 30.0 * PSI}, name="small tire (UNICAMP)")


def trento_program(*, sample_rate: float = 50.0, signs: str | None = None) -> Program:
    """Return the program of the Trento report: lateral sweeps, then drive and brake sweeps.

    Lateral: 220, 440, 700, 900, 1120 N at 0, 1, 2, 3, 4 deg of camber, +-12 deg at 4 deg/s. Drive and brake:
    220, 700, 900, 1120 N at 0, 2, 4 deg of camber and three slip angles, kappa -0.3 to 0.3 at 0.2/s. The
    angles 0, -3, -6 deg of its bench files are SAE, so they are 0, 3, 6 deg here. 14 psi, the highest
    pressure, to which the report crops (its section 1.2.1).

    Parameters
    ----------
    sample_rate : float, Hz
        The default gives about 26 thousand rows.
    signs : str, optional
        The convention of the recording; default the tire's own.

    Returns
    -------
    Program

    Examples
    --------
    >>> len(trento_program())
    25861
    """
    held = {"p": 14.0 * PSI, "V": TTC_HELD["V"]}
    cambers = [radians(angle) for angle in range(5)]
    lateral = alpha_sweeps(
        (220.0, 440.0, 700.0, 900.0, 1120.0), cambers, sample_rate=sample_rate, held=held, name="lateral"
    )
    drive_brake = kappa_sweeps(
        (220.0, 700.0, 900.0, 1120.0), [radians(angle) for angle in (0, 3, 6)], cambers[::2],
        sample_rate=sample_rate, held=held, name="drive and brake",
    )  # fmt: skip
    return concatenate([lateral, drive_brake], name="Trento", signs=signs)


def concatenate(programs: Sequence[Program], *, name: str | None = None, signs: str | None = None) -> Program:
    """Return programs run one after the other.

    Parameters
    ----------
    programs : sequence of Program
        All with the same inputs.
    name : str, optional
        Default: their names, joined.
    signs : str, optional
        The convention of the recording; default the tire's own.

    Returns
    -------
    Program

    Raises
    ------
    DataError
        If there is none, or one imposes inputs that another lacks.

    Examples
    --------
    >>> both = concatenate([alpha_sweeps([900.0]), kappa_sweeps([900.0])])
    >>> both.name, len(both)
    ('alpha sweeps, kappa sweeps', 1802)
    """
    if not programs:
        raise DataError("no programs to run one after the other")
    tables: list[pd.DataFrame] = []
    start = 0.0
    for program in programs:
        missing = [name for name in INPUTS if (name in programs[0].table) != (name in program.table)]
        if missing:
            raise DataError(f"program {program.name}: input {missing[0]} is not in all programs")
        table = program.table.assign(t=program.table["t"] - program.table["t"].iloc[0] + start)
        start = float(table["t"].iloc[-1]) + PAUSE
        tables.append(table)
    joined = ", ".join(program.name for program in programs)
    return Program(name or joined, pd.concat(tables, ignore_index=True), signs)


def _triangle(
    low: float, high: float, rate: float, sample_rate: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Clock and values of one sweep 0, high, low, 0."""
    if not (low <= 0.0 <= high and low < high and rate > 0.0 and sample_rate > 0.0):
        raise DataError(f"a sweep needs lowest <= 0 <= highest, a rate and a sample rate: {low}, {high}, {rate}")
    corners = np.array([0.0, high, low, 0.0])
    times = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(corners)))]) / rate
    # Rounded, for the last row is wanted though the division ends an ulp short of a whole number.
    rows = int(np.floor(np.round(times[-1] * sample_rate, 6))) + 1
    clock = np.arange(rows) / sample_rate
    return clock, np.interp(clock, times, corners)


def _in_sequence(name: str, clock: NDArray[np.float64], sweeps: Iterable[_Imposed]) -> Program:
    """Return the sweeps one after the other, with pauses that are not logged."""
    tables = [
        pd.DataFrame({"t": clock + number * (clock[-1] + PAUSE), **imposed}) for number, imposed in enumerate(sweeps)
    ]
    if not tables:
        raise DataError(f"program {name}: no loads, no cambers or no slip angles")
    return Program(name, pd.concat(tables, ignore_index=True))
