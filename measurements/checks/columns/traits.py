"""What tires do, as numbers that a table has in the right units and signs: friction, slip stiffness, trail, ...

Sizes are compared with a log-normal distribution over tires, signs with what every tire does. The penalty of a table is
minus the logarithm of its probability, up to a constant. The distributions are wide: they cover tires of trucks, cars
and bicycles on dry and wet belts. ``tests/measurements/column_meaning`` compares them with the published tires.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from ...thresholds import (
    ALIGNING_SLIP,
    MAX_FAR_TRAIL,
    MIN_CAMBER_RESPONSE,
    MIN_FAR_ARM,
    MIN_SATURATION,
    MIN_SLIP_DEVIATION,
    SMALL_ANGLE,
    STRONG_CORRELATION,
    WEAK_CORRELATION,
)
from .sampled_rows import SampledRows

#: Penalty of a sign that no tire has, and of a camber thrust away from the lean, which a large shift may resemble.
WRONG_SIGN, WRONG_THRUST = 12.0, 8.0
#: Penalty of a trait that appears only in the claimed reading. The traits that a table may lack: a force that does not
#: saturate shows no friction.
VANISHED, ONE_SIDED = 3.0, frozenset(("mu_x", "mu_y", "mu_xy", "mu_x/mu_y", "Mz/Fz", "Mx/Fz"))
#: Share of a column that others do not contain, below which it cannot be separated from them.
SINGULAR = 1e-6
#: Standard deviations from which the penalty of a size is linear, and from which a size is mentioned.
FAR, NOTABLE = 3.0, 1.5


@dataclass(frozen=True)
class SizeDistribution:
    """The distribution of a size over tires: median, and standard deviations of its logarithm below and above.

    `text`: the name in a message. `unit`: of the size.
    """

    text: str
    unit: str
    median: float
    below: float
    above: float

    def deviation(self, value: float) -> float:
        """Return the number of standard deviations from the median."""
        distance = float(np.log(max(abs(value), 1e-300) / self.median))
        return distance / (self.below if distance < 0.0 else self.above)

    def penalty(self, value: float) -> float:
        """Return minus the logarithm of the probability; linear far from the median, as a tire may be strange once."""
        deviation = abs(self.deviation(value))
        return 0.5 * deviation**2 if deviation <= FAR else FAR * (deviation - 0.5 * FAR)

    @property
    def typical(self) -> str:
        """The range of two standard deviations on either side."""
        low, high = self.median * np.exp(-2.0 * self.below), self.median * np.exp(2.0 * self.above)
        return f"{low:.2g} to {high:.2g}"


# Medians and deviations are judgement, from slip stiffness per load of 6 (truck) to 40 (racing), friction of 0.7 to 2.9
# on dry belts and less on wet ones, and the figures of Pacejka (2012), chapters 1 and 4. The published racing tire has
# a friction of 3.1 and a slip stiffness per load of 63 at half of its nominal load.
SIZES: Mapping[str, SizeDistribution] = {
    "mu_y": SizeDistribution("the largest |Fy|/Fz", "", 1.35, 0.8, 0.5),
    "mu_x": SizeDistribution("the largest |Fx|/Fz", "", 1.35, 0.8, 0.5),
    "mu_xy": SizeDistribution("the largest force over load", "", 1.35, 0.8, 0.5),
    "C_y": SizeDistribution("cornering stiffness over load", "1/rad", 18.0, 0.7, 0.65),
    "C_x": SizeDistribution("slip stiffness over load", "", 22.0, 0.75, 0.65),
    "C_xy": SizeDistribution("slip stiffness over load", "", 20.0, 0.7, 0.65),
    "mu_x/mu_y": SizeDistribution("largest |Fx| over largest |Fy|", "", 1.0, 0.3, 0.3),
    # Relaxation lowers the slope of a fast sweep to a fraction.
    "C_x/C_y": SizeDistribution("slip stiffness over cornering stiffness", "", 1.3, 0.7, 0.6),
    "trail": SizeDistribution("the pneumatic trail", "m", 0.025, 0.9, 0.5),
    "arm": SizeDistribution("Mx over Fy", "m", 0.05, 1.6, 1.2),
    "Mz/Fz": SizeDistribution("the largest |Mz|/Fz", "m", 0.03, 1.6, 1.0),
    "Mx/Fz": SizeDistribution("the largest |Mx|/Fz", "m", 0.05, 1.6, 1.2),
    "alpha": SizeDistribution("the largest |alpha|", "rad", 0.15, 0.8, 0.7),
    "kappa": SizeDistribution("the largest |kappa|", "", 0.2, 0.9, 1.0),
    "gamma": SizeDistribution("the largest |gamma|", "rad", 0.06, 0.9, 0.7),
    "thrust": SizeDistribution("camber stiffness over cornering stiffness", "", 0.08, 1.0, 0.9),
    "p": SizeDistribution("p", "Pa", 1.5e5, 0.6, 0.9),
    # A bicycle has 0.0014 m^2, a racing tire 0.01, a truck tire 0.03.
    "Fz/p": SizeDistribution("Fz/p, the contact area,", "m^2", 0.01, 1.3, 0.6),
    "trail/patch": SizeDistribution("the trail over the root of Fz/p", "", 0.2, 0.5, 0.4),
}


@dataclass(frozen=True)
class Traits:
    """The traits of a table in one reading.

    `sizes`: by the names of `SIZES`. `contradictions`: what no tire does, each with its
    penalty: channels whose sign is wrong, and facts. `thrust`: slope
    of Fy/Fz over gamma at zero slip angle, 1/rad; NaN without a camber that acts. `load`: median load, N.
    """

    sizes: Mapping[str, float]
    contradictions: Mapping[str, float]
    thrust: float
    load: float

    @property
    def penalties(self) -> dict[str, float]:
        """Minus the logarithm of the probability of each trait."""
        sizes = {name: SIZES[name].penalty(value) for name, value in self.sizes.items()}
        return {**sizes, **self.contradictions}

    @property
    def penalty(self) -> float:
        """Sum of the penalties."""
        return sum(self.penalties.values())


def traits_of(rows: SampledRows) -> Traits:
    """Return the traits of a table in ISO signs."""
    sizes: dict[str, float] = {}
    contradictions: dict[str, float] = {}
    thrust = np.nan
    if rows.count:
        side = rows.correlation("alpha", "Fy", rows.near_zero("kappa"))
        along = rows.correlation("kappa", "Fx", rows.near_zero("alpha"))
        for part in (_force_sizes(rows, side, along), _moment_sizes(rows, side)):
            sizes |= {name: abs(value) for name, value in part if np.isfinite(value) and value != 0.0}
        thrust = _thrust(rows)
        sizes |= _camber_sizes(rows, thrust, sizes.get("C_y", sizes.get("C_xy", np.nan)))
        if "p" in rows and np.nanmedian(rows["p"]) > 0.0:
            sizes["p"] = float(np.nanmedian(rows["p"]))
            if "Fz" in rows:
                sizes["Fz/p"] = float(np.median(rows.load)) / sizes["p"]
                if "trail" in sizes:
                    sizes["trail/patch"] = sizes["trail"] / np.sqrt(sizes["Fz/p"])
        contradictions = dict(_contradictions(rows, side, along, thrust))
    return Traits(sizes, contradictions, thrust, float(np.median(rows.load)) if rows.count else np.nan)


def _force_sizes(rows: SampledRows, side: float, along: float) -> Iterator[tuple[str, float]]:
    """Yield friction, slip stiffness and largest slip of each force that follows its slip."""
    traits: dict[str, float] = {}
    for force, slip, other, axis, strength in (
        ("Fy", "alpha", "kappa", "y", side), ("Fx", "kappa", "alpha", "x", along)
    ):  # fmt: skip
        if abs(strength) <= STRONG_CORRELATION or "Fz" not in rows:
            continue
        free = rows.near_zero(other)
        friction = float(np.nanquantile(np.abs(rows[force] / rows.load), 0.98))
        stiffness = abs(rows.slope(force, slip, free & rows.near_zero(slip, least=0.0), rows.load))
        traits[f"C_{axis}"] = stiffness
        traits[slip] = rows.largest(slip)
        # Without saturation the largest force is no friction; it is only too large, or not.
        saturated = stiffness * rows.largest(slip) >= MIN_SATURATION * friction
        if saturated or friction > SIZES[f"mu_{axis}"].median:
            traits[f"mu_{axis}"] = friction
    traits = {name: value for name, value in traits.items() if np.isfinite(value)}
    # A tire with much grip has it in both directions: two forces count by their mean and their ratio.
    for size in ("C", "mu"):
        along_x, along_y = traits.get(f"{size}_x"), traits.get(f"{size}_y")
        if along_x and along_y:
            del traits[f"{size}_x"], traits[f"{size}_y"]
            yield f"{size}_x/{size}_y", along_x / along_y
            yield f"{size}_xy", float(np.sqrt(along_x * along_y))
    yield from traits.items()


def _moment_sizes(rows: SampledRows, side: float) -> Iterator[tuple[str, float]]:
    """Yield the arms of the moments about the side force."""
    if abs(side) <= STRONG_CORRELATION:
        return
    free = rows.near_zero("kappa")
    # Rows that do not determine the cornering stiffness do not determine the trail either.
    measured = np.isfinite(rows.slope("Fy", "alpha", free & rows.near_zero("alpha", least=0.0)))
    for size, moment, chosen in (("trail", "Mz", free & rows.near_zero("alpha")), ("arm", "Mx", free)):
        # The slope of a moment that does not follow the force is noise.
        follows = moment in rows and abs(rows.correlation("Fy", moment, chosen)) > WEAK_CORRELATION
        if follows and (measured or size != "trail"):
            yield size, rows.slope(moment, "Fy", chosen)
        elif moment in rows and "Fz" in rows:
            yield f"{moment}/Fz", float(np.nanquantile(np.abs(rows[moment] / rows.load), 0.98))


def _thrust(rows: SampledRows) -> float:
    """Return the slope of Fy/Fz over gamma at small slip angles; NaN if the camber does not act.

    What else may have changed with the camber is estimated with it: a memory of the last change of the slip angle, and
    a drift over the recording. Where the order of the program does not separate them, the slope has no sign.
    """
    if not {"alpha", "gamma", "Fy", "Fz"} <= rows.columns.keys():
        return np.nan
    small = rows.near_zero("alpha") & rows.near_zero("kappa") & np.isfinite(rows["Fy"])
    order = np.linspace(-1.0, 1.0, rows.count)
    rivals = np.column_stack([np.ones(rows.count), rows["alpha"], rows.memory("alpha"), order])[small]
    camber, force = rows["gamma"][small], (rows["Fy"] / rows.load)[small]
    if len(rivals) < 3 * (rivals.shape[1] + 1) or np.ptp(camber) == 0.0:
        return np.nan
    scaled = rivals / np.maximum(np.abs(rivals).max(axis=0), 1e-300)
    coefficients = np.linalg.lstsq(scaled, np.column_stack([camber, force]), rcond=SINGULAR)[0]
    camber_alone, force = (np.column_stack([camber, force]) - scaled @ coefficients).T
    if camber_alone @ camber_alone < SINGULAR * (camber @ camber):
        return np.nan
    slope = float(camber_alone @ force / (camber_alone @ camber_alone))
    residual = force - slope * camber_alone
    # Neighboring rows of a sweep are correlated: the error is that of a tenth of them, or of the passes through zero.
    error = np.sqrt(10.0 * np.mean(residual**2) / (camber_alone @ camber_alone))
    passes = np.cumsum(np.diff(np.flatnonzero(small), prepend=-1) > 1)
    scores = np.bincount(passes, camber_alone * residual)
    free = max(np.count_nonzero(scores) - rivals.shape[1], 1)
    of_passes = np.sqrt(scores @ scores * len(scores) / free) / (camber_alone @ camber_alone)
    significant = abs(slope) > max(MIN_CAMBER_RESPONSE / np.abs(camber).max(), 3.0 * error, 3.0 * of_passes)
    return slope if significant else np.nan


def _camber_sizes(rows: SampledRows, thrust: float, stiffness: float) -> dict[str, float]:
    if not np.isfinite(thrust):
        return {}
    sizes = {"gamma": float(np.abs(rows["gamma"]).max())}
    return sizes | ({"thrust": abs(thrust) / stiffness} if np.isfinite(stiffness) else {})


def _contradictions(rows: SampledRows, side: float, along: float, thrust: float) -> Iterator[tuple[str, float]]:
    """Yield the signs that no tire has in ISO: a tire opposes its slip, and leans into its thrust."""
    if "Fz" in rows and np.mean(rows["Fz"] < 0.0) > 0.5:
        yield "Fz", WRONG_SIGN
    if side > STRONG_CORRELATION:
        yield "Fy", WRONG_SIGN
    if along < -STRONG_CORRELATION:
        yield "Fx", WRONG_SIGN
    small = rows.near_zero("kappa") & rows.near_zero("alpha", share=ALIGNING_SLIP, least=SMALL_ANGLE)
    aligning = rows.correlation("alpha", "Mz", small)
    if aligning < -STRONG_CORRELATION:
        yield "Mz", WRONG_SIGN
    if thrust > 0.0:
        yield "gamma", WRONG_THRUST
    for slip, force, other in (("alpha", "Fy", "Fx"), ("kappa", "Fx", "Fy")):
        follows, instead = _strength(rows, slip, force), _strength(rows, slip, other)
        if force in rows and instead > STRONG_CORRELATION and follows < WEAK_CORRELATION:
            yield f"{other} follows {slip} and {force} does not", WRONG_SIGN
        moved, by_camber = float(np.std(rows[slip])) > MIN_SLIP_DEVIATION, _strength(rows, "gamma", force)
        if moved and by_camber > STRONG_CORRELATION and follows < WEAK_CORRELATION:
            yield f"{force} follows gamma and not {slip}", WRONG_SIGN
    if _strength(rows, "kappa", "Mz") > STRONG_CORRELATION and _strength(rows, "alpha", "Mz") < WEAK_CORRELATION:
        yield "Mz follows kappa and not alpha", WRONG_SIGN
    if _arm_at_large_slip(rows, "Mx") < MAX_FAR_TRAIL and _arm_at_large_slip(rows, "Mz") > MIN_FAR_ARM:
        yield "Mx vanishes at large slip angles and Mz does not", WRONG_SIGN


def _strength(rows: SampledRows, slip: str, force: str) -> float:
    return abs(rows.correlation(slip, force, np.ones(rows.count, dtype=np.bool_)))


def _arm_at_large_slip(rows: SampledRows, moment: str) -> float:
    """Return the arm of a moment about Fy at large slip angles over that at small ones; NaN if it does not follow Fy.

    A pneumatic trail vanishes at large slip angles; the arm of Mx does not.
    """
    if moment not in rows or "Fy" not in rows or "alpha" not in rows:
        return np.nan
    free = rows.near_zero("kappa")
    small = free & rows.near_zero("alpha")
    if abs(rows.correlation("Fy", moment, small)) < WEAK_CORRELATION:
        return np.nan
    return abs(rows.slope(moment, "Fy", free & rows.far("alpha")) / rows.slope(moment, "Fy", small))
