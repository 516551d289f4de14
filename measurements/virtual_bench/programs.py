"""Test programs of a bench: the inputs over time.

Programs use Fz > 0 as load and the TYDEX slip angle, so that their inputs are the same in ``iso`` and ``adapted-sae``.
The recording is written in the requested sign convention.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from math import radians

import numpy as np
import pandas as pd

from ...boundary.errors import DataError
from ...numerics.arrays import FloatArray
from ...symbolic.channels import INPUTS
from ...tires.signs import reversed_columns
from ..units import PSI

_Inputs = Mapping[str, float | FloatArray]
PAUSE = 5.0  # s between two sweeps, in which the bench sets the next operating condition and does not log
#: Held inputs of an FSAE TTC bench: 12 psi and 25 mph.
TTC_HELD: Mapping[str, float] = {"p": 12.0 * PSI, "V": 25.0 * 0.44704}
_DEGREES_PER_SECOND = radians(4.0)


@dataclass(frozen=True, eq=False)
class Program:
    """The inputs of a bench over time.

    Parameters
    ----------
    name : str
        Shown as the source of the recording.
    table : pandas.DataFrame
        ``t`` and inputs of the contract, in SI units, Fz > 0 as load.
    signs : str, optional
        The sign convention of the recording. Default: that of the tire.

    Raises
    ------
    DataError
        If there are no rows, a column is not an input, a value is not finite, or ``t`` is not ascending.
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
        unknown = [str(name) for name in self.table if name not in INPUTS]
        if unknown:
            raise DataError(f"program {self.name}: {unknown[0]!r} is not an input: known are {', '.join(INPUTS)}")
        if not np.isfinite(self.table.to_numpy(dtype=np.float64)).all():
            raise DataError(f"program {self.name}: an input is NaN or infinite")
        if not (np.diff(self.table["t"]) > 0.0).all():
            raise DataError(f"program {self.name}: t is not ascending")

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
        One sweep for each load and camber.
    cambers : iterable of float, rad
        Held during a sweep.
    amplitude : float, rad
        Largest slip angle.
    rate : float, rad/s
        Speed of the sweep.
    sample_rate : float, Hz
        Rows per second.
    kappa : float
        Constant longitudinal slip.
    held : mapping of str to float
        Further inputs and their constant values, such as p, V, T.
    name : str
        Of the program.

    Returns
    -------
    Program
        The camber changes least often.

    Examples
    --------
    >>> program = alpha_sweeps([220.0, 700.0], sample_rate=50.0)
    >>> len(program), list(program.table)
    (1202, ['t', 'kappa', 'alpha', 'gamma', 'Fz', 'p', 'V'])
    """
    clock, swept = _triangle(-amplitude, amplitude, rate, sample_rate)
    sweeps: Iterable[_Inputs] = (
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
        One sweep for each load, slip angle and camber.
    slip_angles, cambers : iterable of float, rad
        Held during a sweep.
    lowest, highest : float
        Turning points of kappa, on both sides of zero.
    rate : float, 1/s
        Speed of the sweep.
    sample_rate : float, Hz
        Rows per second.
    held : mapping of str to float
        Further inputs and their constant values, such as p, V, T.
    name : str
        Of the program.

    Returns
    -------
    Program
        The slip angle changes least often, then the camber.

    Examples
    --------
    >>> program = kappa_sweeps([220.0], slip_angles=[0.0, 0.05])
    >>> program.table["kappa"].agg(["min", "max"]).round(6).tolist()
    [-0.3, 0.3]
    """
    clock, swept = _triangle(lowest, highest, rate, sample_rate)
    sweeps: Iterable[_Inputs] = (
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
    """Return all combinations as steady points, one row each.

    Parameters
    ----------
    kappas : iterable of float
        Longitudinal slips; each combination of all values is one row.
    slip_angles : iterable of float, rad
        Slip angles.
    loads : iterable of float, N
        Loads.
    cambers : iterable of float, rad
        Inclinations.
    dwell : float, s
        Time between two points.
    held : mapping of str to float, optional
        Further inputs and their constant values.
    name : str
        Of the program.

    Returns
    -------
    Program
        kappa changes most often, then the slip angle.

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

    Slip angles of -20 to 20 deg in steps of 5 deg, loads of 60, 110 and 160 N, slips of -50 % to 100 %, no camber,
    30 psi: 297 steady points. The paper does not list its 11 slips. These are dense near free rolling and contain
    kappa = 0, because the paper fits the pure side force to the same points.

    Returns
    -------
    Program
        297 steady points.

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
    angles 0, -3, -6 deg of its bench files are in SAE, so they are 0, 3, 6 deg here. The pressure is 14 psi, the
    highest one, to which the report restricts its data (section 1.2.1).

    Parameters
    ----------
    sample_rate : float, Hz
        The default gives about 26,000 rows.
    signs : str, optional
        The sign convention of the recording. Default: that of the tire.

    Returns
    -------
    Program
        Sweeps of kappa and alpha at the loads and cambers of the report.

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
    """Return programs joined in sequence.

    Parameters
    ----------
    programs : sequence of Program
        All with the same inputs.
    name : str, optional
        Default: the names of the programs.
    signs : str, optional
        The sign convention of the recording. Default: that of the tire.

    Returns
    -------
    Program
        The rows of all programs, one after the other in time.

    Raises
    ------
    DataError
        If there is no program, or one has inputs that another lacks.

    Examples
    --------
    >>> both = concatenate([alpha_sweeps([900.0]), kappa_sweeps([900.0])])
    >>> both.name, len(both)
    ('alpha sweeps, kappa sweeps', 1802)
    """
    if not programs:
        raise DataError("no programs to join")
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


def _triangle(low: float, high: float, rate: float, sample_rate: float) -> tuple[FloatArray, FloatArray]:
    """Return clock and values of one sweep 0, high, low, 0."""
    if not (low <= 0.0 <= high and low < high and rate > 0.0 and sample_rate > 0.0):
        raise DataError(f"a sweep needs lowest <= 0 <= highest and positive rates: {low}, {high}, {rate}")
    corners = np.array([0.0, high, low, 0.0])
    times = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(corners)))]) / rate
    # Rounded, because rounding errors of the division would remove the last row.
    rows = int(np.floor(np.round(times[-1] * sample_rate, 6))) + 1
    clock = np.arange(rows) / sample_rate
    return clock, np.interp(clock, times, corners)


def _in_sequence(name: str, clock: FloatArray, sweeps: Iterable[_Inputs]) -> Program:
    """Return the sweeps in sequence, with pauses that are not logged."""
    tables = [
        pd.DataFrame({"t": clock + number * (clock[-1] + PAUSE), **inputs}) for number, inputs in enumerate(sweeps)
    ]
    if not tables:
        raise DataError(f"program {name}: no loads, no cambers or no slip angles")
    return Program(name, pd.concat(tables, ignore_index=True))
