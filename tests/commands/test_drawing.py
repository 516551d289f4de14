"""Figures of a tire: the curves are those that the tire computes, for every model and convention."""

from __future__ import annotations

import json
import xml.etree.ElementTree as ET
from math import isfinite, nan

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.image import imread

from tirefmu.boundary.errors import TirefmuError
from tirefmu.drawing.picture import picture, rendered
from tirefmu.measurements import Noise, VirtualBench, small_tire_program, write_table
from tirefmu.symbolic.models import MODELS
from tirefmu.tires import Tire, published
from tirefmu.tires.drawing import files
from tirefmu.tires.drawing import tire_figures as drawing
from tirefmu.tires.drawing.surface_figure import surfaces

from ..hostile import EACH_PAGE

SIZE = {"FNOMIN": 1000.0, "UNLOADED_RADIUS": 0.25}


def generic(model, **values):
    return Tire(model, {**SIZE, **values}, ranges={"kappa": (-0.3, 0.3), "Fz": (300.0, 1900.0)})


def lines(panel):
    """Return the drawn curves by their name: x and y."""
    return {series.label: series.points for series in panel.series if series.label and series.kind == "line"}


def points_of(panel):
    """Return the measured points, x and y."""
    return np.hstack([series.points for series in panel.series if series.kind == "points"])


@pytest.fixture(scope="module")
def small():
    return published("unicamp_small_tire")


@pytest.mark.usefixtures("drawn_figures")
def test_a_published_tire_is_drawn_in_a_new_folder(tmp_path, monkeypatch):
    monkeypatch.setattr(drawing, "default_loads", lambda tire: (60.0,))  # each load takes seconds to draw
    drawn = files.draw("unicamp_small_tire", tmp_path / "new" / "folder")
    names = ["pure.png", "surfaces_60N.png", "combined.png"]
    assert [path.name for path in drawn] == names
    assert sorted(path.name for path in (tmp_path / "new" / "folder").iterdir()) == sorted(names)
    for path in drawn:
        assert len(np.unique(imread(path)[..., 0])) > 100


@pytest.mark.parametrize("model", MODELS)
def test_every_model_has_surfaces_and_combined_curves(model):
    sketch = drawing.sketched(generic(model), [1000.0], "iso")
    assert len(surfaces(sketch, 1000.0).axes) >= len(drawing.PURE)
    assert all(np.isfinite(points).all() for points in lines(drawing.combined(sketch).panels[0]).values())


@pytest.mark.usefixtures("drawn_figures")
@pytest.mark.parametrize("suffix", files.FORMATS)
def test_the_same_tire_gives_the_same_bytes(small, suffix, tmp_path, monkeypatch):
    monkeypatch.setattr(files, "surfaces", lambda sketch, load: picture(drawing.pure(sketch)))  # they take seconds
    first, second = (files.draw(small, tmp_path / name, loads=[60.0], suffix=suffix) for name in "ab")
    assert [path.read_bytes() for path in first] == [path.read_bytes() for path in second]
    assert [path.name for path in first] == [f"{name}.{suffix}" for name in ("pure", "surfaces_60N", "combined")]
    begin = {"png": b"\x89PNG", "svg": b"<?xml", "pdf": b"%PDF"}[suffix]
    assert all(path.read_bytes().startswith(begin) for path in first)


@pytest.mark.parametrize("signs", ["iso", "adapted-sae", "sae"])
@pytest.mark.parametrize("model", MODELS)
def test_the_curves_are_the_tires(model, signs):
    tire = generic(model)
    figure = drawing.pure(drawing.Sketch(tire, signs, (500.0, 1500.0)))
    for panel, (channel, slip) in zip(figure.panels, drawing.PURE, strict=True):
        curves = lines(panel)
        assert list(curves) == ["500 N", "1500 N"]
        for load, (x, y) in zip((500.0, 1500.0), curves.values(), strict=True):
            assert x[0] < 0.0 < x[-1]
            assert 0.0 in x
            values = np.radians(x) if slip == "alpha" else x
            loaded = -load if signs == "sae" else load
            table = pd.DataFrame({slip: values}).assign(Fz=loaded, **{"alpha" if slip == "kappa" else "kappa": 0.0})
            np.testing.assert_allclose(y, tire.evaluate(table, signs=signs)[channel], rtol=1e-9, atol=1e-9)


def test_the_side_force_over_the_longitudinal_force_is_the_tires(small):
    sketch = drawing.Sketch(small, "adapted-sae", (110.0,))
    (panel,) = drawing.combined(sketch).panels
    curves = lines(panel)
    assert list(curves) == [f"{angle} deg" for angle in range(-20, 21, 5)]
    kappa = sketch.grid("kappa", 301)
    for label, (x, y) in curves.items():
        forces = small.forces(kappa=kappa, alpha=np.radians(float(label.split()[0])), Fz=110.0)
        np.testing.assert_allclose(x, forces["Fx"], rtol=1e-9, atol=1e-9)
        np.testing.assert_allclose(y, forces["Fy"], rtol=1e-9, atol=1e-9)


