"""The page in Chromium: its numbers are NumPy's, its controls act, what it saves is the tire that it shows."""

from __future__ import annotations

import json
import os
import time
from dataclasses import replace

import numpy as np
import pytest

from tirefmu import explore
from tirefmu.symbolic.models import MODELS
from tirefmu.tires import Tire, read_tir
from tirefmu.tires.evaluation import quantities

#: Random settings of the sliders for each model: all of them with make pages.
SETTINGS = 1000 if "TIREFMU_PAGES" in os.environ else 25
#: Coefficients and effects that a setting changes.
MOVED, SWITCHED = 5, 3

#: Moves sliders and switches as a hand would, and returns the values that the page then has, and its forces.
APPLY = """(settings) => settings.map(([coefficients, effects, inputs]) => {
  const move = (row, share) => {
    row.slider.value = row.spec.lower + share * (row.spec.upper - row.spec.lower);
    row.slider.dispatchEvent(new Event("input"));
  };
  now.reset();
  panel.show();
  for (const name of effects) panel.boxes.get(name).click();
  for (const [name, share] of coefficients) move(panel.rows.get(name), share);
  for (const [name, share] of inputs) move(inputRows.get(name), share);
  const forces = now.forces(inputsOf(now, view.inputs));
  const plain = Object.fromEntries(Object.entries(forces).map(([name, x]) => [name, Number.isFinite(x) ? x : null]));
  return [Object.fromEntries(now.values), [...now.on], { ...view.inputs }, plain, SAVE ? propertyFile(now) : ""];
})"""


def until(page, expression):
    """Wait until an expression is true. The page's security policy forbids the library's own way to wait."""
    end = time.monotonic() + 30.0
    while not page.evaluate(expression):
        assert time.monotonic() < end, expression
        page.wait_for_timeout(50)


def settings_of(page, count, seed=0):
    """Return random settings: shares of the range of some sliders, and effects to switch."""
    rng = np.random.default_rng(seed)
    names, effects, inputs = page.evaluate("[[...panel.rows.keys()], [...panel.boxes.keys()], [...inputRows.keys()]]")
    effects = [name for name in effects if name]
    return [
        [
            [[str(name), rng.random()] for name in rng.choice(names, min(MOVED, len(names)), replace=False)],
            [str(name) for name in rng.choice(effects, min(SWITCHED, len(effects)), replace=False)],
            [[name, rng.random()] for name in inputs],
        ]
        for _ in range(count)
    ]


def assert_equal_forces(found, tire, inputs):
    """Compare forces with NumPy's to 1e-9 of the force or of the load, whichever is larger."""
    for name, value in tire.forces(code="numpy", **inputs).items():
        expected = float(value)
        if np.isfinite(expected):
            assert found[name] is not None, name
            assert abs(found[name] - expected) <= 1e-9 * max(abs(expected), inputs["Fz"]), (name, found[name], expected)
        else:
            assert found[name] is None, name


@pytest.mark.parametrize("model", MODELS)
def test_numbers_and_saved_files_are_those_of_the_tire(opened, tires, tmp_path, model):
    """Random sliders and switches: forces equal NumPy's, and those of the saved file."""
    tire = tires[model]
    page = opened(tire)
    results = page.evaluate(APPLY.replace("SAVE", "false"), settings_of(page, SETTINGS))
    results += page.evaluate(APPLY.replace("SAVE", "true"), settings_of(page, 5, seed=1))
    assert len({json.dumps(result[3]) for result in results}) > 0.8 * len(results)
    for values, effects, inputs, forces, text in results:
        changed = Tire(model, values, effects, signs="iso")
        assert_equal_forces(forces, changed, inputs)
        if text:
            (tmp_path / "x.tir").write_text(text, encoding="utf-8")
            saved = read_tir(tmp_path / "x.tir")
            assert saved.has == changed.has
            assert dict(saved.values) == dict(changed.values)
            assert saved.ranges == tire.ranges


