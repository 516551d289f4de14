"""What a batch keeps of each fit: verdict, reasons and goodness of fit, as JSON and as rows of a table."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from math import isfinite
from typing import Any

import numpy as np
import pandas as pd

from ...fitting import FitResult
from ...fitting.results.verdict import GOOD, LIMITED
from .resumable import BatchResult


@dataclass(frozen=True)
class JobResult(BatchResult):
    """The result of one fit of a batch.

    - `status`: the verdict of the fit ("good", "usable with limits", "not usable"); "failed" for invalid data or
      options, "lost" if the process ended or the program has an error.
    - `reasons`: in order of weight.
    - `rows`: measured rows.
    - `seconds`: of the fit.
    - `channels`: by channel over all recordings: ``rmse`` (N, N m) and the lowest ``r2``; None if it is not finite.
    - `values`: coefficients of the tire.
    """

    model: str = ""
    rows: int = 0
    seconds: float = 0.0
    channels: Mapping[str, Mapping[str, float | None]] = field(default_factory=dict)
    values: Mapping[str, float] = field(default_factory=dict)

    @property
    def usable(self) -> bool:
        """Whether there is a usable tire."""
        return self.status in (GOOD, LIMITED)


def result_of_fit(name: str, fit: FitResult) -> JobResult:
    """Return what a batch keeps of a fit."""
    rows, channels = 0, {}
    for channel in dict.fromkeys(agreement.channel for agreement in fit.channels):
        parts = [agreement for agreement in fit.channels if agreement.channel == channel]
        counts = np.array([part.rows for part in parts])
        squares = counts @ np.array([part.rmse for part in parts]) ** 2
        r2 = float(min(part.r2 for part in parts))
        channels[channel] = {"rmse": float(np.sqrt(squares / counts.sum())), "r2": r2 if isfinite(r2) else None}
        rows = max(rows, int(counts.sum()))
    verdict = fit.verdict
    return JobResult(
        name, verdict.word, verdict.reasons, fit.tire.model, rows, fit.run.seconds, channels, dict(fit.tire.values)
    )


def table_of(results: Iterable[JobResult]) -> pd.DataFrame:
    """Return a row for each job: status, reasons, model, rows, seconds, RMSE and R2 by channel, coefficients.

    >>> table = table_of([JobResult("front", "failed", ("front.csv: no rows",))])
    >>> table[["name", "status", "reasons"]].to_numpy().tolist()
    [['front', 'failed', 'front.csv: no rows']]
    """
    rows = []
    for result in results:
        row: dict[str, Any] = {
            "name": result.name, "status": result.status, "reasons": "; ".join(result.reasons), "model": result.model,
            "rows": result.rows, "seconds": result.seconds,
        }  # fmt: skip
        for channel, fit in result.channels.items():
            row |= {f"RMSE_{channel}": fit["rmse"], f"R2_{channel}": fit["r2"]}
        rows.append({**row, **result.values})
    return pd.DataFrame(rows)