def test_a_zero_output_is_reported_instead_of_drawn(small):
    figure = drawing.pure(drawing.Sketch(small, "iso", (60.0,)))
    assert [panel.y for panel in figure.panels] == ["Fx (N)", "Fy (N)"]
    assert "Mz 0 everywhere" in figure.note


def test_a_load_beyond_the_range_is_reported(small):
    for loads, noted in (((60.0, 160.0), False), ((60.0, 300.0), True)):
        text = drawing.pure(drawing.Sketch(small, "iso", loads)).note
        assert ("300 N: outside 60 to 160 N" in text) is noted


@given(st.floats(0.0, 1e4), st.floats(0.0, 1e4), st.floats(10.0, 1e4))
def test_the_default_loads_lie_in_the_range(first, second, nominal):
    low, high = sorted((first, second))
    loads = drawing.default_loads(Tire("mf96", {**SIZE, "FNOMIN": nominal}, ranges={"Fz": (low, high)}))
    assert list(loads) == sorted(set(loads))
    assert 1 <= len(loads) <= 3
    assert all(isfinite(load) and load > 0.0 for load in loads)
    if 0.25 * nominal <= high <= 3.0 * nominal:
        assert all(low <= load <= high for load in loads)


@pytest.mark.parametrize("loads", [[], [0.0], [-60.0], [nan], [float("inf")], [60.0, -1.0]])
def test_invalid_loads_are_rejected(small, loads, tmp_path):
    with pytest.raises(TirefmuError, match="load"):
        files.draw(small, tmp_path / "figures", loads=loads)
    assert not (tmp_path / "figures").exists()


def test_a_tire_without_force_is_refused(tmp_path):
    dead = dict.fromkeys(("PDX1", "PDX2", "PDY1", "PDY2", "PKX1", "PKX2", "PKY1", "QDZ1"), 0.0)
    tire = Tire("mf61", {**SIZE, **dead}, effects=())
    with pytest.raises(TirefmuError, match="makes no force at 500 N"):
        files.draw(tire, tmp_path / "figures", loads=[500.0])
    assert not (tmp_path / "figures").exists()


def test_a_force_that_is_not_finite_is_rejected_with_its_condition(small, tmp_path, monkeypatch):
    evaluate = drawing.evaluate

    def broken(tire, table, conventions):
        return evaluate(tire, table, conventions).assign(Fy=nan)

    monkeypatch.setattr(drawing, "evaluate", broken)
    with pytest.raises(TirefmuError, match=r"Fy is not finite at kappa = -0.5, alpha = -0.349066, Fz = 60"):
        files.draw(small, tmp_path / "figures")
    assert not (tmp_path / "figures").exists()


def test_a_folder_that_cannot_be_made_is_one_line(small, tmp_path):
    (tmp_path / "taken").write_text("", encoding="utf-8")
    with pytest.raises(TirefmuError, match="figures: cannot be written"):
        files.draw(small, tmp_path / "taken" / "figures", loads=[60.0])


# ------------------------------------------------------------------ the command


def test_the_command_draws_a_file_and_reports_it_as_json(command, published_tir, tmp_path):
    outcome = command(
        "draw", published_tir, "-o", tmp_path / "figures", "--loads", "500", "--format", "svg", "--quiet", "--json", "-"
    )
    assert outcome.status == 0, outcome.err
    reported = json.loads(outcome.out)
    assert reported["ok"] is True
    assert reported["loads"] == [500.0]
    assert sorted(reported["figures"]) == sorted(str(path) for path in (tmp_path / "figures").iterdir())


@pytest.mark.usefixtures("drawn_figures")
@pytest.mark.parametrize("text", EACH_PAGE)
def test_a_tires_name_is_drawn_literally(text, tmp_path):
    """The SVG is well-formed and contains no script and no external resource."""
    tire = Tire("mf96", {**SIZE, "PDY1": 1.0, "PKY1": 10.0, "PCY1": 1.3}, effects=(), name=text)
    pure = picture(drawing.pure(drawing.Sketch(tire, "iso", (1000.0,))))
    root = ET.fromstring(rendered(pure, "svg", 40))
    tags = {element.tag.rpartition("}")[2] for element in root.iter()}
    assert not tags & {"script", "image", "foreignObject", "a"}
    assert not any(name.startswith("on") for element in root.iter() for name in element.attrib)


