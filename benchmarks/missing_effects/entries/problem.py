"""A case as a regression, for entries without a model of their own: baseline columns, and named features.

Of a tire, the baseline model is fitted by ``tirefmu.fit``; its columns are the derivatives by its coefficients. A
feature is the response to an effect in its simplest form, linear in an input. Products of two inputs are features of
UNKNOWN. Offset and drift of a channel of a tire are errors of the bench, which are not predicted.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import combinations

import numpy as np
import pandas as pd

from ..answers import UNKNOWN, Answer, Case, FloatArray
from .features import tire_responses
from .system_features import BASE, RESPONSES

#: Inputs that are no variables of an unknown effect.
NO_VARIABLES = ("t", "phit")


@dataclass(frozen=True, eq=False)
class Channel:
    """A channel; rows are those of the recording (n), then of the other maneuvers (m).

    - `y`, shape (n,): residual of the baseline model. `noise`: its standard deviation.
    - `base`, shape (n + m, k): columns that every model has. `offset`, shape (m,): the baseline model's force.
    - `names`, `variables`: of the features; `columns`, shape (n + m, f), of root mean square one over the recording.
    """

    y: FloatArray
    noise: float
    base: FloatArray
    offset: FloatArray
    names: tuple[str, ...]
    variables: tuple[tuple[str, ...], ...]
    columns: FloatArray

    @property
    def projected(self) -> tuple[FloatArray, FloatArray]:
        """Residual, shape (n,), in noise deviations, and features, shape (n, f), without what the base explains."""
        n = len(self.y)
        q, _ = np.linalg.qr(self.base[:n] / np.linalg.norm(self.base[:n], axis=0))
        y, x = self.y / self.noise, self.columns[:n]
        return y - q @ (q.T @ y), x - q @ (q.T @ x)

    def forces(self, chosen: list[int]) -> FloatArray:
        """Return the forces on the other maneuvers with some of the features, by least squares, shape (m,)."""
        n = len(self.y)
        columns = np.concatenate([self.base, self.columns[:, chosen]], axis=1)
        columns = columns / np.linalg.norm(columns[:n], axis=0)
        values = np.linalg.lstsq(columns[:n], self.y, rcond=1e-9)[0]
        return np.asarray(self.offset + columns[n:] @ values)


def channels_of(case: Case) -> dict[str, Channel]:
    """Return the channels of a case."""
    n, x = len(case.recording), inputs_of(case)
    rows = len(x["t"])
    if case.about["system"] == "tire":
        offsets, bases, responses = tire_responses(case, x)
    else:
        bases = {channel: np.stack([BASE[column](x) for column in columns], axis=1)
                 for channel, columns in case.about["base"].items()}  # fmt: skip
        offsets = {channel: np.zeros(rows) for channel in bases}
        responses = {name: RESPONSES[case.about["system"]][name](x) for name in case.about["candidates"]}
    products = _products(x, n)
    found = {}
    for channel, base in bases.items():
        named = [(name, (), column) for name, by_channel in responses.items() for column in by_channel.get(channel, ())]
        scale = x.get("Fz", 1.0)
        both = [*named, *((UNKNOWN, pair, scale * column) for pair, column in products.items())]
        columns = np.stack([column for *_, column in both], axis=1)
        size = np.sqrt(np.mean(columns[:n] ** 2, axis=0))
        y = case.recording[channel].to_numpy(dtype=np.float64) - offsets[channel][:n]
        noise = float(np.median(np.abs(np.diff(y, 2))) / 0.6745 / np.sqrt(6.0))
        if "Fz" in x:
            errors = np.where(np.arange(rows) < n, [np.ones(rows), x["t"] - np.mean(x["t"][:n])], 0.0)
            base = np.concatenate([base, errors.T], axis=1)
        base = base[:, np.linalg.norm(base[:n], axis=0) > 0.0]
        names, pairs = tuple(name for name, *_ in both), tuple(pair for _, pair, _ in both)
        columns = columns / np.where(size > 0.0, size, 1.0)
        found[channel] = Channel(y, noise, base, offsets[channel][n:], names, pairs, columns)
    return found


def inputs_of(case: Case) -> dict[str, FloatArray]:
    """Return the inputs of the recording, followed by those of the other maneuvers."""
    whole = pd.concat([case.recording, case.other])
    return {str(name): whole[name].to_numpy(dtype=np.float64) for name in case.other}


def scaled(x: Mapping[str, FloatArray], n: int) -> dict[str, FloatArray]:
    """Return the varying inputs with mean 0 and deviation 1 over the first n rows."""
    varying = {name: values for name, values in x.items() if name not in NO_VARIABLES and np.ptp(values[:n]) > 0.0}
    return {name: (values - np.mean(values[:n])) / np.std(values[:n]) for name, values in varying.items()}


def _products(x: Mapping[str, FloatArray], n: int) -> dict[tuple[str, ...], FloatArray]:
    return {(a, b): one * other for (a, one), (b, other) in combinations(scaled(x, n).items(), 2)}


def regression(case: Case, select: Callable[[Channel], tuple[list[int], FloatArray]]) -> Answer:
    """Return the answer of a regression of each channel.

    `select`: returns the selected features and a probability of each feature, shape (f,). The probability of a name is
    the largest one of its features.
    """
    found: dict[str, None] = {}
    variables, probabilities, forces = set[str](), dict[str, float](), {}
    for force, channel in channels_of(case).items():
        selected, probability = select(channel)
        for i in selected:
            found[channel.names[i]] = None
            variables |= set(channel.variables[i])
        for name, value in zip(channel.names, probability.tolist(), strict=True):
            probabilities[name] = max(probabilities.get(name, 0.0), value)
        forces[force] = channel.forces(selected)
    return Answer(tuple(found), probabilities, tuple(sorted(variables)), pd.DataFrame(forces))


def at_least(least: float, share: FloatArray) -> tuple[list[int], FloatArray]:
    """Return the features with at least a share, which is their probability."""
    return [int(i) for i in np.flatnonzero(share >= least)], share
