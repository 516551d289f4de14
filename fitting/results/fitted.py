"""What a fit found, without what is judged, written and drawn from it."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import cached_property
from math import inf, nan
from typing import Annotated, ClassVar, Self

import numpy as np
import pandas as pd

from ...boundary.errors import UnknownName
from ...measurements import DataFinding
from ...tires.tire import Tire
from ..checks.diagnostics import Findings, find
from ..checks.residuals import Residuals
from ..constraints.physical import TOLERANCE
from ..constraints.verification import Margin
from ..data.fit_data import ExcludedRows
from ..temperature.fitted_temperature import FittedTemperature
from ..uncertainty.discrepancy import Discrepancy
from ..uncertainty.sandwich import Direction, Uncertainty
from .informed_discrepancies import informed_discrepancies
from .records import Bootstrap, BoundConsequence, ChannelFit, FittedCoefficient, HeldOut
from .stages import FitRecord, StageResult


@dataclass(frozen=True, repr=False)
class Fitted:
    """What a fit found; its fields are described in `FitResult`."""

    #: The convention of margins.
    margins_signs: ClassVar[str] = "adapted-sae"

    tire: Tire
    signs: Annotated[str, "of coefficients, covariance and findings; values are in ISO-W"]
    coefficients: tuple[FittedCoefficient, ...]
    channels: tuple[ChannelFit, ...]
    run: FitRecord
    margins: tuple[Margin, ...] = ()
    notes: tuple[str, ...] = ()
    data_findings: tuple[DataFinding, ...] = ()
    excluded_rows: Annotated[tuple[ExcludedRows, ...], "rows that were not fitted"] = ()
    held_out: tuple[HeldOut, ...] = ()
    bootstrap: Bootstrap | None = None
    temperature: FittedTemperature | None = None
    bounds: Annotated[tuple[BoundConsequence, ...], "what changes beyond the bound of a coefficient at one"] = ()
    uncertainty: Uncertainty = field(default_factory=Uncertainty, compare=False)
    residuals: Residuals | None = None

    @property
    def stages(self) -> tuple[StageResult, ...]:
        """The stages in order: rows, iterations, cost."""
        return self.run.stages

    @property
    def whole_stages(self) -> tuple[StageResult, ...]:
        """The stages that used all of their rows, from which intervals, bootstrap and consequences follow."""
        return tuple(stage for stage in self.stages if len(stage.numbers))

    def determined_by(self, stage: StageResult) -> tuple[str, ...]:
        """Return the free coefficients of a stage that it was the last to determine."""
        names = {c.name for c in self.coefficients if c.determined and c.stage == stage.name}
        return tuple(name for name in stage.problem.free if name in names)

    @property
    def directions(self) -> tuple[Direction, ...]:
        """Combinations of coefficients that are not identifiable."""
        return self.uncertainty.directions

    @property
    def covariance(self) -> pd.DataFrame:
        """Covariance of the coefficients by name, in their units and `signs`, under time-correlated noise.

        Half an interval is 1.96 times the root of the diagonal. Rows and columns are NaN for a coefficient without a
        finite interval (at a bound, not identifiable, or not freed by a stage with all its rows). A stage assumes that
        the values of earlier stages are known, so the covariance of coefficients of different stages
        (`FittedCoefficient.stage`) is 0.
        """
        return self.uncertainty.covariance

    @property
    def correlation(self) -> pd.DataFrame:
        """Correlation of the coefficients by name; NaN if the covariance is NaN or a variance is 0."""
        deviation = np.sqrt(np.diag(self.covariance)) if len(self.covariance) else np.empty(0)
        deviation = np.where(deviation > 0.0, deviation, nan)
        return self.covariance.div(deviation, axis=0).div(deviation, axis=1)

    def in_signs(self, signs: str) -> Self:
        """Return the same result with coefficients in another sign convention.

        Parameters
        ----------
        signs : {"iso", "adapted-sae"}
            "adapted-sae" is the convention of the formula for data in SAE and adapted SAE.

        Returns
        -------
        FitResult
            With the same tire.

        Raises
        ------
        UnknownName
            If coefficients do not exist in this convention.
        """
        if signs not in ("iso", "adapted-sae"):
            raise UnknownName("sign convention of coefficients", signs, ("iso", "adapted-sae"))
        if signs == self.signs:
            return self
        declarations = self.tire.symbolic_model.coefficients
        flips = np.array([-1.0 if declarations[name].flips else 1.0 for name in self.covariance.index])
        return replace(
            self,
            signs=signs,
            coefficients=tuple(c.mirrored() if declarations[c.name].flips else c for c in self.coefficients),
            uncertainty=self.uncertainty.mirrored(np.outer(flips, flips)),
            residuals=self.residuals and replace(self.residuals, signs=signs),
            bootstrap=self.bootstrap and self.bootstrap.mirrored(lambda name: declarations[name].flips),
        )

    @cached_property
    def findings(self) -> Findings:
        """Diagnostics of the fit, computed at the first access; empty without fitted rows."""
        if self.residuals is None:
            return Findings()
        free = [c.name for c in self.coefficients if not c.at_bound or c.interval == inf]
        unseen = [(c.name,) for c in self.coefficients if not c.determined]
        effective: dict[str, float] = {}
        for c in self.channels:  # a hundredth of the rows if no stage used all rows of a channel
            effective_rows = c.effective_rows if c.effective_rows > 0 else 0.01 * c.rows
            effective[c.channel] = effective.get(c.channel, 0.0) + effective_rows
        bounded = [c.name for c in self.coefficients if c.at_bound]
        combinations = [tuple(n for n in d.coefficients if n in free and n not in bounded) for d in self.directions]
        undetermined = [names for names in (*combinations, *unseen) if names]
        return find(self.residuals, free, undetermined, bounded, effective)

    @cached_property
    def discrepancies(self) -> tuple[Discrepancy, ...]:
        """Errors of the form, with what the characteristics of the data say of them; computed at the first access."""
        return informed_discrepancies(self.tire, self.residuals, self.uncertainty.discrepancies, self.findings)

    @property
    def ok(self) -> bool:
        """Whether all stages ran and converged and all constraints are satisfied. The tire may still be not usable."""
        return (
            not self.run.interrupted
            and all(stage.converged for stage in self.stages)
            and all(m.margin >= -TOLERANCE for m in self.margins)
        )

    @property
    def status(self) -> str:
        """Status of the fit in one line."""
        failed = [stage for stage in self.stages if not stage.converged]
        violated = [margin for margin in self.margins if not margin.margin >= -TOLERANCE]
        if self.run.interrupted:
            return f"interrupted in {self.run.interrupted}: the values are the best so far"
        if failed:
            return f"not converged: stage {failed[0].name!r} ended: {failed[0].reason}"
        if violated:
            return f"constraint {violated[0].constraint} violated by {-violated[0].margin:.3g}"
        return "converged"

    @property
    def rmse(self) -> dict[str, float]:
        """Root mean square error over the fitted rows by channel, over all recordings, in the channel's unit."""
        sums: dict[str, tuple[int, float]] = {}
        for c in self.channels:
            if c.fitted_rows:
                rows, squares = sums.get(c.channel, (0, 0.0))
                sums[c.channel] = rows + c.fitted_rows, squares + c.fitted_rows * c.fitted_rmse**2
        return {channel: float(np.sqrt(squares / rows)) for channel, (rows, squares) in sums.items()}

    def channel(self, recording: str, channel: str) -> ChannelFit:
        """Return the goodness of fit of a channel of a recording."""
        (channel_fit,) = (c for c in self.channels if c.recording == recording and c.channel == channel)
        return channel_fit