@pytest.mark.parametrize("signs", ["iso", "adapted-sae", "sae"])
def test_measured_rows_are_crosses_on_the_curves(small, signs):
    """Exact measurements in ISO are on the curves in any convention; cambered rows and other loads are not drawn."""
    alpha = np.radians([-10.0, 0.0, 10.0, 5.0, 5.0])
    points = pd.DataFrame(
        {"kappa": 0.0, "alpha": alpha, "gamma": [0.0, 0.0, 0.0, 0.05, 0.0], "Fz": [110.0] * 4 + [60.0]}
    )
    points["Fy"] = small.evaluate(points)["Fy"]
    points["Fx"] = small.evaluate(points)["Fx"]
    sketch = drawing.sketched(small, [110.0], signs, points)
    (panel,) = (panel for panel in drawing.pure(sketch).panels if panel.x == "α (deg)")
    alpha, force = points_of(panel)
    assert sorted(alpha.round(6)) == [-10.0, 0.0, 10.0]
    assert force == pytest.approx(np.interp(alpha, *lines(panel)["110 N"]), rel=1e-3, abs=0.01)
    assert points_of(drawing.combined(sketch).panels[0]).shape == (2, 3)


def test_crosses_are_at_the_pressure_of_the_curves(small):
    """Rows at another pressure belong to other curves; without one near, the footnote states that no row is drawn."""
    nominal = small.nominal("p")
    points = pd.DataFrame({"kappa": [0.1, 0.2, 0.3], "alpha": 0.0, "Fz": 110.0, "Fx": 1.0, "Fy": 1.0})
    points["p"] = [nominal, nominal + 1e3, nominal - 2e4]
    assert drawing.sketched(small, [110.0], "iso", points).measured(110.0, "Fx")["kappa"].tolist() == [0.1, 0.2]
    other = drawing.sketched(small, [110.0], "iso", points[2:])
    assert any(note.startswith("no row was measured upright within 10%") for note in other.footnotes())
    rigid = generic("mf96")  # its curves do not depend on the pressure
    assert len(drawing.sketched(rigid, [110.0], "iso", points).measured(110.0, "Fx")) == 3


@pytest.mark.parametrize("given", [(1.0, -1.0), (0.0, 0.0), (-1.0,), (-1.0, 1.0, 2.0), (-11.0, 1.0), (nan, 1.0)])
def test_a_range_of_kappa_is_two_ascending_numbers(small, given):
    with pytest.raises(TirefmuError, match=r"range of kappa .*: two numbers from -10 to 10, ascending"):
        drawing.sketched(small, [110.0], "iso", kappa=given)


def test_what_is_beyond_the_range_of_the_tire_is_stated(small):
    low, high = small.ranges["kappa"]
    inside = drawing.sketched(small, [110.0], "iso", kappa=(low, high))
    beyond = drawing.sketched(small, [110.0], "iso", kappa=(low - 0.1, high))
    assert [any("extrapolated" in note for note in sketch.footnotes()) for sketch in (inside, beyond)] == [False, True]
    assert beyond.span("kappa") == (low - 0.1, high)


def test_the_command_draws_at_the_loads_of_a_table(small, command, tmp_path, monkeypatch):
    drawn = {}
    monkeypatch.setattr(files, "draw", lambda tire, folder, **options: drawn.update(options) or [])
    bench = VirtualBench(small.in_signs("iso"), Noise().scaled(0.05))
    write_table(bench.run(small_tire_program()).table, tmp_path / "points.csv")
    assert command("draw", "unicamp_small_tire", tmp_path / "points.csv", "-o", tmp_path / "new").status == 0
    assert drawn["loads"] == (60.0, 110.0, 160.0)
    assert len(drawn["points"]) == 297


@pytest.mark.slow
def test_signs_are_those_of_the_table_and_of_the_figures(small, command, tmp_path, monkeypatch):
    """Rows in any convention are the same crosses; figures have the table's convention unless another is named."""
    drawn = {}
    monkeypatch.setattr(files, "draw", lambda tire, folder, **options: drawn.update(options) or [])
    recording = VirtualBench(small.in_signs("iso"), Noise().scaled(0.05)).run(small_tire_program())
    for signs in ("iso", "adapted-sae", "sae"):
        write_table(recording.with_signs(signs).table, tmp_path / "points.csv")
        given = ("draw", "unicamp_small_tire", tmp_path / "points.csv", "-o", tmp_path / "new", "--signs", signs)
        assert command(*given).status == 0
        assert drawn["signs"] == signs
        for name in ("alpha", "Fz", "Fy"):
            np.testing.assert_allclose(drawn["points"][name], recording.with_signs("iso").table[name])
        assert command(*given, "--draw-signs", "iso", "--where", "abs(alpha) < 6 deg").status == 0
        assert drawn["signs"] == "iso"
        assert 0 < len(drawn["points"]) < len(recording)
    assert command("draw", "unicamp_small_tire", "-o", tmp_path / "new").status == 0
    assert drawn["signs"] == "iso"
