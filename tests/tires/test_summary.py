"""Changed values, figures and the summary of a tire."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from tirefmu.boundary.errors import DataError, TireError, UnknownName
from tirefmu.tires import PUBLISHED, Tire, published

SIZE = {"FNOMIN": 4000.0, "UNLOADED_RADIUS": 0.3}


def test_other_values_make_another_tire():
    tire = published("trento_hoosier")
    other = tire.with_values(PDY1=1.3, PKY1=1000.0)  # far beyond the bounds of a fit
    changed = {name for name, value in other.values.items() if value != tire.values[name]}
    assert changed == {"PDY1", "PKY1"}
    assert (other.values["PDY1"], other.signs, other.has) == (1.3, tire.signs, tire.has)
    assert tire.values["PDY1"] != 1.3
    assert tire.with_values() == tire
    plain = Tire("mf61", SIZE)
    assert set(plain.defaulted) - set(plain.with_values(PDY1=1.3).defaulted) == {"PDY1"}
    assert plain.with_values(FZMIN=500.0, FZMAX=900.0).ranges["Fz"] == (500.0, 900.0)


def test_invalid_values():
    tire = Tire("mf61", SIZE, effects=["load_friction"])
    with pytest.raises(UnknownName, match="unknown coefficient of mf61 'PDYI': did you mean PDY"):
        tire.with_values(PDYI=1.3)
    with pytest.raises(TireError, match="PDY1 is nan"):
        tire.with_values(PDY1=float("nan"))
    with pytest.raises(TireError, match="PDY1 is None"):
        tire.with_values(PDY1=None)
    with pytest.raises(TireError, match="PDY3 has no influence: the tire does not have camber_friction"):
        tire.with_values(PDY3=0.1)


@pytest.mark.parametrize("name", PUBLISHED)
def test_a_tire_is_shown_in_a_few_lines(name):
    tire = published(name)
    lines = repr(tire).splitlines()
    assert len(lines) <= 6
    assert tire.model in lines[0]
    assert "adapted-sae" in lines[0]
    assert "<td>PDY1</td>" in tire._repr_html_()


def test_text_of_a_file_is_escaped():
    tire = Tire("mf61", SIZE, name='"><script>alert(1)</script>\x1b[2J\n' + "x" * 500)
    shown = repr(tire)
    assert len(shown.splitlines()) <= 6
    assert max(map(len, shown.splitlines())) < 300
    page = tire._repr_html_()
    assert "<script" not in page
    assert "\x1b" not in shown + page


def test_a_tire_is_drawn_over_measured_rows_at_their_loads():
    tire = published("trento_hoosier")
    rows = pd.DataFrame({"alpha": np.tile(np.linspace(-0.2, 0.2, 40), 2), "Fz": np.repeat([300.0, 900.0], 40)})
    rows["Fy"] = tire.in_signs("iso").forces(alpha=rows["alpha"], Fz=rows["Fz"])["Fy"]
    (panel,) = [ax for ax in tire.plot(rows).axes if ax.get_title().startswith("Fy")]
    measured = [line for line in panel.get_lines() if line.get_marker() == "o"]
    curves = [line for line in panel.get_lines() if line.get_marker() != "o" and len(line.get_xdata()) > 2]
    assert [len(line.get_xdata()) for line in measured] == [40, 40]
    for curve, points in zip(curves, measured, strict=True):
        on_curve = np.interp(points.get_xdata(), curve.get_xdata(), curve.get_ydata())
        assert np.allclose(on_curve, points.get_ydata(), atol=2.0)
    with pytest.raises(DataError, match="alpha"):
        tire.plot(rows.assign(alpha=10.0 * rows["alpha"] * 57.3))


def test_a_notebook_shows_a_picture_of_each_tire_that_can_be_drawn():
    assert "<img" in published("trento_hoosier")._repr_html_()
    assert "<img" not in Tire("mf61", SIZE | {"PDX1": 0.0, "PDY1": 0.0}, effects=())._repr_html_()


@pytest.mark.parametrize("kind", ["pure", "surfaces", "combined"])
def test_a_tire_draws_itself(kind):
    figure = published("unicamp_small_tire").plot(kind, loads=[60.0, 110.0], signs="adapted-sae")
    assert "adapted SAE" in figure.get_supxlabel()
    assert figure.axes


def test_an_unknown_figure():
    with pytest.raises(UnknownName, match="kind of figure 'puer': did you mean pure"):
        published("unicamp_small_tire").plot("puer")
