"""The correction of the formula's own form: errors of friction, slip stiffness and trail over load and slip.

Every explanation contains a discrepancy of the form; this is what the tire is given of it. The quantities are
multiplied by 1 plus smooth bumps over the tested loads and slips, each with a coefficient; friction also at combined
slip in driving and in braking, which the formula weights alike. They are fitted together with all other coefficients.
A bump is 0 at 1.25 times the distance of the bumps from its center: outside the tested range the correction falls to 0
within three quarters of this distance.
"""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import replace
from functools import lru_cache

import numpy as np

from ...boundary.errors import EffectError
from ...numerics.arrays import BoolArray, FloatArray
from ...numerics.block_regression import error_of_sum
from ...symbolic.added import AddedEffect, effect_from
from ...tires.tire import Tire
from ..least_squares import LeastSquares, Solution, density_gains
from ..probing.effect_probing import Screen
from ..signals.signals import Signals
from ..thresholds import FOLDS, SIDE
from .discrepancy import model_discrepancy
from .evidence import folds_of, likelihood_power

#: The name of the effect, and how the names of its shares of bumps begin.
FORM, PREFIX = "form", "FORM_"
#: Numbers of bumps over load and slip, and the half width of a bump in distances of two. Conventions.
LOADS, SLIPS, HALF_WIDTH = 4, 3, 1.25
#: Prior standard deviation of a share of a bump. Convention: by more, no formula is corrected but another one is built,
#: and the coefficients that are fitted beside it extrapolate worse.
SHARE = 0.06
#: Smallest ranges of Fz/FNOMIN and slip that have a form. Convention.
MIN_LOADS, MIN_SLIPS = 0.2, 0.02
#: Coordinates whose 0 is the center of the first bump and whose 1 that of the second one.
LOAD = "(Fz/FNOMIN - FORMF0)/FORMFW"
SLIP = "(sqrt(tan(alpha)**2 + kappa**2 + 1e-12) - FORMS0)/FORMSW"
#: Coordinates of combined slip: 1 at the largest slips and 0 without one, where the bumps are 0; the first one is
#: smooth where alpha changes its sign.
LATERAL, LONGITUDINAL = f"(sqrt(tan(alpha)**2 + {SIDE**2}) - {SIDE})/FORMLW", "kappa/FORMKW"
BRAKING, DRIVING = -1, 1
#: By role of a quantity: the channel that determines it, and how names of its coefficients go on.
CORRECTED = {
    "friction_x": ("Fx", "MX"), "friction_y": ("Fy", "MY"), "stiffness_x": ("Fx", "KX"), "stiffness_y": ("Fy", "KY"),
    "trail": ("Mz", "T"),
}  # fmt: skip


