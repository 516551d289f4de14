"""What the residual of a fit still contains: the temperature of the tread, and a lag of the forces."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np
import pandas as pd

from ....numerics.arrays import FloatArray
from ....symbolic.channels import OUTPUTS
from ...operating_conditions.time_series import segments_of
from ...recording import Recording
from ...thresholds import MIN_EXPLAINED, MIN_TEMPERATURE_RANGE
from .finding import DataFinding

#: Effects that a diagnosis tests for each output.
_LAG_EFFECT = {"Fx": "relax_lon", "Fy": "relax_lat", "Mz": "relax_lat"}


def residual_findings(recordings: Sequence[Recording], predicted: Sequence[pd.DataFrame]) -> list[DataFinding]:
    """Return what the residuals of a tire show about temperature and lag.

    One linear regression of the residual on F (T - mean T), whose coefficient is a relative change of the force per
    kelvin, and on -dF/dt, whose coefficient is a delay. Each share is explained by this cause only.

    Parameters
    ----------
    recordings : sequence of Recording
        The data of the fit.
    predicted : sequence of pandas.DataFrame
        The outputs of the fitted tire for each row of each recording, in the signs of the recording.

    Returns
    -------
    list of DataFinding
        One for each recording and cause.

    Examples
    --------
    >>> clock = np.arange(4000) / 100.0
    >>> alpha = 0.1 * np.sin(2.0 * np.pi * clock / 8.0)
    >>> force = pd.DataFrame({"Fy": -9e3 * alpha})
    >>> late = pd.DataFrame({"t": clock, "alpha": alpha, "Fy": np.interp(clock - 0.05, clock, force["Fy"])})
    >>> print(*residual_findings([Recording(late, "iso", "a.csv")], [force]))  # doctest: +ELLIPSIS
    a.csv: the residual of Fy is like a lag of 50 ms (... % of its mean square)
    """
    findings: list[DataFinding] = []
    for recording, forces in zip(recordings, predicted, strict=True):
        causes: dict[str, dict[str, tuple[float, float]]] = {"temperature": {}, "lag": {}}
        for name in OUTPUTS:
            if name in recording.table and name in forces:
                for kind, coefficient, share in _causes(recording, name, forces[name].to_numpy(dtype=np.float64)):
                    causes[kind][name] = coefficient, share
        findings += [_finding(recording.source, kind, measured) for kind, measured in causes.items() if measured]
    return findings


def _finding(source: str, kind: str, measured: Mapping[str, tuple[float, float]]) -> DataFinding:
    """Return the finding on a cause: its coefficient and the share that it explains, by channel."""
    several, percent = len(measured) > 1, {name: f"{100.0 * share:.0f} %" for name, (_, share) in measured.items()}
    residuals = f"the residual{'s' * several} of {' and '.join(measured)}"
    if kind == "temperature":
        follow = f"follow{'s' * (not several)} the tread temperature, or what changes with it,"
        sizes = [f"a change of {name} by {100.0 * size:+.2f} % per K" for name, (size, _) in measured.items()]
        effects: tuple[str, ...] = ("temp_friction", "temp_stiffness")
    else:
        follow = "are" if several else "is"
        sizes = [f"a lag of {1e3 * size:.0f} ms" for size, _ in measured.values()]
        effects = tuple(dict.fromkeys(_LAG_EFFECT[name] for name in measured))
    shares = f"{' and '.join(percent.values())} of {'their' if several else 'its'} mean square"
    return DataFinding(kind, f"{source}: {residuals} {follow} like {' and '.join(sizes)} ({shares})", effects=effects)


def _causes(recording: Recording, name: str, force: FloatArray) -> Iterator[tuple[str, float, float]]:
    """Yield kind, coefficient and explained share of each cause of a channel that matters."""
    residual = recording.table[name].to_numpy(dtype=np.float64) - force
    causes: dict[str, FloatArray] = {}
    if "T" in recording.table:
        temperature = recording.table["T"].to_numpy(dtype=np.float64)
        low, high = np.nanquantile(temperature, (0.05, 0.95))
        if high - low > MIN_TEMPERATURE_RANGE:
            causes["temperature"] = force * (temperature - np.nanmean(temperature))
    if name in _LAG_EFFECT:
        causes["lag"] = -_rate(recording, force)
    for kind, (coefficient, share) in _explained(residual, causes).items():
        if share > MIN_EXPLAINED and (kind == "temperature" or coefficient > 0.0):
            yield kind, coefficient, share


def _explained(residual: FloatArray, causes: Mapping[str, FloatArray]) -> dict[str, tuple[float, float]]:
    """Return the regression coefficient of each cause, and the share of the mean square that only it explains."""
    rows = np.isfinite(residual)
    for cause in causes.values():
        rows &= np.isfinite(cause)
    r, x = residual[rows], {name: cause[rows] for name, cause in causes.items() if np.any(cause[rows])}
    total = float(r @ r)
    if not total > 0.0 or not x:
        return {}
    columns = np.stack(list(x.values())).T
    coefficients, least = _regression(columns, r)
    without = [_regression(np.delete(columns, k, axis=1), r)[1] for k in range(len(x))]
    return {
        name: (float(coefficient), (more - least) / total)
        for name, coefficient, more in zip(x, coefficients, without, strict=True)
    }


def _regression(columns: FloatArray, r: FloatArray) -> tuple[FloatArray, float]:
    """Return the coefficients of a linear regression and the remaining sum of squares."""
    coefficients, *_ = np.linalg.lstsq(columns, r, rcond=None)
    rest = r - columns @ coefficients
    return np.asarray(coefficients, dtype=np.float64), float(rest @ rest)


def _rate(recording: Recording, force: FloatArray) -> FloatArray:
    """Return the derivative of the force by time over a few samples; NaN where the rows are not a time series."""
    rate = np.full(len(force), np.nan)
    for segment in segments_of(recording) if "t" in recording.table else ():
        if segment.is_series:
            rows = segment.rows
            kernel = np.array([1.0, 1.0, 1.0, 0.0, -1.0, -1.0, -1.0]) / (12.0 * segment.interval)
            rate[rows.start + 3 : rows.stop - 3] = np.convolve(force[rows], kernel, mode="valid")
    return rate
