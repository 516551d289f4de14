"""Panels of residuals over inputs exist where both were measured, and are labelled."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from tirefmu.drawing.residual_panels import residuals_over_inputs

ROWS = 60
SLIP = np.linspace(-0.1, 0.1, ROWS)
LATERAL = np.arange(ROWS) < ROWS // 2


def labels(figure):
    """Return the labels of the axes of the panels, in their order."""
    return [(panel.x, panel.y) for panel in figure.panels]


def test_a_panel_needs_rows_with_input_and_channel():
    """Two recordings: Fy with a temperature, Fx without one, and kappa varies for Fx only."""
    table = pd.DataFrame({"alpha": SLIP, "kappa": np.where(LATERAL, 0.0, SLIP), "Fz": 900.0})
    table["T"] = np.where(LATERAL, 30.0 + 100.0 * SLIP, np.nan)
    errors = np.cos(50.0 * SLIP)
    figure = residuals_over_inputs(
        table, {"Fx": np.where(LATERAL, np.nan, errors), "Fy": np.where(LATERAL, errors, np.nan)}, "iso"
    )
    assert labels(figure) == [
        ("α (deg)", "Fx (N)"), ("κ (-)", "Fx (N)"), ("α (deg)", "Fy (N)"), ("T (deg C)", "Fy (N)"),
    ]  # fmt: skip


def test_a_row_begins_with_its_first_panel():
    table = pd.DataFrame({"alpha": np.where(LATERAL, SLIP, 0.0), "kappa": np.where(LATERAL, 0.0, SLIP)})
    residuals = {"Fx": np.where(LATERAL, np.nan, 1.0), "Fy": np.where(LATERAL, 1.0, np.nan)}
    assert labels(residuals_over_inputs(table, residuals, "iso")) == [
        ("κ (-)", "Fx (N)"), ("α (deg)", "Fy (N)"),
    ]  # fmt: skip


def test_no_figure_without_an_input_or_a_channel():
    table = pd.DataFrame({"alpha": SLIP, "T": np.nan})
    assert residuals_over_inputs(table, {"Fy": np.full(ROWS, np.nan)}, "iso") is None
    assert residuals_over_inputs(table.assign(alpha=0.1), {"Fy": SLIP}, "iso") is None


def test_each_level_of_an_input_has_its_mean():
    loads = np.resize([200.0, 700.0, 900.0], ROWS)
    (panel,) = residuals_over_inputs(pd.DataFrame({"Fz": loads}), {"Fy": loads / 100.0}, "iso").panels
    (means,) = (series for series in panel.series if series.kind == "line" and series.marker)
    assert pytest.approx(np.array([[200.0, 2.0], [700.0, 7.0], [900.0, 9.0]])) == means.points.T
