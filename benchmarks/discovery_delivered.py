"""Comparison of the tire that a diagnosis delivers with the tire from which it starts, and with what it reports."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt
import pandas as pd
from diagnosis.case import Case
from diagnosis.recomputation import recomputed, with_derived

from tirefmu.diagnosis import Diagnosis
from tirefmu.diagnosis.signals import FORMULA_SIGNS
from tirefmu.tires.tire import Tire

FloatArray = npt.NDArray[np.float64]

#: A residual is larger, or differs from the reported one, beyond this share.
TOLERANCE = 0.02
#: Median absolute deviation of a normal distribution with a standard deviation of 1.
NORMAL_MEDIAN = 0.6745
#: Number of random tires, and the share of a force below which an increase of its error does not count.
TIRES, MIN_SHARE = 16, 0.01


@dataclass(frozen=True)
class Delivered:
    """The delivered tire over the start tire: ratios of root mean square residuals, each of the worst channel.

    Errors against noise-free forces include the noise of the channel, so that a change below it does not count.

    - `recording`, `holdout`: on the training rows and the hold-out rows of the recording.
    - `recording_together`, `holdout_together`: the same, of all channels together (root mean square of their ratios).
    - `true_recording`, `true_holdout`: on the same rows, against noise-free forces: noise that happens to resemble an
      effect does not count.
    - `manoeuvres`, `operating`: against noise-free forces, on other manoeuvres and over the operating range.
    - `increase`: largest increase of the error over the operating range, relative to the root mean square force.
    - `spreads`: the same relative to the spread of the identified effects among tires.
    - `reported`: reported residual over the residual recomputed from the delivered tire, for each channel and set of
      rows.
    """

    recording: float
    holdout: float
    recording_together: float
    holdout_together: float
    true_recording: float
    true_holdout: float
    manoeuvres: float
    operating: float
    increase: float
    spreads: float
    reported: tuple[float, ...]

    @property
    def consistent(self) -> bool:
        """Whether all reported residuals are those of the delivered tire."""
        return all(abs(ratio - 1.0) <= TOLERANCE for ratio in self.reported)


def delivered(case: Case, result: Diagnosis) -> Delivered:
    """Compare the delivered tire."""
    channels = list(result.gap["train"])
    held = result.holdout_mask(len(case.table))
    tires = (result.base_tire, result.tire)
    start, final = (
        recomputed(result, tire, case.table, case.signs, end) for tire, end in zip(tires, ("_base", ""), strict=True)
    )
    typical = _typical_rows(case, result)
    on_rows = {
        part: [tuple(_rms(one[name][rows & typical[name]]) for one in (start, final)) for name in channels]
        for part, rows in (("train", ~held), ("holdout", held))
    }
    noise = np.array([_noise(case, name) for name in channels])
    truth = with_derived(result, case.truth, case.signs)
    true = {
        part: np.array([_errors(tire, truth, case.signs, channels, chosen) for tire in tires])
        for part, chosen in (("train", ~held), ("holdout", held))
    }
    manoeuvres, operating = (
        np.array([_errors(tire, table, case.signs, channels) for tire in tires])
        for table in (case.test, case.operating)
    )
    size = np.array([_rms(case.operating[name].to_numpy()) for name in channels])
    increase = operating[1] - operating[0]
    spread = np.maximum(_spread(result, case, channels), MIN_SHARE * size)
    reported = tuple(
        result.gap[part][name]["after"] / after
        for part, pairs in on_rows.items() for name, (_, after) in zip(channels, pairs, strict=True) if after > 0.0
    )  # fmt: skip
    return Delivered(
        recording=max(after / before for before, after in on_rows["train"]),
        holdout=max(after / before for before, after in on_rows["holdout"]),
        recording_together=_together(on_rows["train"]),
        holdout_together=_together(on_rows["holdout"]),
        true_recording=_worst(true["train"], noise),
        true_holdout=_worst(true["holdout"], noise),
        manoeuvres=_worst(manoeuvres, noise),
        operating=_worst(operating, noise),
        increase=float((increase / np.maximum(size, 1e-9)).max()),
        spreads=float((increase / np.maximum(spread, 1e-9)).max()),
        reported=reported,
    )


def _typical_rows(case: Case, result: Diagnosis) -> dict[str, npt.NDArray[np.bool_]]:
    """Return the rows of each channel that are measured, that are compared, and that are not listed as outliers."""
    found, skipped = {}, np.arange(len(case.table)) % result.recording["compared_every"] > 0
    for name, outliers in result.recording["outlier_rows"].items():
        found[name] = np.isfinite(case.table[name].to_numpy(dtype=np.float64, copy=True))
        found[name][outliers] = False
        found[name][skipped] = False
    return found


def _noise(case: Case, channel: str) -> float:
    """Return the standard deviation of a channel's noise, from differences of successive rows."""
    steps = np.diff(case.table[channel] - case.truth[channel])
    return float(np.median(np.abs(steps)) / NORMAL_MEDIAN / np.sqrt(2.0))


def _errors(
    tire: Tire, table: pd.DataFrame, signs: str, channels: Sequence[str],
    rows: npt.NDArray[np.bool_] | slice = slice(None),
) -> list[float]:  # fmt: skip
    """Return the root mean square error of each channel against noise-free forces, at some of the rows."""
    computed = tire.evaluate(table.drop(columns=list(channels)), signs=signs)
    return [_rms((computed[name] - table[name]).to_numpy()[rows]) for name in channels]


def _spread(result: Diagnosis, case: Case, channels: Sequence[str]) -> FloatArray:
    """Return the spread of each force among tires with other sizes of the identified effects, over the operating range.

    The root mean square of the standard deviation over random tires, whose coefficients have the prior of the model.
    Those without finite forces are no tires.
    """
    tire = result.tire.in_signs(FORMULA_SIGNS)
    model, rng, forces = tire.symbolic_model, np.random.default_rng(0), []
    delivered = [name for one in result.found for name in one.coefficients if name in model.coefficients]
    names = delivered if result.delivered else []
    table = case.operating.drop(columns=list(channels))
    for _ in range(TIRES if names else 0):
        values = dict(tire.values)
        for name in names:
            declared = model.coefficients[name]
            center, deviation = model.prior_center.get(name, declared.default), model.prior_spread.get(name, 0.0)
            values[name] = float(np.clip(rng.normal(center, deviation), declared.lower, declared.upper))
        computed = replace(tire, values=values).evaluate(table, signs=case.signs)[list(channels)].to_numpy()
        forces += [computed] * bool(np.isfinite(computed).all())
    return np.sqrt(np.mean(np.var(forces, axis=0), axis=0)) if forces else np.zeros(len(channels))


def _together(errors: list[tuple[float, float]]) -> float:
    return _rms(np.array([after / before for before, after in errors]))


def _worst(errors: FloatArray, noise: FloatArray) -> float:
    before, after = np.hypot(errors, noise)
    return float((after / before).max())


def _rms(values: FloatArray) -> float:
    return float(np.sqrt(np.mean(values**2)))
