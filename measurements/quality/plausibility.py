"""Is a recording what it says it is? Units and signs that cannot be meant, and signs that look odd."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from tirefmu.symbolic.errors import DataError

from ..channels import CHANNELS
from ..recording import Recording

#: What values beyond a channel's limits usually are.
_SUSPECTS = {
    "kappa": ("%", "in percent"),
    "alpha": ("deg", "in degrees"),
    "gamma": ("deg", "in degrees"),
    "V": ("km/h", "in km/h"),
    "T": ("K", "in kelvin"),
}
_SMALLEST_LOAD = 20.0  # N; the smallest tire known to us runs at 60 N, the heaviest truck tire at 60 kN
_SMALLEST_PRESSURE = 2e3  # Pa; a soft bicycle tire has 1e5, a balloon tire 1e4, and 250 psi is 250
_LOCKED = -1.05  # kappa of a locked wheel is -1
_BACKWARDS = 0.1  # of the rows: a bench that brakes into the lock overshoots now and then
_SMALL_ANGLE = 0.05  # rad: beyond, the trail vanishes and may turn its sign
_STRONG = 0.5  # a sweep correlates with its force by 0.8 and more


def check_plausible(recording: Recording) -> None:
    """Refuse a recording whose numbers cannot be in the declared units or signs.

    A unit that the file itself declares is believed.

    Parameters
    ----------
    recording : Recording

    Raises
    ------
    DataError
        One line for the first finding: angles in degrees, slip in percent, loads in kN, pressures in kPa,
        bar or psi, speeds in km/h, temperatures in kelvin, measured slips of a wheel that turns backwards, or
        loads of the wrong sign.

    Examples
    --------
    >>> import pandas as pd
    >>> check_plausible(Recording(pd.DataFrame({"alpha": [0.0, 12.0]}), "iso", "a.csv"))
    Traceback (most recent call last):
    ...
    tirefmu.symbolic.errors.DataError: a.csv: alpha reaches 12 rad: in degrees? declare it: 'alpha [deg]'
    """
    for finding in _findings(recording):
        raise DataError(f"{recording.source}: {finding}")


def _findings(recording: Recording) -> Iterator[str]:
    table = recording.table
    believed = recording.about.get("declared", "").split()
    for name, card in CHANNELS.items():
        if name not in table or name in believed:
            continue
        low, high = card.limits
        values = table[name].to_numpy(dtype=np.float64)
        outside = values[(values < low) | (values > high)]
        if len(outside):
            worst = outside[np.argmax(np.abs(outside))]
            unit, guess = _SUSPECTS.get(name, ("", "in another unit"))
            hint = f"declare it: '{name} [{unit}]'" if unit else "check the unit"
            yield f"{name} reaches {worst:.4g} {card.unit}: {guess}? {hint}".replace(" -:", ":")
    yield from _too_small(recording, believed)
    yield from _backward_wheel(recording, believed)
    yield from _wrong_load_sign(recording)


def _too_small(recording: Recording, believed: list[str]) -> Iterator[str]:
    table = recording.table
    if "Fz" in table and "Fz" not in believed:
        largest = float(table["Fz"].abs().max())
        if 0.0 < largest < _SMALLEST_LOAD:
            yield f"no |Fz| is above {largest:.4g} N: in kN? declare it: 'Fz [kN]' (or 'Fz [N]')"
    if "p" in table and "p" not in believed:
        middle = float(table["p"].median())
        if 0.0 < middle < _SMALLEST_PRESSURE:
            guess = "bar" if middle < 8.0 else "psi" if middle < 50.0 else "kPa"
            yield f"p is about {middle:.4g} Pa: in {guess}? declare it: 'p [{guess}]' (or 'p [Pa]')"


def _backward_wheel(recording: Recording, believed: list[str]) -> Iterator[str]:
    """Slips of a few percent, written as such, are within the limits: a wheel that turns backwards gives them away."""
    if "kappa" not in recording.table or "kappa" in believed or "Fx" not in recording.table:
        return
    kappa = recording.table["kappa"].to_numpy(dtype=np.float64)[recording.table["Fx"].notna().to_numpy()]
    share = float(np.mean(kappa < _LOCKED)) if len(kappa) else 0.0
    if share > _BACKWARDS:
        yield (
            f"kappa is below -1 in {100.0 * share:.0f} % of the rows where Fx was measured, a wheel that turns "
            f"backwards: in percent? declare it: 'kappa [%]' (or 'kappa [1]')"
        )


def _wrong_load_sign(recording: Recording) -> Iterator[str]:
    if "Fz" not in recording.table:
        return
    load = recording.table["Fz"].to_numpy(dtype=np.float64)
    expected = -1.0 if recording.signs == "sae" else 1.0
    share = float(np.mean(load * expected < 0.0))
    if share > 0.5:
        sign, advice = (
            ("positive", "not SAE? (--signs iso or adapted-sae)")
            if recording.signs == "sae"
            else ("negative", "SAE signs? (--signs sae)")
        )
        yield f"Fz is {sign} in {100.0 * share:.0f} % of the rows: {advice}"


def convention_notes(recording: Recording) -> list[str]:
    """Say where forces look as if they were written in another sign convention.

    A tire's side force opposes its slip angle: Fy falls with alpha in iso and sae, and rises in
    adapted-sae; its aligning moment turns it back: at small angles Mz rises with alpha in iso and sae, and
    falls in adapted-sae. Only a note: a tire with turned coefficients can do otherwise.

    Parameters
    ----------
    recording : Recording

    Returns
    -------
    list of str
        One sentence per channel that looks odd.

    Examples
    --------
    >>> import pandas as pd
    >>> sweep = pd.DataFrame({"alpha": [-0.1, 0.0, 0.1], "Fy": [-900.0, 0.0, 900.0]})
    >>> convention_notes(Recording(sweep, "iso", "a.csv"))
    ['a.csv: Fy rises with alpha, in iso it falls: the data look like adapted-sae']
    """
    notes = []
    source, signs = recording.source, recording.signs
    side = _correlation(recording, "alpha", "Fy")
    rises = signs == "adapted-sae"
    if abs(side) > _STRONG and (side > 0.0) != rises:
        seen, usual = ("rises", "falls") if side > 0.0 else ("falls", "rises")
        other = "iso" if rises else "adapted-sae"
        notes.append(f"{source}: Fy {seen} with alpha, in {signs} it {usual}: the data look like {other}")
    moment = _correlation(recording, "alpha", "Mz", _SMALL_ANGLE)
    if not notes and abs(moment) > _STRONG and (moment > 0.0) == rises:
        seen, usual = ("rises", "falls") if moment > 0.0 else ("falls", "rises")
        notes.append(f"{source}: Mz {seen} with alpha at small angles, in {signs} it {usual}: was its sign turned?")
    if _correlation(recording, "kappa", "Fx") < -_STRONG:
        notes.append(f"{source}: Fx falls with kappa, but kappa > 0 drives in every convention")
    return notes


def _correlation(recording: Recording, slip: str, force: str, largest: float = np.inf) -> float:
    """Correlation over the rows where the force was measured; 0 where nothing was swept."""
    if slip not in recording.table or force not in recording.table:
        return 0.0
    pair = recording.table[[slip, force]].dropna().to_numpy(dtype=np.float64)
    pair = pair[np.abs(pair[:, 0]) <= largest]
    # Sensor noise alone (0.02 deg, 0.002 of slip) is no sweep.
    if len(pair) < 3 or pair[:, 0].std() < 0.005 or pair[:, 1].std() == 0.0:
        return 0.0
    return float(np.corrcoef(pair.T)[0, 1])