def test_added_effects_and_their_states(opened, tires, tmp_path):
    """Effects of the library are switched, saved and evaluated in equilibrium."""
    values = {**tires["mf96"].values, "TREF": 60.0, "TMU1": -0.002, "TMU2": 0.0}
    effects = {*tires["mf96"].has, "temp_friction", "heat_friction", "hysteresis_force"}
    tire = Tire("mf96", values, effects)
    page = opened(tire)
    assert set(page.evaluate("now.states.map((state) => state.name)")) == set(tire.states)
    for off in ([], ["heat_friction"], ["temp_friction", "hysteresis_force"]):
        setting = [[["PDY1", 0.6]], off, [["alpha", 0.8], ["Fz", 0.5]]]
        ((values, found, inputs, forces, text),) = page.evaluate(APPLY.replace("SAVE", "true"), [setting])
        assert set(found) == effects - set(off)
        changed = replace(tire, values=values, effects=found)
        assert_equal_forces(forces, changed, inputs)
        (tmp_path / "x.tir").write_text(text, encoding="utf-8")
        assert_equal_forces(forces, read_tir(tmp_path / "x.tir"), inputs)


def test_surfaces_are_drawn_from_the_tire(opened, tires):
    """The values are NumPy's, alpha along the rows; arrow keys turn the surface."""
    tire = tires["mf96"]
    page = opened(tire)
    page.evaluate("inputRows.get('Fz').show(500); view.inputs.Fz = 500; charts.forEach((chart) => chart.settle?.({}))")
    drawn = page.evaluate("charts.filter((chart) => chart.settle).map(({ chart }) => chart.data)")
    for name, surface in zip(("Fx", "Fy"), drawn, strict=True):
        alpha, kappa = np.meshgrid(np.radians(surface["xs"]), surface["ys"])
        expected = tire.forces(alpha=alpha.ravel(), kappa=kappa.ravel(), Fz=500.0, code="numpy")[name]
        assert np.ravel(surface["rows"]) == pytest.approx(expected, rel=1e-9, abs=1e-6)
    canvas = page.locator("canvas.surface").first
    before = canvas.evaluate("(element) => element.toDataURL()")
    canvas.press("ArrowLeft")
    assert canvas.evaluate("(element) => element.toDataURL()") != before


def test_charts_out_of_sight_are_drawn_before_they_are_scrolled_to(opened, tires):
    page = opened(tires["mf96"])
    assert page.evaluate("charts.some((chart) => chart.visible === false)")
    until(page, "charts.every(({ chart }) => chart.data || chart.plot)")
    assert page.evaluate("scrollY") == 0
    ink = "charts.filter((chart) => chart.settle).map(({ chart }) => chart.canvas.toDataURL().length)"
    assert min(page.evaluate(ink)) > 5000  # an empty canvas has some 1000 characters


def test_printed_charts_fit_two_in_a_row(opened, tires):
    """All charts have the printed width while the page is printed, also on a phone, and their own after it."""
    for width in (1400, 390):
        page = opened(tires["mf96"], width=width)
        widths = "charts.map(({ chart }) => (chart.canvas ?? chart.plot.root).getBoundingClientRect().width)"
        until(page, "charts.every(({ chart }) => chart.data || chart.plot)")
        page.emulate_media(media="print")
        page.set_viewport_size({"width": 718, "height": 900})  # A4 with margins
        page.evaluate("dispatchEvent(new Event('beforeprint'))")
        assert set(page.evaluate(widths)) == {325}
        assert page.evaluate("document.documentElement.scrollWidth") <= 718
        tops = page.evaluate("charts.map(({ chart }) => chart.figure.getBoundingClientRect().top)")
        assert tops[0] == tops[1] < tops[2] == tops[3]
        page.emulate_media(media="screen")
        page.set_viewport_size({"width": width, "height": 900})
        page.evaluate("dispatchEvent(new Event('afterprint'))")
        until(page, f"({widths}).every((width) => width !== 325)")


