"""The response over time on the page: that of `Tire.evaluate`, and its controls."""

from __future__ import annotations

from functools import cache

import numpy as np
import pandas as pd
import pytest

from tirefmu.symbolic.added import library
from tirefmu.tires import Tire

from .test_page import until

VALUES = {
    "FNOMIN": 4000.0, "UNLOADED_RADIUS": 0.3, "SIGX": 0.2, "SIGY": 0.4, "HMU": 0.2, "HTAU": 6.0,
    "SHMUX": 0.05, "SHMUY": 0.05, "SHKX": 0.08, "SHKY": 0.08, "BIMU": 0.1, "BIWORK": 5.0, "LLMU": 0.5, "LLK": 0.5,
}  # fmt: skip
EFFECTS = ("relax_lat", "relax_lon", "heat_friction", "slip_history", "break_in", "load_lag")
#: Input, course, from, to, duration, slip angle.
COURSES = [
    ("alpha", "step", 0.0, 0.12, 0.5, 0.0),
    ("alpha", "sweep", 0.02, 0.2, 3.0, 0.0),
    ("Fz", "step", 4e3, 6e3, 1.0, 0.05),
]
#: Rows of the tire's own response in each interval of the page's: its laws assume that slips do not turn between rows.
ROWS = 8


@cache
def tire_with_memory():
    """Return a tire with slips that lag, states that inputs drive, that forces drive, a hysteresis, an accumulation.

    The model has the whole library, as in other tests: it is printed and compiled once.
    """
    return Tire("mf61", VALUES, effects=EFFECTS, added=tuple(library().values()))


@cache
def warm_tire():
    """Return a tire whose grip and stiffness follow the temperature that it predicts."""
    return Tire("mf61", {**VALUES, "TREF": 60.0, "TMU2": -1.5e-4, "TKA": 0.002, "THACT": 1.0},
                effects=("temp_friction", "temp_stiffness", "temperature"), added=tire_with_memory().added)  # fmt: skip


def evaluated(found, name, kind, duration, alpha):
    """Return the tire's own response at the times of the page's."""
    t, values = np.array(found["t"]), np.array(found["input"])
    fine, held = np.linspace(0.0, duration, ROWS * (len(t) - 1) + 1), kind == "step"
    values = np.repeat(values, ROWS)[: len(fine)] if held else np.interp(fine, t, values)
    inputs = {
        "kappa": 0.0,
        "alpha": alpha,
        "Fz": tire_with_memory().nominal("Fz"),
        "V": tire_with_memory().nominal("V"),
        name: values,
    }
    return tire_with_memory().evaluate(pd.DataFrame({**inputs, "t": fine}), hold=held).iloc[::ROWS]


def course_of(name, kind, start, end, duration):
    return {"input": name, "kind": kind, "from": start, "to": end, "duration": duration}


def test_it_is_that_of_the_tire_and_its_controls_act(opened):
    page = opened(tire_with_memory())
    for *course, alpha in COURSES:
        name, kind, _, _, duration = course
        selected = f"{{ ...view.inputs, alpha: {alpha} }}"
        found = page.evaluate(f"(course) => timeResponse(now, {selected}, course)", course_of(*course))
        assert found["t"][-1] == pytest.approx(duration)
        expected = evaluated(found, name, kind, duration, alpha)
        steady = tire_with_memory().evaluate(expected[["kappa", "alpha", "Fz", "V"]])
        columns = {key: pd.DataFrame(found[key]) for key in ("forces", "steady", "states")}
        for output in ("Fx", "Fy", "Mz"):
            size = np.abs(expected[output]).max()
            np.testing.assert_allclose(columns["forces"][output], expected[output], atol=1e-3 * size + 1e-9)
            np.testing.assert_allclose(columns["steady"][output], steady[output], atol=1e-9 * size + 1e-9)
        assert set(columns["states"]) == {"tan_alpha_lagged", "kappa_lagged", *tire_with_memory().states}
        for state in tire_with_memory().states:
            size = np.abs(expected[state]).max()
            np.testing.assert_allclose(columns["states"][state], expected[state], atol=2e-3 * size + 1e-12)
        memory = np.abs(np.subtract(expected["Fy"], steady["Fy"])).max()
        assert memory > 0.02 * np.abs(expected["Fy"]).max()
    assert_controls_act(page)


