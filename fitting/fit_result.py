"""The result of a fit: tire, coefficients, goodness of fit by channel, constraint margins, stages, diagnostics."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar

import pandas as pd

from ..boundary.json_schema import document, json_value, schema_of
from ..measurements import TableLike
from .results.fitted import Fitted
from .results.intervals import ListedInterval, interval, listed_intervals
from .results.summary import fit_html, fit_text
from .results.verdict import Verdict, verdict_of

if TYPE_CHECKING:
    from ..drawing.own_matplotlib import MatplotlibFigure


@dataclass(frozen=True, repr=False)
class FitResult(Fitted):
    """The result of a fit.

    Attributes
    ----------
    tire : Tire
        In ISO-W.
    signs : str
        Sign convention of ``coefficients``, ``covariance`` and ``findings``: "iso", as in the tire file, unless
        `in_signs` changed it. Margins are always in adapted SAE, the convention of the physical constraints.
    coefficients : tuple of FittedCoefficient
        The free coefficients: value, interval, bounds.
    channels : tuple of ChannelFit
        Goodness of fit of each recording and channel.
    run : FitRecord
        Stages, recipe, method and duration.
    margins : tuple of Margin
        The smallest margin of each physical constraint.
    notes : tuple of str
        Notes for the user: what was skipped, assumed or not determined.
    data_findings : tuple of DataFinding
        Problems in the recordings (`tirefmu.measurements.data_findings`).
    excluded_rows : tuple of ExcludedRows
        Rows that were not fitted, with the reason.
    held_out : tuple of HeldOut
        Results of a blocked cross-validation, if requested.
    bootstrap : Bootstrap or None
        Percentile intervals, if requested.
    temperature : FittedTemperature or None
        The fit of the heat balance to recorded temperatures, if requested.
    bounds : tuple of BoundConsequence
        What changes without the bound of each coefficient at a bound.
    uncertainty : Uncertainty
        ``covariance`` and ``directions`` (combinations of coefficients that are not identifiable), and what `interval`
        is computed from.
    residuals : Residuals or None
        The fitted rows, from which `findings` are computed.
    """

    #: Version of fit.json. New keys increment the second number, changed meanings the first.
    version: ClassVar[str] = "2.0"
    JSON_KEYS: ClassVar = (
        "version", "verdict.usable as ok", "verdict.word as verdict", "verdict.reasons", "status", "run.recipe",
        "run.method", "run.seconds", "tire.model", "tire.has as effects", "signs", "tire.values", "coefficients",
        "channels", "stages", "margins", "margins_signs", "directions", "bounds", "excluded_rows as set_aside",
        "held_out", "findings", "uncertainty.determined as covariance", "listed_intervals as intervals", "bootstrap",
        "temperature", "notes", "data_findings", "run.interrupted",
    )  # fmt: skip

    def __repr__(self) -> str:
        """Return a few lines: status, goodness of fit by channel, coefficients that are not determined."""
        return fit_text(self, self.verdict)

    def _repr_html_(self) -> str:
        """Return the same with a table of the coefficients and the fitted rows under the tire, for a notebook."""
        from ..drawing.picture import html_image  # imports matplotlib, which is slow
        from .reporting.figures import NotDrawn, figure_of_fit

        try:
            return fit_html(self, self.verdict) + html_image(figure_of_fit(self))
        except NotDrawn:
            return fit_html(self, self.verdict)

    @cached_property
    def verdict(self) -> Verdict:
        """Whether the tire is usable, with the reasons in order of weight; computed at the first access."""
        return verdict_of(self)

    def save(self, path: str | Path) -> None:
        """Write the tire to a .tir file; see `Tire.save`.

        Parameters
        ----------
        path : str or Path
            The file to write.
        """
        self.tire.save(path)

    def report(self, path: str | Path, recordings: TableLike | Iterable[TableLike]) -> None:
        """Write the report of the fit: one HTML page with verdict, figures, tables.

        Parameters
        ----------
        path : str or Path
            The file to write.
        recordings : path, DataFrame or Recording, or a sequence of them
            The fitted recordings, which the result does not contain.

        Raises
        ------
        FitError
            If the file cannot be written.
        DataError
            If a recording cannot be read, or lacks the measured outputs.
        """
        from .reporting.report import write_report  # imports matplotlib, which is slow

        write_report(self, recordings, path, findings=self.data_findings)

    def plot(self, kind: str = "pure", *, bands: bool = False, signs: str = "iso") -> MatplotlibFigure:
        """Draw the fitted rows and the tire.

        Parameters
        ----------
        kind : str
            "pure": the force or moment of each measured channel in pure slip, a line for each load. Otherwise the name
            of a figure of `tirefmu.fitting.draw_figures`, such as "pure_Fy", "combined", "stiffness" or "residuals".
        bands : bool
            Whether curves have their 95 % bands.
        signs : {"iso", "adapted-sae", "sae"}
            Convention in which the figure is drawn.

        Returns
        -------
        matplotlib.figure.Figure
            Not registered in pyplot: ``figure.savefig("fit.png")`` writes it.

        Raises
        ------
        UnknownName
            If the kind or the convention does not exist, or the rows have no data for this kind.
        FitError
            If the result has no rows that can be drawn, such as one without pure slip.
        """
        from ..drawing.picture import picture  # imports matplotlib, which is slow
        from .reporting.figures import figure_of_fit

        return picture(figure_of_fit(self, kind, bands=bands, signs=signs))

    def interval(
        self, quantity: str, table: TableLike, *, signs: str | None = None, level: float = 0.95
    ) -> pd.DataFrame:
        """Return a force or a named quantity at the rows of a table with its confidence interval (delta method).

        Parameters
        ----------
        quantity : str
            "Fy", "K_yalpha", "mu_x", ...
        table : path, DataFrame or Recording
            Inputs; an absent input has its nominal value.
        signs : str, optional
            Convention of the table and of the result; by default that of the format, and "iso" for a DataFrame.
        level : float
            Confidence level.

        Returns
        -------
        pandas.DataFrame
            ``value``, ``error`` (standard error under time-correlated noise, errors of the form of the model, and slow
            errors of the sensors, see `tirefmu.fitting.uncertainty`), ``lower`` and ``upper`` by row.

        Raises
        ------
        UnknownName, FitError, DataError, WrongType
            See `tirefmu.fitting.results.intervals.interval`.
        """
        return interval(self, quantity, table, signs=signs, level=level)

    @property
    def listed_intervals(self) -> tuple[ListedInterval, ...]:
        """The 95 % intervals of quantities and forces over the measured range, in ISO-W."""
        return tuple(listed_intervals(self))

    def table(self) -> pd.DataFrame:
        """Return the coefficients as a table, one row each."""
        return pd.DataFrame([vars(coefficient) for coefficient in self.coefficients])

    def to_json(self) -> dict[str, Any]:
        """Return the result as JSON values; a number that does not exist, such as a missing bound, is null."""
        return dict(json_value(self))


def fit_schema() -> dict[str, Any]:
    """Return the JSON Schema of fit.json."""
    return document("fit", FitResult.version, "Result of a fit", schema_of(FitResult, missing=True))