def test_without_scripts_the_page_lists_the_coefficients(browser, tires, tmp_path):
    explore(tires["mf96"], tmp_path / "page.html", compare=tires["fiala"])
    context = browser.new_context(java_script_enabled=False)
    page = context.new_page()
    page.goto((tmp_path / "page.html").as_uri())
    text = page.locator("noscript main").inner_text()
    for tire in (tires["mf96"], tires["fiala"]):
        for name, value in tire.values.items():
            assert f"{name}\t{value:.6g}" in text
    assert not page.locator("#save").is_visible()
    context.close()


def test_curves_are_drawn_from_the_tire(opened, tires):
    """The lines of the charts are the forces and quantities over their axes, for every source."""
    page = opened(tires["mf61"], compare=tires["mf52"])
    page.evaluate("for (const chart of charts) chart.update()")
    curves = "charts.filter(({ chart }) => chart instanceof Chart)"
    drawn = page.evaluate(f"{curves}.map(({{ chart }}) => [chart.title, chart.curves, chart.locus])")
    tire, nominal = tires["mf61"], {name: tires["mf61"].nominal(name) for name in tires["mf61"].inputs}
    checked = set()
    for title, curves, locus in drawn:
        assert [curve["style"] for curve in curves][-1] == "now"
        assert "other" in [curve["style"] for curve in curves]
        name, _, over = title.split(":")[0].partition(" over ")
        if locus:
            continue
        x = np.array(curves[-1]["x"]) * (np.pi / 180 if over == "alpha" else 1.0)
        found = tire.forces(**{**nominal, over: x}) if over == "alpha" else {}
        expected = found[name] if name in found else quantities(tire, {**nominal, over: x})[name]
        np.testing.assert_allclose(curves[-1]["y"], expected, rtol=1e-9, atol=1e-9 * np.abs(expected).max())
        checked.add((name, over))
    assert checked >= {("Fy", "alpha"), ("Mx", "alpha"), ("G_xa", "alpha"), ("K_yalpha", "Fz"), ("mu_x", "Fz")}
    assert any(locus for _, _, locus in drawn)


def test_dragging_a_slider_moves_the_curve_and_reset_restores_it(opened, tires):
    page = opened(tires["mf96"])
    curve = "charts[0].chart.curves.at(-1).y"
    before = page.evaluate(curve)
    slider = page.locator("#slider-PDY1")
    slider.scroll_into_view_if_needed()
    box = slider.bounding_box()
    page.mouse.move(box["x"] + 0.3 * box["width"], box["y"] + box["height"] / 2)
    page.mouse.down()
    page.mouse.move(box["x"] + 0.1 * box["width"], box["y"] + box["height"] / 2, steps=4)
    page.mouse.up()
    until(page, f"Math.max(...{curve}) < {0.8 * max(before)}")
    until(page, "document.getElementById('status').textContent === 'Changed: PDY1.'")
    page.get_by_label("Reset PDY1").click()
    until(page, f"Math.max(...{curve}) === {max(before)!r}")
    until(page, "document.getElementById('status').textContent === 'Nothing is changed.'")


def test_moving_curves_have_fewer_points_and_those_at_rest_are_all_of_the_tires(opened, tires):
    """Curves that did not change are not computed again; those of every tire follow an input. Axes do not shrink."""
    tire = tires["mf96"]
    page = opened(tire, fragment="#loads=5")
    curves = "charts[0].chart.curves.map((curve) => curve.y)"
    # Charts out of sight are drawn one after another; the last of them ends what the page does on its own.
    until(page, "charts.every(({ chart }) => !(chart instanceof Chart) || chart.curves[0]?.y.length === 201)")
    counted = """(change) => {
      const original = sweep;
      let count = 0;
      sweep = (...given) => (count += 1, original(...given));
      change === "PDY1" ? now.set("PDY1", 0.5 * now.values.get("PDY1")) : (view.inputs.Fz = change);
      const visible = charts.filter(({ chart }) => chart instanceof Chart);
      for (const chart of visible) chart.update(true);
      sweep = original;
      return [count, visible.map(({ chart }) => chart.curves[0].y.length)];
    }"""
    page.evaluate(counted, 600.0)
    scale = "[charts[0].chart.plot.scales.y.min, charts[0].chart.plot.scales.y.max]"
    axis = page.evaluate(f"new Promise((done) => setTimeout(() => done({scale})))")
    moved, lengths = page.evaluate(counted, "PDY1")
    everything, _ = page.evaluate(counted, 500.0)
    assert set(lengths) == {101}
    assert 0 < moved < everything
    assert page.evaluate(scale) == axis
    alpha = np.linspace(*page.evaluate("[range('alpha').low, range('alpha').high]"), 101)
    drawn = page.evaluate(curves)
    assert drawn[0] == pytest.approx(tire.forces(alpha=alpha, Fz=500.0, code="numpy")["Fy"], rel=1e-9, abs=1e-6)
    halved = tire.with_values(PDY1=0.5 * tire.values["PDY1"])
    assert drawn[-1] == pytest.approx(halved.forces(alpha=alpha, Fz=500.0, code="numpy")["Fy"], rel=1e-9, abs=1e-6)
    page.evaluate("render()")
    until(page, "charts[0].chart.curves[0].y.length === 201")
    until(page, f"charts[0].chart.plot.scales.y.max < {axis[1]!r}")


