"""The sign convention of a recording, determined from the data: signs of the load and of the forces by their slips.

A tire opposes its slip, so the force of a slip has one sign in each convention. At small angles the pneumatic trail is
positive, which gives the sign of Mz. `convention_notes` compares these signs with the stated convention;
`check_convention` refuses a contradiction, because a fit to such data is meaningless.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from tirefmu.boundary.errors import DataError
from tirefmu.tires.signs import REVERSED, SIGNS

from ..recording import Recording, once
from ..thresholds import (
    MAX_WRONG_LOADS,
    MIN_SLIP_DEVIATION,
    SMALL_ANGLE,
    SMALL_SLIP,
    SPIKE_QUANTILE,
    STRONG_CORRELATION,
    WEAK_CORRELATION,
)

#: The slip of each channel, and the sign of its change with this slip in ISO.
_SIGN_IN_ISO = {"Fy": ("alpha", -1), "Mz": ("alpha", 1), "Fx": ("kappa", 1)}


def fitting_conventions(recording: Recording) -> tuple[str, ...]:
    """Return the conventions that agree with the data; all of them if nothing is swept.

    Parameters
    ----------
    recording : Recording
        Its stated convention is ignored.

    Returns
    -------
    tuple of str
        Names of the conventions; empty if no convention fits.

    Examples
    --------
    >>> import pandas as pd
    >>> sweep = pd.DataFrame({"alpha": [-0.1, 0.0, 0.1], "Fz": 900.0, "Fy": [-900.0, 0.0, 900.0]})
    >>> fitting_conventions(Recording(sweep, "iso", "a.csv"))
    ('adapted-sae',)
    """
    observed = _observed_signs(recording)
    return tuple(signs for signs in SIGNS if not _contradicting(observed, signs))


@once
def convention_notes(recording: Recording) -> list[str]:
    """Return a sentence if the data contradict the stated convention, or if Fx and Fy are exchanged.

    Parameters
    ----------
    recording : Recording
        With the convention that its file or caller states.

    Returns
    -------
    list of str
        At most one sentence; empty if the data agree with the convention, or no slip is swept.

    Examples
    --------
    >>> import pandas as pd
    >>> sweep = pd.DataFrame({"alpha": [-0.1, 0.0, 0.1], "Fz": 900.0, "Fy": [-900.0, 0.0, 900.0]})
    >>> convention_notes(Recording(sweep, "iso", "a.csv"))
    ['a.csv: Fy rises with alpha, in iso it falls: the data fit adapted-sae (--signs adapted-sae)']
    """
    exchanged = _exchanged_forces(recording)
    if exchanged:
        return [f"{recording.source}: {exchanged}: the columns Fx and Fy are exchanged"]
    observed, signs = _observed_signs(recording), recording.signs
    contradicting = _contradicting(observed, signs)
    if not contradicting:
        return []
    facts = "; ".join(_fact(name, observed[name], signs) for name in contradicting)
    fitting = fitting_conventions(recording)
    if fitting:
        advice = f"the data fit {' or '.join(fitting)} (--signs {fitting[0]})"
    else:
        advice = f"no convention fits: multiply {' and '.join(contradicting)} in the file by -1"
    return [f"{recording.source}: {facts}: {advice}"]


def check_convention(recording: Recording) -> None:
    """Refuse a recording whose data contradict its sign convention, or whose columns Fx and Fy are exchanged.

    Parameters
    ----------
    recording : Recording
        With the convention that its file or caller states.

    Raises
    ------
    DataError
        With the sentence of `convention_notes`.

    Examples
    --------
    >>> import pandas as pd
    >>> sweep = pd.DataFrame({"kappa": [-0.1, 0.0, 0.1], "Fx": [900.0, 0.0, -900.0]})
    >>> check_convention(Recording(sweep, "iso", "a.csv"))
    Traceback (most recent call last):
    ...
    tirefmu.boundary.errors.DataError: a.csv: Fx falls with kappa, in iso it rises: no convention fits: ...
    """
    for note in convention_notes(recording):
        raise DataError(note)


def _observed_signs(recording: Recording) -> dict[str, int]:
    """Return the sign of the load, and of the change of each force with its slip, as far as the data show them."""
    observed = {}
    if "Fz" in recording.table:
        load = recording.table["Fz"].to_numpy(dtype=np.float64)
        for sign in (1, -1):
            if len(load) and np.mean(sign * load > 0.0) > MAX_WRONG_LOADS:
                observed["Fz"] = sign
    for force, (slip, _) in _SIGN_IN_ISO.items():
        about_mean, about_zero = _correlations(recording, slip, force)
        # Beyond its peak a force falls with its slip but keeps its sign; an offset at a held slip has a sign but no
        # slope. Both are required.
        if about_mean * about_zero > 0.0 and min(abs(about_mean), abs(about_zero)) > STRONG_CORRELATION:
            observed[force] = int(np.sign(about_mean))
    return observed


def _expected_sign(name: str, signs: str) -> int:
    """Return the sign of the load, or of the change of a force with its slip, in a convention."""
    slip, sign = _SIGN_IN_ISO.get(name, ("", 1))
    reversed_names = REVERSED[signs]
    return sign if (name in reversed_names) == (slip in reversed_names) else -sign


def _contradicting(observed: dict[str, int], signs: str) -> list[str]:
    return [name for name, sign in observed.items() if sign != _expected_sign(name, signs)]


def _fact(name: str, sign: int, signs: str) -> str:
    """Return the observation on a channel that contradicts a convention."""
    if name == "Fz":
        observed, expected = ("positive", "negative") if sign > 0 else ("negative", "positive")
        return f"Fz is {observed}, in {signs} it is {expected}"
    observed, expected = ("rises", "falls") if sign > 0 else ("falls", "rises")
    slip = _SIGN_IN_ISO[name][0]
    where = " at small angles" if name == "Mz" else ""
    return f"{name} {observed} with {slip}{where}, in {signs} it {expected}"


def _exchanged_forces(recording: Recording) -> str:
    """Return the observation that a force follows the slip of the other force, which does not; empty if none does."""
    for slip, force, other in (("alpha", "Fy", "Fx"), ("kappa", "Fx", "Fy")):
        if force not in recording.table or recording.table[force].isna().all():
            continue
        strength = min(abs(r) for r in _correlations(recording, slip, other))
        if strength > STRONG_CORRELATION and abs(_correlations(recording, slip, force)[1]) < WEAK_CORRELATION:
            return f"{other} follows {slip} and {force} does not"
    return ""


def _correlations(recording: Recording, slip: str, force: str) -> tuple[float, float]:
    """Return the correlation of a slip with a force about their means and about zero; zeros if the slip is not swept.

    The largest and smallest forces are limited to a quantile, so that spikes have no influence.
    """
    table = recording.table
    if slip not in table or force not in table:
        return 0.0, 0.0
    x, y = (table[name].to_numpy(dtype=np.float64) for name in (slip, force))
    rows = np.isfinite(x) & np.isfinite(y)
    if force == "Mz":  # at larger slips the pneumatic trail vanishes, and Fx contributes to Mz
        rows &= np.abs(x) <= SMALL_ANGLE
        if "kappa" in table:
            rows &= np.abs(table["kappa"].to_numpy(dtype=np.float64)) <= SMALL_SLIP
    x, y = x[rows], y[rows]
    if len(x) < 3 or x.std() < MIN_SLIP_DEVIATION:
        return 0.0, 0.0
    y = np.clip(y, *np.quantile(y, [SPIKE_QUANTILE, 1.0 - SPIKE_QUANTILE]))
    return _cosine(x - x.mean(), y - y.mean()), _cosine(x, y)


def _cosine(x: npt.NDArray[np.float64], y: npt.NDArray[np.float64]) -> float:
    size = float(np.sqrt((x @ x) * (y @ y)))
    return float(x @ y) / size if size > 0.0 else 0.0
