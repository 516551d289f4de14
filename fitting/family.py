"""A family of tires as a prior of the coefficients of a new one: what the data do not determine comes from it.

The coefficients of a tire of the family, in adapted SAE, are normally distributed around a linear function of its size,
load and pressure (logarithms of UNLOADED_RADIUS, FNOMIN, NOMPRES). Their variances have the conjugate prior of a
hierarchical normal model with `ASSUMED_TIRES` tires, whose spread is scaled by the typical spread of the tires in
relation to the assumed one (empirical Bayes). A family of one or two tires has the assumed spread. Correlations are
shrunk in proportion to their sampling errors (Schaefer and Strimmer, Statistical Applications in Genetics 4, 2005):
fewer tires than coefficients show correlations where there are none. The prediction for a new tire is Student's t, used
as a normal distribution of the same scale in the fit, and with its tails in the test of membership (Gelman et al.,
Bayesian Data Analysis, 3rd ed. 2013, chapters 3 and 14).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from math import isfinite

import numpy as np
from scipy.special import fdtrc

from ..boundary.errors import FitError
from ..numerics.arrays import FloatArray
from ..symbolic.model import Model
from ..tires import TireLike
from ..tires.tire import Tire
from ..tires.tire_argument import tires_from
from .problem.influence import typical_size
from .problem.prior import Prior
from .results.records import FittedCoefficient
from .uncertainty.sandwich import QUANTILE
from .uncertainty.sensitivities import sensitivities

#: Inputs of the linear function, coefficients by name.
COVARIATES = ("UNLOADED_RADIUS", "FNOMIN", "NOMPRES")
#: Assumed spread of a coefficient: share of its mean magnitude, and of its typical size. Judgement: tires of a kind
#: differ by a quarter; a coefficient that is 0 in all of them is near 0.
SHARE, SIZE_SHARE = 0.25, 0.02
#: Tires that the assumed spread counts for.
ASSUMED_TIRES = 4
#: Deviations of the tires below this share of the assumed spread are rounding: they show no correlations, which would
#: be 1 between all coefficients in which the tires are equal.
ROUNDING = 1e-6
#: A family is not used for tires whose load or radius differs from its own by more than this factor.
MAX_RATIO = 2.0
#: Probability below which a tire is reported as outside the family.
OUTSIDE = 0.01
#: Quantities with a distribution over the family, by role.
ROLES = ("friction_x", "friction_y", "stiffness_x", "stiffness_y")
#: A coefficient comes from the family if the data reduce its variance by less than this share.
FROM_DATA = 0.5


@dataclass(frozen=True, eq=False)
class Family:
    """The distribution of the coefficients of a tire of a family.

    - `names`: the coefficients.
    - `mean`, shape (n,), `covariance`, shape (n, n): of the new tire, in adapted SAE.
    - `freedom`: degrees of freedom of the covariance.
    - `count`: number of tires.
    - `unknown`: coefficients that none of the tires has.
    - `tire`: with the mean values and the nominal values of the new tire.
    """

    names: tuple[str, ...]
    mean: FloatArray
    covariance: FloatArray
    freedom: int
    count: int
    unknown: tuple[str, ...]
    tire: Tire

    @classmethod
    def of(cls, source: TireLike, model: Model, nominal: Mapping[str, float]) -> Family:
        """Return the family for a new tire.

        `source`: a folder of .tir files, or a tire. `nominal`: coefficients of the new tire among `COVARIATES`, by
        default geometric means of the family. Raises `FitError` if a tire has another model, or load or radius of the
        new tire is far from those of the family.
        """
        tires = [tire.in_signs("adapted-sae") for tire in tires_from(source, "family")]
        for tire in tires:
            if tire.model != model.name:
                raise FitError(f"family: {tire.name or 'a tire'} is {tire.model}, not {model.name}")
        _check_nominal(tires, nominal)
        names = _varied(model)
        values = np.array([[tire.values[name] for name in names] for tire in tires])
        declared = [model.coefficients[name] for name in names]
        sizes = np.array([typical_size(declaration.lower, declaration.upper, 0.0) for declaration in declared])
        assumed = (SHARE * np.abs(values.mean(axis=0)) + SIZE_SHARE * sizes) ** 2
        levels = {**_means(tires), **nominal}
        places, new = _places(tires, levels)
        hat = places.T @ places + np.eye(places.shape[1])  # slopes have the spread of the tires as a prior
        slopes = np.linalg.solve(hat, places.T @ (values - values.mean(axis=0)))
        residual = values - values.mean(axis=0) - places @ slopes
        residual[:, np.abs(residual).max(axis=0) < ROUNDING * np.sqrt(assumed)] = 0.0
        freedom, squares = ASSUMED_TIRES + len(tires) - 1, np.sum(residual**2, axis=0)
        varied = squares[squares > 0.0] / assumed[squares > 0.0]
        assumed *= (ASSUMED_TIRES + (np.median(varied) if varied.size else 0.0)) / freedom
        deviation = np.sqrt((ASSUMED_TIRES * assumed + squares) / freedom)
        covariance = _correlation(residual) * np.outer(deviation, deviation)
        covariance *= 1.0 + 1.0 / len(tires) + float(new @ np.linalg.solve(hat, new))
        mean = np.clip(values.mean(axis=0) + new @ slopes, [d.lower for d in declared], [d.upper for d in declared])
        first = tires[0]
        given = {**first.values, **dict(zip(names, mean.tolist(), strict=True)), **levels}
        effects = frozenset[str]().union(*(tire.has for tire in tires))
        tire = Tire(model.name, given, effects=effects, signs="adapted-sae", added=first.added)
        informed = frozenset().union(*(tire.symbolic_model.live(tire.has).difference(tire.defaulted) for tire in tires))
        unknown = tuple(name for name in names if name not in informed)
        return cls(names, mean, covariance, freedom, len(tires), unknown, tire)

    def prior(self, free: Sequence[str], scale: FloatArray, weight: float) -> Prior:
        """Return the prior of free coefficients; one that the family does not have is free."""
        index = {name: i for i, name in enumerate(self.names)}
        entries = [i for i, name in enumerate(free) if name in index]
        rows = np.array([index[free[i]] for i in entries], dtype=int)
        center, precision = np.zeros(len(free)), np.zeros((len(free), len(free)))
        center[entries] = self.mean[rows] / scale[entries]
        scaled = self.covariance[np.ix_(rows, rows)] / np.outer(scale[entries], scale[entries])
        precision[np.ix_(entries, entries)] = np.linalg.inv(scaled)
        return Prior(center, precision, weight)

    def marked(
        self, coefficients: tuple[FittedCoefficient, ...], tire: Tire
    ) -> tuple[tuple[FittedCoefficient, ...], Tire, list[str]]:
        """Return fitted coefficients and tire with marks of what comes from the family, and notes about it.

        `tire`: in adapted SAE.
        """
        deviations = {c.name: c.interval / QUANTILE for c in coefficients if isfinite(c.interval)}
        inherited, probability = self.from_family(deviations), self.membership(tire, deviations)
        kind = "outside" if probability < OUTSIDE else "within"
        notes = [
            f"{kind} the family of {self.count} tires: as far from its mean with probability {probability:.2g}",
            f"from the family, not from the data: {', '.join(inherited) or 'no coefficient'}",
        ]
        if unknown := sorted({c.name for c in coefficients}.intersection(self.unknown) - deviations.keys()):
            notes.append(f"neither the data nor the family determine: {', '.join(unknown)}")
        about = {**tire.about, "family": f"{self.count} tires, {kind}", "from_family": " ".join(inherited)}
        marked = tuple(replace(c, from_family=c.name in inherited) for c in coefficients)
        return marked, replace(tire, about=about), notes

    def membership(self, tire: Tire, posterior: Mapping[str, float]) -> float:
        """Return the probability that a tire of the family is as far from its mean as a fitted tire, or farther.

        `tire`: in adapted SAE. `posterior`: standard deviations of the fitted coefficients. The smaller of two
        probabilities, doubled: of friction and slip stiffness at nominal load, and of all coefficients, of which those
        count that the data determine.
        """
        return min(1.0, 2.0 * min(self._of_quantities(tire, posterior), self._of_coefficients(tire, posterior)))

    def _of_coefficients(self, tire: Tire, posterior: Mapping[str, float]) -> float:
        rows = [i for i, name in enumerate(self.names) if name in posterior]
        if not rows:
            return 1.0
        prior = self.covariance[np.ix_(rows, rows)]
        away = np.array([tire.values[self.names[i]] for i in rows]) - self.mean[rows]
        kept = np.clip(np.array([posterior[self.names[i]] ** 2 for i in rows]) / np.diag(prior), 0.0, 1.0)
        return self._tail(away, prior, float(np.sum(1.0 - kept)))

    def _of_quantities(self, tire: Tire, posterior: Mapping[str, float]) -> float:
        inputs = np.array([[tire.nominal(name)] for name in tire.inputs])
        away, rows = [], []
        for role in ROLES:
            if role not in tire.symbolic_model.roles or tire.symbolic_model.leading(role) not in posterior:
                continue
            quantity = tire.symbolic_model.quantity(role)
            expected, slopes, names = sensitivities(self.tire, quantity, inputs)
            away.append(float(sensitivities(tire, quantity, inputs)[0][0] - expected[0]))
            index = {name: i for i, name in enumerate(names)}
            rows.append([float(slopes[index[n], 0]) if n in index else 0.0 for n in self.names])
        if not rows:
            return 1.0
        derivatives = np.array(rows)
        return self._tail(np.array(away), derivatives @ self.covariance @ derivatives.T, float(len(rows)))

    def _tail(self, away: FloatArray, covariance: FloatArray, count: float) -> float:
        distance = float(away @ np.linalg.solve(covariance, away))
        return float(fdtrc(max(count, 1.0), self.freedom, distance / max(count, 1.0)))

    def from_family(self, posterior: Mapping[str, float]) -> tuple[str, ...]:
        """Return the coefficients that the data hardly determine; those that were not freed among them."""
        prior = dict(zip(self.names, np.sqrt(np.diag(self.covariance)), strict=True))
        shares = {name: 1.0 - (posterior.get(name, deviation) / deviation) ** 2 for name, deviation in prior.items()}
        return tuple(name for name, share in shares.items() if share < FROM_DATA and name not in self.unknown)


def _correlation(residual: FloatArray) -> FloatArray:
    """Return the correlations of coefficients, shape (n, n), shrunk by their sampling errors.

    `residual`, shape (m, n): of m tires.
    """
    m, n = residual.shape
    size = np.sqrt(np.sum(residual**2, axis=0) / max(m - 1, 1))
    products = np.einsum("mi,mj->mij", *(2 * (residual / np.where(size > 0.0, size, 1.0),)))
    correlation = products.sum(axis=0) / max(m - 1, 1)
    error = m / max(m - 1, 1) ** 3 * np.sum((products - products.mean(axis=0)) ** 2, axis=0)
    away = ~np.eye(n, dtype=bool)
    squares = float(np.sum(correlation[away] ** 2))
    kept = max(0.0, 1.0 - float(np.sum(error[away])) / squares) if m > 2 and squares > 0.0 else 0.0
    return np.asarray(np.where(away, kept * correlation, 1.0))


def _varied(model: Model) -> tuple[str, ...]:
    """Return the coefficients of a model that differ among tires: those with bounds that a fit frees."""
    return tuple(
        n
        for n, declaration in model.coefficients.items()
        if declaration.fitted and isfinite(declaration.lower) and isfinite(declaration.upper)
    )


def _means(tires: Sequence[Tire]) -> dict[str, float]:
    """Return the geometric means of the covariates of some tires."""
    names = [name for name in COVARIATES if all(tire.values.get(name, 0.0) > 0.0 for tire in tires)]
    return {name: float(np.exp(np.mean([np.log(tire.values[name]) for tire in tires]))) for name in names}


def _places(tires: Sequence[Tire], levels: Mapping[str, float]) -> tuple[FloatArray, FloatArray]:
    """Return the covariates of the tires and of the new one, from the mean of the family, shapes (m, k) and (k,)."""
    means = _means(tires)
    logs = np.log([[tire.values[name] / mean for name, mean in means.items()] for tire in tires])
    logs = logs.reshape(len(tires), len(means))
    new = np.log([levels[name] / mean for name, mean in means.items()])
    spread = np.sqrt(np.mean(logs**2, axis=0))
    varied = spread > ROUNDING
    return logs[:, varied] / spread[varied], new[varied] / spread[varied]


def _check_nominal(tires: Sequence[Tire], nominal: Mapping[str, float]) -> None:
    for name, what, unit in (("FNOMIN", "nominal load", "N"), ("UNLOADED_RADIUS", "radius", "m")):
        values = [tire.values[name] for tire in tires]
        if name in nominal and not min(values) / MAX_RATIO <= nominal[name] <= max(values) * MAX_RATIO:
            raise FitError(
                f"family: the {what} {nominal[name]:g} {unit} is far from that of its tires, {min(values):g} to "
                f"{max(values):g} {unit}: the tire is outside the family"
            )