def test_an_input_is_changed_where_it_differs_from_the_selected_condition(opened, tires, bench):
    """The words beside a slider, those of the status line and the address agree; reset returns to the condition."""
    page = opened(tires["mf96"], tables=[bench])
    marked = "[...document.querySelectorAll('#inputs .row.changed label')].map((label) => label.textContent)"
    status = "document.getElementById('status').textContent"
    for condition in range(page.evaluate("measured.conditions.length")):
        page.evaluate(f"chooseCondition({condition})")
        until(page, f"{status} === 'Nothing is changed.'")
        assert page.evaluate(marked) == []
        assert page.evaluate("location.hash").removeprefix("#") in ("", f"condition={condition}")
    level = page.evaluate("view.inputs.Fz")
    page.locator("#field-input-Fz").fill("650")
    page.locator("#field-input-Fz").press("Enter")
    until(page, f"{status} === 'Inputs changed: Fz.'")
    assert page.evaluate(marked) == ["Fz"]
    assert "input.Fz=650" in page.evaluate("location.hash")
    page.get_by_label("Reset Fz").click()
    until(page, f"{status} === 'Nothing is changed.'")
    assert page.evaluate("view.inputs.Fz") == pytest.approx(level)
    assert page.evaluate(marked) == []


def test_keys_and_fields_change_values(opened, tires):
    page = opened(tires["mf96"])
    page.locator("#slider-PDY1").focus()
    page.keyboard.press("ArrowRight")
    assert page.evaluate("now.values.get('PDY1')") > tires["mf96"].values["PDY1"]
    page.locator("#field-PDY1").fill("2.25")
    page.locator("#field-PDY1").press("Enter")
    assert page.evaluate("now.values.get('PDY1')") == 2.25
    page.locator("#field-PDY1").fill("")
    page.locator("#field-PDY1").press("Enter")
    assert page.evaluate("now.values.get('PDY1')") == 2.25
    page.locator("#search").fill("peak")
    assert page.locator(".row:visible label", has_text="PCX1").count() == 0


def test_the_save_button_and_the_address_keep_the_state(opened, tires, tmp_path):
    fragment = "#PDY1=2.5&effect.camber_thrust=off&input.Fz=700&over=kappa&loads=5&PDX1=x&nonsense=1&input.q=1"
    page = opened(tires["mf96"], fragment=fragment)
    assert page.evaluate("[now.values.get('PDY1'), now.on.has('camber_thrust'), view]") == [
        2.5, False, {"inputs": {"kappa": 0, "alpha": 0, "gamma": 0, "Fz": 700}, "over": "kappa", "family": True,
                     "condition": 0},
    ]  # fmt: skip
    assert page.locator("#effect-camber_thrust").is_checked() is False
    assert page.locator("#field-PVY3").is_disabled()
    until(page, "!location.hash.includes('nonsense')")
    assert page.evaluate("location.hash") == "#PDY1=2.5&effect.camber_thrust=off&input.Fz=700&over=kappa&loads=5"
    with page.expect_download() as download:
        page.get_by_role("button", name="Save .tir").click()
    download.value.save_as(tmp_path / "saved.tir")
    saved = read_tir(tmp_path / "saved.tir")
    expected = replace(tires["mf96"], values={**tires["mf96"].values, "PDY1": 2.5},
                       effects=tires["mf96"].has - {"camber_thrust"})  # fmt: skip
    assert saved == replace(expected, about=saved.about)
    assert saved.about == {**expected.about, "changed": "PDY1, camber_thrust"}


