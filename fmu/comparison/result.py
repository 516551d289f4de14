"""The result of `check`, with its table and first figure in a notebook."""

from __future__ import annotations

from dataclasses import dataclass

from ...tires.notebook import html_summary, html_table
from .compared import Compared
from .figures import check_figures


@dataclass(frozen=True, repr=False)
class CheckResult(Compared):
    """The result of `check`.

    Attributes
    ----------
    fmu, source : str
        Names of the FMU and of the recording.
    fmi_version : str
        As the FMU states it, such as "3.0".
    rows, segments : int
        Number of simulated rows, and of segments with a new initialization.
    channels : tuple of Channel
        The measured outputs of the FMU.
    evaluation_difference : float or None
        Largest |FMU - direct| / (1 + |direct|) over all rows and outputs, where direct is the direct evaluation of the
        embedded tire; None without an embedded tire.
    problems : tuple of str
        Problems found by fmpy's validation.
    tolerance : float or None
        Largest allowed `Channel.relative_rmse`.
    simulated : pandas.DataFrame
        The FMU's outputs by row, ISO signs.
    recording : pandas.DataFrame
        The same rows of the recording: ``t`` (equal steps if it had none), inputs and measured outputs, ISO signs.
    starts : tuple of int
        The first row of each segment.
    not_fitted : tuple of str
        Measured outputs that the data of the embedded tire did not show: they say nothing about it.
    without_slip : tuple of str
        Measured outputs whose slips stay at zero in the recording: a low R2 of theirs states nothing about the tire.
    """

    def _repr_html_(self) -> str:
        """Return the comparison as HTML with the picture of the first channel, for a notebook."""
        first, _, *rest = str(self).split("\n")
        rows = [(c.name, c.measured, c.rmse, c.unit, c.relative_rmse, c.r2, c.r2_uncentred) for c in self.channels]
        header = ["channel", "rows", "RMSE", "unit", "of max", "R2", "R2 uncentred"]
        from ...drawing.picture import html_image  # imports matplotlib, which is slow

        notes = html_summary("\n".join(rest[len(rows) :]))
        return html_summary(first, html_table(header, rows), notes, *map(html_image, check_figures(self)[:1]))