def form_of(problem: LeastSquares, solution: Solution) -> tuple[LeastSquares, Solution, FloatArray] | None:
    """Return the fit of a model with a correction of the form, and what it errs by without, N and N m.

    It has the quantities whose channel it predicts better in left-out blocks of time, by more than twice the standard
    error over blocks, and on the hold-out set: a force does not correct what is wrong in the formula of a moment that
    it causes. None if it has none, or if all channels together are not predicted better. The errors are the change of
    the residual, shape (n_channels, n).

    It is fitted if a smooth function of slips and load beside fixed coefficients predicts left-out blocks better.

    For the fit, the noise of a channel is its residual, and the likelihood is raised to the power of the comparison.
    """
    used, signals, tire = problem.inverse_noise > 0.0, problem.simulator.signals, problem.simulator.tire
    size, geometry = problem.sizes(solution.residual), _geometry(signals, tire)
    if geometry is None or FORM in tire.has:
        return None
    combined = "FORMKW" in geometry
    power = likelihood_power(int(used.any(axis=0).sum()))
    weights = problem.inverse_noise * (np.sqrt(power) / np.where(size > 0.0, size, 1.0))[:, None]
    gains = _gains(signals, solution.residual, _smoothed(problem, solution, weights), used, used)
    if not gains.sum() > 0.0:
        return None
    leading, channels = tire.symbolic_model.leading, signals.channels
    roles = tuple(role for role, (channel, _) in CORRECTED.items() if channel in channels and leading(role))
    weighted = replace(problem, inverse_noise=weights)
    apart, held = _without_block(weighted, solution), signals.present & signals.holdout
    while roles:
        try:
            effect = form_effect(roles, combined=combined)
            declared = [coefficient.name for coefficient in effect.declarations]
            centers = {name: value for name, value in geometry.items() if name in declared}
            wider, parameters = weighted.with_effect(effect, solution, centers)
        except EffectError:  # an effect of this name, or a quantity that cannot be acted on
            return None
        free = tuple(sorted((*solution.free, *_coefficients(roles, combined)), key=wider.simulator.names.index))
        wider, best = wider.fitted(parameters, free)
        gains = _gains(signals, apart, _without_block(wider, best), used, used)
        of_holdout = _gains(signals, solution.residual, best.residual, used, held).sum(axis=1)
        better = {channel: _certain(*of) for channel, *of in zip(channels, gains, of_holdout, strict=True)}
        kept = tuple(role for role in roles if better[CORRECTED[role][0]])
        if kept == roles:
            errors = np.where(signals.present, solution.residual - best.residual, 0.0)
            certain = _certain(gains.sum(axis=0), of_holdout.sum())
            return (replace(wider, inverse_noise=problem.inverse_noise), best, errors) if certain else None
        roles = kept
    return None


def _certain(gains: FloatArray, of_holdout: float) -> bool:
    """Return whether gains in left-out blocks are certain, and confirmed on the hold-out set."""
    return bool(gains.sum() > 2.0 * error_of_sum(gains) and of_holdout > 0.0)


def _smoothed(problem: LeastSquares, solution: Solution, weights: FloatArray) -> FloatArray:
    """Return the residual without the posterior mean of the discrepancy of the model: a form without its equations.

    The mean at a block of time is that of the recording without a fold of blocks, the block among them.
    """
    signals = problem.simulator.signals
    columns = model_discrepancy(signals, problem.simulator.forces(solution.parameters))
    fold, rest = folds_of(signals), solution.residual.copy()
    rows = (weights[:, :, None] * columns, weights * solution.residual)
    parts = [[part[:, fold == k] for part in rows] for k in range(FOLDS)]
    matrices = np.array([np.einsum("cni,cnj->ij", x, x, optimize=True) for x, _ in parts])
    targets = np.array([np.einsum("cni,cn->i", x, y, optimize=True) for x, y in parts])
    prior = np.eye(columns.shape[-1]) / SHARE**2
    for k in range(FOLDS):
        mean = np.linalg.solve(matrices.sum(axis=0) - matrices[k] + prior, targets.sum(axis=0) - targets[k])
        rest[:, fold == k] -= columns[:, fold == k] @ mean
    return rest


def _without_block(problem: LeastSquares, solution: Solution) -> FloatArray:
    """Return the residual of each block of time after a fit to the others in which all coefficients follow linearly."""
    screen = Screen(problem, problem.at(solution.parameters, solution.free))
    return np.asarray(screen.solution.residual + screen.change_without_block)


def _gains(signals: Signals, before: FloatArray, after: FloatArray, fitted: BoolArray, judged: BoolArray) -> FloatArray:
    """Return the gains of density (`density_gains`) of one residual over another one, shape (n_channels, n_blocks)."""
    gains, blocks = density_gains(before, after, fitted, judged), np.unique(signals.block[judged.any(axis=0)])
    return np.stack([np.sum(gains, axis=1, where=signals.block == block) for block in blocks], axis=1)