def test_measured_rows_and_their_residuals(opened, tires, bench):
    """R2 and RMSE of the selected condition and of all rows are those of Python; points belong to the condition."""
    page = opened(tires["mf96"], tables=[bench])
    until(page, "document.querySelectorAll('#quality tbody tr').length > 0")
    rows = page.evaluate(
        "[...document.querySelectorAll('#quality tbody tr')].map((r) => [...r.cells].map((c) => c.textContent))"
    )
    titles = page.evaluate("measured.conditions.map((condition) => condition.title)")
    assert sum("alpha swept, Fz " in title for title in titles) == 2, titles
    columns = page.evaluate(
        "measured.conditions.map((c) => Object.fromEntries(Object.entries(c.columns).map(([k, v]) => [k, [...v]])))"
    )
    held = [{k: np.array(v) for k, v in condition.items()} for condition in columns]
    assert 0.9 * len(bench) < sum(len(condition["Fy"]) for condition in held) <= len(bench)
    for title, conditions in (("condition", held[:1]), ("all rows", held)):
        measured = np.concatenate([condition["Fy"] for condition in conditions])
        given = [{k: v for k, v in condition.items() if k in tires["mf96"].inputs} for condition in conditions]
        error = np.concatenate([tires["mf96"].forces(**inputs)["Fy"] for inputs in given]) - measured
        (row,) = [row for row in rows if row[0] == f"Fy, {title}"]
        assert int(row[1]) == len(measured)
        assert float(row[2]) == pytest.approx(np.sqrt(np.mean(error**2)), rel=1e-4)
        assert float(row[3]) == pytest.approx(1.0 - np.mean(error**2) / np.var(measured), rel=1e-4)
    sweep = page.evaluate("measured.conditions.find((condition) => condition.slip === 'kappa').texts.sweep")
    page.locator("#condition-sweep").select_option(label=sweep)
    assert page.evaluate("view.over") == "kappa"
    assert page.evaluate("view.inputs.Fz") == pytest.approx(700.0, rel=0.01)


def test_all_measured_loads_are_in_one_chart_with_their_points(opened, tires, bench):
    """Each load has one color for its curve and its points; with one load there are the points of the condition."""
    page = opened(tires["mf96"], tables=[bench])
    drawn = page.evaluate(
        """charts.slice(0, 2).map(({ chart }) => [
          chart.title.slice(0, 2),
          chart.curves.map(({ label, color, y }) => [label, color ?? STYLES.now.stroke, y]),
          chart.points.map(({ y, color }) => [color, [...y.values]])])"""
    )
    assert [name for name, _, _ in drawn] == ["Fy", "Mz"]
    iso = bench.with_signs("iso").table
    for name, curves, points in drawn:
        assert len(points) == 2
        colors = {color for color, _ in points}
        assert len(colors) == 2
        assert {color for label, color, _ in curves if label != "as loaded"} == colors
        sizes = {color: np.abs(values).max() for color, values in points}
        for _, color, values in curves:
            assert np.abs(values).max() == pytest.approx(sizes[color], rel=0.2)
        assert all(np.isin(np.float32(values), np.float32(iso[name])).all() for _, values in points)
    page.locator("#family").uncheck()
    until(page, "charts[0].chart.points.length === 1 && charts[0].chart.curves.length === 2")