def assert_controls_act(page):
    """The chosen course is drawn and written to the address, from which it is read; a switched effect has no state."""
    shown = "timePanel.charts.map(({ name, chart }) => [name, chart.figure.hidden, chart.curves?.at(-1).y.length])"
    until(page, "timePanel.charts.every(({ chart }) => chart.curves)")
    charts = page.evaluate(shown)
    assert [name for name, _, _ in charts][-1] in tire_with_memory().states
    assert {count for _, hidden, count in charts if not hidden} == {301}
    page.get_by_label("sweep", exact=True).check()
    page.locator("#time-input").select_option("Fz")
    page.locator("#time-to").fill("7000")
    page.locator("#time-duration").fill("2")
    page.locator("#time-duration").press("Enter")
    until(page, "location.hash.includes('time=Fz+sweep+4000+7000+2')")
    until(page, "Math.max(...timePanel.charts.find(({ name }) => name === 'late_load').chart.curves.at(-1).y) > 6000")
    page.locator("#effect-relax_lat").uncheck()
    page.locator("#effect-relax_lon").uncheck()
    page.locator("#effect-load_lag").uncheck()
    until(page, "timePanel.charts.find(({ name }) => name === 'late_load').chart.curves.at(-1).label !== 'this tire'")
    page.evaluate("location.hash = '#time=alpha+step+0+x+1'")
    until(page, "timePanel.course.input === 'alpha' && timePanel.course.to > 0 && !timePanel.course.duration")


def test_the_temperature_of_the_tire_is_an_input_and_its_course_one_chart(opened):
    """Curves are those of a tire that starts at the temperature of the slider, in deg C; the response starts there."""
    page = opened(warm_tire())
    alpha = np.linspace(*page.evaluate("[range('alpha').low, range('alpha').high]"), 201)
    for kelvin in (300.0, 370.0):
        page.locator("#field-input-T_surface").fill(f"{kelvin - 273.15:.2f}")
        page.locator("#field-input-T_surface").press("Enter")
        until(page, f"Math.abs(view.inputs.T_surface - {kelvin}) < 1e-9 && charts[0].chart.curves[0].y.length === 201")
        page.evaluate("charts[0].update()")
        expected = (
            warm_tire()
            .with_values(THSTARTS=kelvin)
            .evaluate(pd.DataFrame({"alpha": alpha, "Fz": warm_tire().nominal("Fz")}))
        )
        drawn = page.evaluate("charts[0].chart.curves.at(-1).y")
        np.testing.assert_allclose(drawn, expected["Fy"], rtol=1e-9, atol=1e-6)
    until(page, "timePanel.charts.every(({ chart }) => chart.figure.hidden || chart.curves)")
    (nodes,) = page.evaluate(
        """timePanel.charts.filter(({ name }) => name === 'temperature')
          .map(({ chart }) => chart.curves.map(({ label, style, y }) => [label.split(',')[0], style, y[0]]))"""
    )
    assert {name for name, style, _ in nodes if style == "now"} == {"T_surface", "T_bulk", "T_carcass", "T_gas"}
    starts = {start for name, _, start in nodes if name == "T_surface"}
    assert [*starts] == pytest.approx([370.0 - 273.15])
    assert "T_surface" not in page.evaluate(
        "[...document.getElementById('time-input').options].map((option) => option.value)"
    )


def test_a_tire_without_memory_has_no_response(opened, tires):
    page = opened(tires["mf96"])
    assert page.locator("#time").is_hidden()