def _geometry(signals: Signals, tire: Tire) -> dict[str, float] | None:
    """Return the coefficients of the coordinates; None if a recording has too few loads or slips.

    Those of combined slip only if it has both slips at once.
    """
    named = signals.named()
    load, lateral, kappa = named["Fz"] / tire.values["FNOMIN"], np.abs(np.tan(named["alpha"])), named["kappa"]
    slip = np.hypot(lateral, kappa)
    width = float(np.ptp(load)) / LOADS, float(slip.max()) / SLIPS
    if width[0] < MIN_LOADS / LOADS or width[1] < MIN_SLIPS / SLIPS:
        return None
    geometry = {
        "FORMF0": float(load.min()) + 0.5 * width[0], "FORMFW": width[0], "FORMS0": 0.5 * width[1], "FORMSW": width[1],
    }  # fmt: skip
    if ((lateral > MIN_SLIPS) & (np.abs(kappa) > MIN_SLIPS)).any():
        geometry |= {"FORMLW": float(np.hypot(lateral.max(), SIDE) - SIDE), "FORMKW": float(np.abs(kappa).max())}
    return geometry


def without_form(tire: Tire) -> Tire:
    """Return a tire whose correction is zero; its other coefficients were fitted together with it."""
    return tire.with_values(**{name: 0.0 for name in tire.symbolic_model.coefficients if name.startswith(PREFIX)})


def _shares(role: str, load: int, combined: bool) -> dict[str, str]:
    """Return the bumps of a quantity at one load by the names of their shares."""
    start = f"{PREFIX}{CORRECTED[role][1]}{load + 1}"
    if role.startswith("stiffness"):
        return {f"{start}1": "1"}
    shares = {f"{start}{k + 1}": _bump(SLIP, k) for k in range(SLIPS)}
    if combined and role.startswith("friction"):
        lateral = _bump(LATERAL, 1, 1.0)
        shares |= {
            f"{start}{SLIPS + k + 1}": f"{lateral}*{_bump(LONGITUDINAL, way, 1.0)}"
            for k, way in enumerate((BRAKING, DRIVING))
        }
    return shares


def _coefficients(roles: Collection[str], combined: bool) -> list[str]:
    return [name for role in roles for load in range(LOADS) for name in _shares(role, load, combined)]


@lru_cache(maxsize=8)
def form_effect(roles: tuple[str, ...], *, combined: bool = False) -> AddedEffect:
    """Return the effect of the correction for quantities by their roles, the same for all recordings.

    `combined`: whether friction is corrected at combined slip.
    """
    bound = 2.0 * SHARE
    acts = [
        {"on": role, "factor": f"1 + {_bump(LOAD, load)}*({' + '.join(terms)})"}
        for role in roles
        for load in range(LOADS)
        for terms in ([f"{name}*{bump}" for name, bump in _shares(role, load, combined).items()],)
    ]
    centers = {
        name: {
            "description": text, "unit": "1", "lower": lower, "upper": 100.0, "neutral": neutral, "fitted": False,
        }
        for name, text, lower, neutral in (
            ("FORMF0", "center of the first bump over Fz/FNOMIN", -100.0, 0.0),
            ("FORMFW", "distance of the bumps over Fz/FNOMIN", 1e-3, 1.0),
            ("FORMS0", "center of the first bump over slip", -100.0, 0.0),
            ("FORMSW", "distance of the bumps over slip", 1e-3, 1.0),
            ("FORMLW", "largest lateral slip beyond the smooth zero", 1e-3, 1.0),
            ("FORMKW", "largest longitudinal slip", 1e-3, 1.0),
        )
        if any(name in act["factor"] for act in acts)
    }  # fmt: skip
    table = {
        "name": FORM,
        "physics": "correction of the formula's own form within the tested loads and slips",
        "source": "diagnosis of a recording",
        "coefficients": centers | {
            name: {"description": "share of a bump", "unit": "1", "lower": -bound, "upper": bound}
            for name in _coefficients(roles, combined)
        },
        "acts": acts,
    }  # fmt: skip
    return effect_from(table, f"{FORM}.toml")


def _bump(coordinate: str, number: int, half_width: float = HALF_WIDTH) -> str:
    """Return a bump: (1 - x^2)^2 within its half width, 0 beyond."""
    inner = f"(1 - (({coordinate} - {number})/{half_width})**2)"
    return f"(0.5*({inner} + absolute({inner})))**2"