def test_the_extrapolation_of_a_second_tire_is_dotted_and_does_not_stretch_the_axes(opened, tires):
    """Beyond its load; within it the curve ends where its range of slip ends."""
    ends = {"FZMIN": 60.0, "FZMAX": 160.0, "ALPMIN": -0.05, "ALPMAX": 0.05}
    other = tires["mf61"].with_values(FNOMIN=100.0, PDY1=20.0, LKY=20.0, **ends)
    page = opened(tires["mf96"], compare=replace(other, name="narrow"))
    drawn = "charts[0].chart.curves.find(({ label }) => label === 'narrow')"
    assert page.evaluate(f"{drawn}.style") == "otherBeyond"
    largest = page.evaluate("Math.max(...charts[0].chart.curves.at(-1).y)")
    assert page.evaluate(f"Math.max(...{drawn}.y)") > 1.2 * largest
    assert page.evaluate("charts[0].chart.plot.scales.y.max") < 1.2 * largest
    until(page, "document.getElementById('status').textContent.includes('beyond the range of narrow')")
    page.evaluate("inputRows.get('Fz').show(100); view.inputs.Fz = 100; render()")
    until(page, f"{drawn}.style === 'other'")
    x, y = page.evaluate(f"[{drawn}.x, {drawn}.y]")
    assert [abs(slip) <= np.degrees(0.051) for slip in x] == [force is not None for force in y]


def test_no_chart_is_empty(opened, tires):
    """Fx over the slip angle is 0 without longitudinal slip, and no chart; with it there is one."""
    page = opened(tires["fiala"])
    titles = "charts.map(({ chart }) => chart.title.split(':')[0])"
    assert not {"Fx over alpha", "Mx over alpha"} & set(page.evaluate(titles))
    page.locator("#field-input-kappa").fill("0.02")
    page.locator("#field-input-kappa").press("Enter")
    until(page, f"{titles}.includes('Fx over alpha')")
    until(page, "charts.every(({ chart }) => !chart.curves || chart.curves.some(({ y }) => y.some((value) => value)))")


def test_key_figures_are_those_of_the_curves(opened, tires):
    tire = tires["mf61"]
    page = opened(tire)
    figures = {figure["title"]: figure for figure in page.evaluate(
        "keyFigures(now, view.inputs, { alpha: range('alpha'), kappa: range('kappa') })")}  # fmt: skip
    alpha = np.linspace(*tire.ranges["alpha"], 20001)
    side = tire.forces(alpha=alpha)["Fy"]
    assert figures["Peak Fy, positive"]["value"] == pytest.approx(side.max(), rel=1e-3)
    assert figures["alpha of peak Fy, positive"]["value"] == pytest.approx(np.degrees(alpha[side.argmax()]), abs=0.3)
    step = tire.forces(alpha=[-1e-5, 1e-5])
    stiffness = -np.diff(step["Fy"])[0] / 2e-5
    assert figures["Cornering stiffness -dFy/dalpha"]["value"] == pytest.approx(stiffness, rel=1e-9)
    trail = -1000.0 * (np.diff(step["Mz"]) / np.diff(step["Fy"]))[0]
    assert figures["Pneumatic trail -dMz/dFy at zero slip"]["value"] == pytest.approx(trail, rel=1e-6)


@pytest.mark.parametrize(("width", "height"), [(1400, 900), (390, 844)])
def test_accessible_and_without_sideways_scrolling(opened, tires, bench, width, height):
    axe = pytest.importorskip("axe_playwright_python.sync_playwright", reason="axe is not installed: make pages")
    page = opened(tires["mf96"], tables=[bench], compare=tires["mf61"], width=width, height=height,
                  intervals={"PDY1": (2.6, 2.8)})  # fmt: skip
    until(page, "document.querySelectorAll('#numbers tbody tr').length > 0")
    page.locator("#slider-PDY1").scroll_into_view_if_needed()
    page.evaluate("document.querySelectorAll('details').forEach((section) => { section.open = true; })")
    violations = axe.Axe().run(page).response["violations"]
    assert not violations, [(violation["id"], violation["nodes"][0]["html"][:200]) for violation in violations]
    assert page.evaluate("document.documentElement.scrollWidth") <= width
    assert "95 % interval 2.6 to 2.8" in page.locator(".row", has=page.locator("#slider-PDY1")).inner_text()
