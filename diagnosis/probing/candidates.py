"""The effects that a diagnosis knows how to try: their coefficients, sizes to probe with, and what they need."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

from tirefmu.symbolic.added import AddedEffect
from tirefmu.symbolic.model import Model
from tirefmu.symbolic.notation import Coefficient
from tirefmu.tires.tire import Tire

from ..recording.signals import Signals

Probe = Mapping[str, float]


@dataclass(frozen=True)
class Shape:
    """One functional form of an effect.

    Attributes
    ----------
    free : tuple of str
        The coefficients that it fits.
    probes : tuple of dict of str to float
        Sizes that nature knows, from which its traces are computed; each is a trace of its own.
    scalable : bool
        Whether half the coefficients make half the effect; otherwise the probes themselves are starts.
    """

    free: tuple[str, ...]
    probes: tuple[Probe, ...]
    scalable: bool = True


@dataclass(frozen=True)
class Candidate:
    """An effect that may be missing.

    Attributes
    ----------
    name : str
    shapes : tuple of Shape
        From the plainest to the richest.
    varies : tuple of str
        Inputs that have to vary (each of them).
    channels : tuple of str
        It shows in one of these.
    part_of : str
        An effect that this one contains, or ''.
    """

    name: str
    shapes: tuple[Shape, ...]
    varies: tuple[str, ...]
    channels: tuple[str, ...]
    part_of: str = ""


def _each(**sizes: float) -> Shape:
    """Return a shape whose coefficients act each for itself."""
    return Shape(tuple(sizes), tuple({name: size} for name, size in sizes.items()))


_FXY, _FYZ, _FXYZ = ("Fx", "Fy"), ("Fy", "Mz"), ("Fx", "Fy", "Mz")

_CONTRACT = (
    Candidate("load_friction", (_each(PDY2=-0.15, PDX2=-0.15),), ("Fz",), _FXY),
    Candidate(
        "load_stiffness", (Shape(("PKY2",), ({"PKY2": 1.6}, {"PKY2": 3.0}), scalable=False),), ("Fz", "alpha"), _FYZ
    ),
    Candidate("load_curvature", (_each(PEY2=-0.5, PEX2=-0.5),), ("Fz",), _FXY),
    # PHY3 is MF96's and MF5.2's; a model tries those of the coefficients that it has.
    Candidate("camber_thrust", (_each(PKY6=1.0, PVY3=0.3, PHY3=0.03),), ("gamma",), _FYZ),
    Candidate("camber_stiffness", (_each(PKY3=1.0),), ("gamma", "alpha"), _FYZ),
    Candidate("camber_friction", (_each(PDY3=3.0, PDX3=3.0),), ("gamma",), _FXY),
    Candidate("pressure_stiffness", (_each(PPY1=0.4, PPX1=-0.4), _each(PPY1=0.4, PPX1=-0.4, PPY2=0.5)), ("p",), _FXYZ),
    Candidate(
        "pressure_friction",
        (_each(PPY3=-0.1, PPX3=-0.1), _each(PPY3=-0.1, PPX3=-0.1, PPY4=0.3, PPX4=0.3)),
        ("p",),
        _FXY,
    ),
    Candidate(
        "combined_Gxa",
        (Shape(("RBX1", "RBX2", "RCX1"), ({"RBX1": 12.0, "RBX2": 9.0}, {"RBX1": 6.0, "RBX2": 3.0}), scalable=False),),
        ("kappa", "alpha"),
        ("Fx",),
    ),
    Candidate(
        "combined_Gyk",
        (Shape(("RBY1", "RBY2", "RCY1"), ({"RBY1": 12.0, "RBY2": 8.0}, {"RBY1": 6.0, "RBY2": 3.0}), scalable=False),),
        ("kappa", "alpha"),
        _FYZ,
    ),
    Candidate(
        "kappa_sideforce_SVyk",
        (
            Shape(
                ("RVY1", "RVY3", "RVY4", "RVY5", "RVY6"),
                (
                    {"RVY1": 0.03, "RVY4": 10.0, "RVY5": 1.9, "RVY6": 10.0},
                    {"RVY3": 0.5, "RVY4": 10.0, "RVY5": 1.9, "RVY6": 10.0},
                ),
                scalable=False,
            ),
        ),
        ("kappa",),
        _FYZ,
    ),
    Candidate("relax_lat", (Shape(("SIGY",), ({"SIGY": 0.2},), scalable=False),), ("t", "alpha"), _FYZ),
    Candidate("relax_lon", (Shape(("SIGX",), ({"SIGX": 0.1},), scalable=False),), ("t", "kappa"), ("Fx",)),
    Candidate(
        "relax_load",
        (
            Shape(
                ("SIGY", "SIGC"),
                ({"SIGY": 0.2}, {"SIGY": 0.2, "SIGC": 0.6}),
                scalable=False,
            ),
        ),
        ("t", "alpha", "Fz"),
        _FYZ,
        part_of="relax_lat",
    ),
    Candidate("plysteer", (_each(PHY1=0.003), _each(PHY1=0.003, PHY2=0.002)), ("alpha",), _FYZ),
    Candidate("conicity", (_each(PVY1=0.02), _each(PVY1=0.02, PVY2=0.01)), ("Fz",), _FYZ),
    Candidate("curvature_asym", (_each(PEY3=0.2, PEX4=0.2),), (), _FXY),
    Candidate("temp_friction", (_each(TMU1=-0.002), _each(TMU1=-0.002, TMU2=-5e-5)), ("T",), _FXY),
    Candidate("temp_stiffness", (_each(TK1=-0.004),), ("T",), _FXYZ),
    Candidate("speed_friction", (_each(VMU1=-0.05),), ("V",), _FXY),
    Candidate("wear_drift", (_each(WMU1=-3e-5), _each(WMU1=-3e-5, WK1=3e-5)), ("distance",), _FXYZ),
    Candidate("residual_torque_Mzr", (_each(QDZ6=0.005, QDZ7=0.003),), (), ("Mz",)),
    Candidate("trail_load", (_each(QDZ2=-0.01, QBZ2=-2.0),), ("Fz", "alpha"), ("Mz",)),
    Candidate("Mz_from_Fx", (_each(SSZ1=0.02, SSZ2=0.02),), ("kappa",), ("Mz",)),
    Candidate("overturning_Mx", (_each(QSX1=0.01, QSX2=0.5, QSX3=0.05),), (), ("Mx",)),
    Candidate("rolling_resistance_My", (_each(QSY1=0.01, QSY2=0.1),), (), ("My",)),
    Candidate("turn_slip", (_each(PDYP1=0.4, PKYP1=1.0, QDTP1=5.0),), ("phit",), _FXYZ),
)

#: Every effect that a diagnosis tries by itself, by name.
CONTRACT: dict[str, Candidate] = {candidate.name: candidate for candidate in _CONTRACT}

#: Spread of shapes among tires, about twice that of published ones: what a recording leaves open stays near a tire's.
_SPREAD = {
    "PCX1": 0.2, "PEX1": 1.0, "PCY1": 0.2, "PEY1": 1.0, "QBZ1": 4.0, "QCZ1": 0.2,
    "RBX1": 6.0, "RBX2": 6.0, "RCX1": 0.15, "RBY1": 6.0, "RBY2": 6.0, "RCY1": 0.15,
    "RVY4": 6.0, "RVY5": 0.8, "RVY6": 6.0,
}  # fmt: skip
#: An effect that grows with its coefficient is believed to be at most about this many times as large as usual.
_LARGEST = 5.0
#: Where coefficients are believed to lie that have no neutral value, and how firmly coefficients are.
CENTER: dict[str, float] = {}
SPREAD: dict[str, float] = dict(_SPREAD)
for _candidate in _CONTRACT:
    for _shape in _candidate.shapes:
        if not _shape.scalable:
            CENTER = {**_shape.probes[0], **CENTER}
            continue
        for _probe in _shape.probes:
            SPREAD |= {_name: _LARGEST * abs(_size) for _name, _size in _probe.items() if _name not in SPREAD}

#: Finer forms of an effect that the tire has: tried so that a base formed otherwise is not taken for an effect.
FINER: dict[str, tuple[Shape, ...]] = {
    "": (_each(PEX3=0.3), _each(QEZ1=-1.0), _each(PKX3=0.1, PKX2=1.0)),
    "load_stiffness": (_each(PKY4=0.2),),
    "combined_Gxa": (_each(REX1=-0.5), _each(RHX1=0.005)),
    "combined_Gyk": (_each(REY1=-0.5), _each(RBY3=0.01), _each(RHY1=0.005)),
    "trail_load": (_each(QBZ3=1.0),),
    "camber_thrust": (_each(PKY7=0.2, PVY4=0.1),),
    "pressure_stiffness": (_each(PPX2=0.5, PPY2=0.5, PPY5=0.5),),
    "pressure_friction": (_each(PPY4=0.3, PPX4=0.3),),
    "temp_friction": (_each(TMU2=-5e-5),),
    "plysteer": (_each(PHY2=0.002),),
    "conicity": (_each(PVY2=0.01),),
}


def candidates_for(tire: Tire, added: Collection[AddedEffect] = ()) -> dict[str, Candidate]:
    """Return the effects that a tire lacks and its model can have.

    Parameters
    ----------
    tire : Tire
    added : collection of AddedEffect
        A user's own effects beside the contract's.

    Returns
    -------
    dict of str to Candidate
    """
    there = tire.book.effects.keys() - tire.has
    tried = [*CONTRACT, *(effect.name for effect in tire.book.own_effects)]
    known = {name: known_candidate(name, tire.book) for name in tried if name in there}
    found = {name: candidate for name, candidate in known.items() if candidate}
    if "relax_load" in tire.has:
        found.pop("relax_lat", None)
    if "relax_lat" in tire.has and "relax_load" in found:
        shape = Shape(("SIGC",), ({"SIGC": 0.5},))
        found["relax_load"] = Candidate("relax_load", (shape,), ("t", "alpha", "Fz"), _FYZ)
    for effect in added:
        if effect.name in there:
            found[effect.name] = own_candidate(effect)
    return found


def known_candidate(name: str, book: Model) -> Candidate | None:
    """Return the candidate that an effect of a model is, or None for one that a diagnosis does not try.

    Parameters
    ----------
    name : str
    book : Model
        Where it has coefficients of its own for the effect, their cards say how it is probed.

    Returns
    -------
    Candidate or None
    """
    cards = book.coefficients
    declared = CONTRACT.get(name)
    if declared and any(set(shape.free) & cards.keys() for shape in declared.shapes):
        return declared
    if name not in book.effects or not (declared or name in {effect.name for effect in book.own_effects}):
        return None
    owned = [card for key, card in cards.items() if key in book.owned(name) and card.neutral is not None]
    channels = tuple(dict.fromkeys(channel for card in owned for channel in card.channels))
    varies = declared.varies if declared else ()
    return Candidate(name, (_by_bounds(owned),), varies, channels) if owned else None


def _by_bounds(cards: Sequence[Coefficient]) -> Shape:
    """Return the shape of coefficients that are probed by an eighth of their range."""
    probes = {card.name: card.default + (card.upper - card.default) / 8.0 for card in cards}
    return Shape(tuple(probes), tuple({name: size} for name, size in probes.items()))


def own_candidate(effect: AddedEffect) -> Candidate:
    """Return the candidate that a user's own effect is.

    Parameters
    ----------
    effect : AddedEffect
        Coefficients whose neutral value lies inside their bounds are probed by an eighth of their range.

    Returns
    -------
    Candidate
    """
    return Candidate(effect.name, (_by_bounds(effect.cards),), (), ("Fx", "Fy", "Mz", "Mx", "My"))


def varies(signals: Signals, tire: Tire, name: str) -> bool:
    """Return whether an input varies by more than its noise in a recording."""
    if name == "t":
        return signals.timed
    if name not in signals.recorded or name not in signals.names:
        return False
    values = signals.named()[name]
    least = {"kappa": 0.01, "alpha": 0.01, "gamma": 0.005, "Fz": 0.02 * tire.values["FNOMIN"]}.get(name, 0.0)
    spread = float(values.max() - values.min())
    return spread > max(least, 4.0 * signals.input_noise.get(name, 0.0), 1e-9)
