"""An inspection of a run with known sweeps, conditions and drifts."""

from math import radians

import numpy as np
import pandas as pd
import pytest

from tirefmu import inspect
from tirefmu.drawing.labels import axis_label
from tirefmu.drawing.style import LIGHT_GRAY
from tirefmu.measurements import CHANNELS, Recording, inspected, inspection_figures


@pytest.fixture(scope="module")
def found(raw):
    (inspection,), _ = inspect([raw.recording])
    return inspection


def test_every_sweep_is_found_with_its_speed(found):
    assert len(found.sweeps) == 12  # four loads at three cambers
    assert [sweep.number for sweep in found.sweeps] == list(range(1, 13))
    for sweep in found.sweeps:
        assert sweep.moving == ("alpha",)
        assert sweep.rate[0] == pytest.approx(radians(4.0), rel=0.05)
        assert sweep.highest[0] == pytest.approx(radians(12.0), rel=0.01)
        assert sweep.lowest[0] == pytest.approx(radians(-12.0), rel=0.01)


def test_every_condition_is_found_with_its_rows(found, raw):
    loads = {round(condition.held["Fz"], -1) for condition in found.conditions}
    cambers = {round(np.degrees(condition.held["gamma"])) for condition in found.conditions}
    assert cambers == {0, 2, 4}
    assert len(loads) == 4
    rows = sum(condition.rows for condition in found.conditions)
    assert rows == pytest.approx(np.count_nonzero(~raw.between), rel=0.03)
    assert found.interval == pytest.approx(0.01)
    assert (found.segments, found.longest_gap) == (1, 0.0)


def test_drift_within_a_condition():
    clock = np.arange(4000) / 100.0
    alpha = 0.2 * np.sin(2.0 * np.pi * clock / 10.0)
    rows = {"t": clock, "alpha": alpha, "Fz": 900.0, "p": 80e3 + 50.0 * clock, "T": 50.0 + 0.5 * clock, "Fy": -alpha}
    inspection = inspected(Recording(pd.DataFrame(rows), "iso", "a.csv"))
    (condition,) = inspection.conditions
    assert condition.drift == pytest.approx({"p": 0.9 * 40.0 * 50.0, "T": 0.9 * 40.0 * 0.5}, rel=0.01)


def test_loads_are_positive_and_other_channels_as_recorded(raw):
    (inspection,), _ = inspect([raw.recording.with_signs("sae")])
    assert all(condition.held["Fz"] > 0.0 for condition in inspection.conditions)
    assert {channel.name: channel.highest for channel in inspection.channels}["Fz"] < 0.0


def test_a_panel_over_slip_has_one_level_of_the_other_inputs():
    """Rows at other cambers, pressures or combined slip are gray: each shape of points is one curve."""
    steps = np.linspace(-0.2, 0.2, 101)
    parts = [(0.0, 0.0, 80e3), (0.05, 0.0, 80e3), (0.0, 0.04, 80e3), (0.0, 0.0, 60e3), (0.0, 0.0, 80e3)]
    table = pd.concat(
        [
            pd.DataFrame({"alpha": steps, "kappa": kappa, "gamma": gamma, "Fz": 900.0, "p": p}).assign(part=number)
            for number, (kappa, gamma, p) in enumerate(parts)
        ],
        ignore_index=True,
    )
    table["t"], table["Fy"] = 0.01 * np.arange(len(table)), -1000.0 * table["alpha"] + 10.0 * table["part"]
    inspection = inspected(Recording(table.drop(columns="part"), "iso", "a.csv"))
    (panel,) = inspection_figures(inspection)[0].panels
    drawn = {series.color: np.sort(series.points[1]) for series in panel.series}
    included = table[inspection.exclusion.included]
    pure = included[included["part"].isin([0, 4])]
    gray = drawn.pop(LIGHT_GRAY)
    (points,) = drawn.values()
    np.testing.assert_allclose(points, np.sort(pure["Fy"]))
    assert len(gray) + len(points) == len(included)
    assert "80 kPa" in panel.title


def test_every_channel_is_drawn():
    """One that no equation reads has a row of `CHANNELS` and nothing else."""
    ramp = np.linspace(0.0, 1.0, 301)
    table = pd.DataFrame({"t": ramp})
    for name, declared in CHANNELS.items():
        low, high = declared.typical or (0.0, 500.0)
        table[name] = low + (high - low) * ramp
    figures = inspection_figures(inspected(Recording(table, "iso", "a.csv")))
    (over_time,) = (figure for figure in figures if "time (s)" in {panel.x for panel in figure.panels})
    assert {panel.y for panel in over_time.panels} == {axis_label(name) for name in CHANNELS if name != "t"}


def test_no_panel_is_without_content():
    """A slip or a channel that does not vary has none; a force over the other slip only beside a slip of its own."""
    steps = np.linspace(-0.2, 0.2, 201)
    side = pd.DataFrame({"alpha": steps, "kappa": 0.0, "Fz": 900.0, "Fx": np.sin(50.0 * steps), "Fy": -9e3 * steps})
    along = pd.DataFrame({"kappa": steps, "alpha": -0.08, "Fz": 900.0, "Fx": 9e3 * steps, "Fy": 500.0 - 90.0 * steps})
    for table, expected in ((side, ["Fy over α"]), (along, ["Fx over κ", "Fy over κ"])):
        table["t"], table["T_road"] = 0.01 * np.arange(len(table)), np.linspace(300.0, 310.0, len(table))
        over_slip, over_time, *_ = inspection_figures(inspected(Recording(table, "iso", "a.csv")))
        shown = [f"{panel.y.partition(' ')[0]} over {panel.x.partition(' ')[0]}" for panel in over_slip.panels]
        assert shown == expected
        drawn = [panel.y.partition(" ")[0] for panel in over_time.panels]
        assert "Fz" not in drawn
        assert ("α" in drawn, "κ" in drawn) == (table is side, table is along)
        (road,) = (panel for panel in over_time.panels if panel.y == "T_road (deg C)")
        assert np.nanmax(road.series[0].points[1]) == pytest.approx(36.85)
