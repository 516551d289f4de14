"""Refusal of a table whose columns mean something else than it claims, with the option that reads it correctly."""

from __future__ import annotations

import numpy as np

from ....boundary.errors import DataError
from ....numerics.ties import graded
from ....symbolic.channels import OUTPUTS
from ....tires.signs import REVERSED
from ...column_names import check_names
from ...recording import Recording, once
from .defects import defects, lost_signs, unmoved_slips
from .explanation import Readings, TableReading, explanation
from .traits import NOTABLE, SIZES

#: Facts in one message; the strongest ones.
MAX_FACTS = 3
#: Largest number of readings in one message.
MAX_READINGS = 3
#: The slip of each channel, and the sign of its change with this slip in ISO.
_SIGN_IN_ISO = {"Fy": ("alpha", -1), "Mz": ("alpha", 1), "Fx": ("kappa", 1)}


@once
def column_notes(recording: Recording, *, fitted: bool = True) -> list[str]:
    """Return a sentence for each way in which the columns of a recording are not what they claim to be.

    Parameters
    ----------
    recording : Recording
        With the signs and units that its file or caller states.
    fitted : bool
        Whether a tire is fitted to it: absent, constant and copied columns are then wrong as well.

    Returns
    -------
    list of str
        Empty if the claim stands. Otherwise each sentence has the facts, and the option that reads the table correctly.

    Examples
    --------
    >>> import numpy as np, pandas as pd
    >>> alpha = np.linspace(-0.2, 0.2, 99)
    >>> sweep = pd.DataFrame({"alpha": alpha, "Fz": 900.0, "Fy": 900.0 * np.tanh(15.0 * alpha)})
    >>> print(*column_notes(Recording(sweep, "iso", "a.csv")))
    a.csv: Fy rises with alpha, in iso it falls: the data fit adapted-sae (--signs adapted-sae), or alpha has ...
    """
    source = recording.source
    objections = list(defects(recording)) if fitted else []
    if objections:
        return [f"{source}: {text}" for text in objections]
    result = explanation(recording)
    exchanged = result.better and any(result.better[0].hypothesis.exchanges(name) for name in ("alpha", "Fx"))
    if fitted and not exchanged and (lost := [*unmoved_slips(recording), *lost_signs(recording)]):
        return [f"{source}: {text}" for text in lost]
    if result.better:
        return [f"{source}: {_facts(result, recording.signs)}: {_advice(result, recording.signs)}"]
    asserted = recording.about.get("asserted", "").split()
    wrong = [name for name in result.claimed.traits.contradictions if name in (*_SIGN_IN_ISO, "Fz")]
    signs = [name for name in wrong if name not in asserted]
    if signs:
        facts = "; ".join(_sign_fact(name, recording.signs) for name in signs)
        return [f"{source}: {facts}: no reading of the columns fits; check columns, units and signs of the file"]
    return []


def check_columns(recording: Recording, *, fitted: bool = True) -> None:
    """Refuse a recording whose columns are not what they claim to be: unit, sign, exchanged, constant or copied.

    Parameters
    ----------
    recording : Recording
        With the signs and units that its file or caller states.
    fitted : bool
        As for `column_notes`.

    Raises
    ------
    DataError
        With the first sentence of `column_notes`, or for a column that resembles an output that the table lacks.

    Examples
    --------
    >>> import numpy as np, pandas as pd
    >>> kappa = np.linspace(-0.2, 0.2, 99)
    >>> check_columns(Recording(pd.DataFrame({"kappa": kappa, "Fx": -9000.0 * kappa, "Fz": 900.0}), "iso", "a.csv"))
    Traceback (most recent call last):
    ...
    tirefmu.boundary.errors.DataError: a.csv: Fx falls with kappa, in iso it rises: ...
    """
    check_names(map(str, recording.table.columns), recording.source, OUTPUTS)
    for note in column_notes(recording, fitted=fitted):
        raise DataError(note)


def _facts(result: Readings, signs: str) -> str:
    """Return what the claimed reading has and no tire has, the strongest first."""
    best = result.better[0].traits.penalties
    claimed = result.claimed.traits
    gains = {name: penalty - best.get(name, 0.0) for name, penalty in claimed.penalties.items()}
    strongest = sorted(gains, key=lambda name: -graded(gains[name]))[:MAX_FACTS]
    texts = []
    for name in strongest:
        if name in claimed.contradictions:
            texts.append(_sign_fact(name, signs))
        elif abs(SIZES[name].deviation(claimed.sizes[name])) > NOTABLE and gains[name] > 0.0:
            size = SIZES[name]
            unit = f" {size.unit}".rstrip()
            texts.append(f"{size.text} is {claimed.sizes[name]:.3g}{unit} (tires: {size.typical})")
    return "; ".join(texts)


def _advice(result: Readings, signs: str) -> str:
    """Return the better reading with its options; several readings if they cannot be separated."""
    texts = [
        f"{candidate.hypothesis.described(signs)} ({candidate.hypothesis.advice(signs)}){_thrust(candidate)}"
        for candidate in result.better[:MAX_READINGS]
    ]
    if len(texts) == 1:
        other = next(iter(result.mirrored), None)
        if other is None:
            return texts[0]
        rival = f"that {other.hypothesis.described(signs)} ({other.hypothesis.advice(signs)}) is less probable"
        return f"{texts[0]}; {rival}{_thrust(other)}"
    decides = ""
    conventions = any(candidate.hypothesis.signs != signs for candidate in result.better)
    if conventions and not any(np.isfinite(candidate.traits.thrust) for candidate in result.better):
        decides = ": a sweep at camber decides (the side force points to the lean)"
    return f"{', or '.join(texts)}; the table does not show which{decides}"


def _thrust(candidate: TableReading) -> str:
    """Return the camber thrust of a reading with other signs, if the camber acts."""
    traits = candidate.traits
    if candidate.hypothesis.interpretation.units or not np.isfinite(traits.thrust):
        return ""
    gamma = traits.sizes["gamma"]
    force = f"{traits.thrust * gamma * traits.load:+.3g} N at {np.degrees(gamma):.3g} deg and {traits.load:.4g} N"
    return f", camber thrust {force} in iso, {'towards' if traits.thrust < 0.0 else 'away from'} the lean"


def _sign_fact(name: str, signs: str) -> str:
    """Return a contradiction in the signs of the table."""
    reversed_names = REVERSED[signs]
    if name == "Fz":
        observed, expected = ("positive", "negative") if "Fz" in reversed_names else ("negative", "positive")
        return f"Fz is {observed}, in {signs} it is {expected}"
    if name == "gamma":
        return "the camber thrust points away from the lean"
    if name not in _SIGN_IN_ISO:
        return name
    slip, sign = _SIGN_IN_ISO[name]
    expected_sign = sign if (name in reversed_names) == (slip in reversed_names) else -sign
    observed, expected = ("falls", "rises") if expected_sign > 0 else ("rises", "falls")
    where = " at small angles" if name == "Mz" else ""
    return f"{name} {observed} with {slip}{where}, in {signs} it {expected}"
