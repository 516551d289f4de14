"""docs/report_figures.md: its commands draw every figure and panel that its tables name."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import numpy as np
import pytest

from tirefmu.commands.cli import main
from tirefmu.drawing import page, picture
from tirefmu.drawing.style import CONTRAST, DASHED, SOLID, contrast
from tirefmu.tires.drawing import files

PAGE = (Path(__file__).parents[2] / "docs" / "report_figures.md").read_text(encoding="utf-8")
COMMANDS = re.search(r"^```sh\n(.*?)^```$", PAGE, flags=re.MULTILINE | re.DOTALL)[1].splitlines()
#: Figure, what draws it, and where it is.
ROWS = re.findall(r"^\| ([\d, a-z]+) \| [^|]* \| `tirefmu (\w+)` \| (.*) \|$", PAGE, flags=re.MULTILINE)


@pytest.fixture(scope="module")
def drawn(tmp_path_factory):
    """Run the commands of the page; return the figures by command, and the written files."""
    folder = tmp_path_factory.mktemp("figures")
    figures: dict[str, list] = {}
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        for line in COMMANDS:
            program, command, *arguments = shlex.split(line)
            assert program == "tirefmu"
            record = figures.setdefault(command, []).append
            patch.setattr(page, "chart_data", lambda figure, record=record: record(figure) or "[]")
            patch.setattr(files, "picture", lambda figure: figure)
            patch.setattr(files, "rendered", lambda figure, *options, record=record, **more: record(figure) or b"")
            patch.setattr(picture, "png", lambda *_: b"")
            assert main([command, *arguments, "--quiet"]) == 0
    return figures, {path.stem for path in folder.rglob("*.png")}


def plain(text):
    """Return a heading as the page of the documentation writes it."""
    return text.split("\n")[0].replace("κ", "kappa").replace("α", "alpha")


def panels_of(figures, heading):
    """Return the panels of the figure with a heading, by their titles."""
    (figure,) = [drawing for drawing in figures if plain(drawing.title) == heading]
    return {plain(panel.title): panel for panel in figure.panels}


def panel(figures, heading, start):
    """Return the only panel of a figure whose title starts with a text, as a word of its own."""
    found = panels_of(figures, heading)
    (one,) = [found[title] for title in found if re.match(re.escape(start) + r"(?!\w| and)", title)]
    return one


def levels(panel):
    """Return the curves with a name."""
    return [series for series in panel.series if series.kind == "line" and series.label]


def test_every_figure_of_the_documents_is_listed():
    trento, campinas = (re.findall(r"^\| (\d[^|]*) \|", part, flags=re.MULTILINE) for part in PAGE.split("\n## ")[1:])
    assert {int(re.match(r"\d+", name)[0]) for name in trento} == set(range(1, 23))
    assert {"3a", "3b", "7a", "7b", "13a", "13b", "15a", "15b"} <= set(trento)
    assert campinas == ["1, 2", "3 to 5", *map(str, range(6, 11))]


@pytest.mark.slow
@pytest.mark.parametrize(("figure", "command", "where"), ROWS, ids=[f"{row[1]} {row[0]}" for row in ROWS])
def test_a_figure_is_drawn_where_the_page_states(figure, command, where, drawn):
    figures, files = drawn
    names = re.findall(r"(?<!\*)\*([^*]+)\*", where.replace("\\|", "|"))
    stems = re.findall(r"`(\w+)`", where)
    assert names
    assert set(stems) <= files
    if command == "draw":  # every figure of a tire has the name of the tire in its heading; surfaces are matplotlib's
        shown = [
            *(panel.title for drawing in figures["draw"] if hasattr(drawing, "panels") for panel in drawing.panels),
            *(ax.get_title() for drawing in figures["draw"] if hasattr(drawing, "axes") for ax in drawing.axes),
        ]
        for name in names:
            assert any(re.match(re.escape(name) + r"(?!\w| and)", plain(title)) for title in shown)
        return
    heading, *panels = names
    assert panels_of(figures[command], heading)
    for start in panels:
        assert panel(figures[command], heading, start).series


def test_a_row_of_the_tables_is_read():
    assert len(ROWS) == len(re.findall(r"^\| \d", PAGE, flags=re.MULTILINE)) - 3


@pytest.mark.slow
@pytest.mark.parametrize("force", ["Gxalpha", "Gykappa"])
def test_weighting_functions_are_drawn_over_both_slips(force, drawn):
    figures = drawn[0]["fit"]
    title = "Weighting functions of combined slip"
    over_kappa, over_alpha = (panel(figures, title, f"{force} per {slip}") for slip in ("slip angle", "longitudinal"))
    assert (plain(over_kappa.x), plain(over_alpha.x)) == ("kappa (-)", "alpha (deg)")
    assert all(np.ptp(line.points[0]) > 0.5 for line in levels(over_kappa))  # kappa from -0.3 to 0.3
    assert all(np.ptp(line.points[0]) > 5.9 for line in levels(over_alpha))  # alpha to 6 deg


@pytest.mark.slow
def test_side_force_over_kappa_at_three_degrees_has_a_curve_for_each_camber(drawn):
    found = panel(drawn[0]["fit"], "Forces at combined slip", "Fy per camber")
    assert "alpha = 3 deg" in plain(found.title)
    assert [line.label for line in levels(found)] == ["0 deg", "2 deg", "4 deg"]
    assert "R²" in found.title


@pytest.mark.slow
def test_old_and_new_parameters_are_drawn_over_each_other_with_their_difference(drawn):
    figures = drawn[0]["compare"]
    (both, difference) = panels_of(figures, "Pure slip: Fy over alpha").values()
    old, new = ([line for line in levels(both) if line.dashes == dashes] for dashes in (DASHED, SOLID))
    assert [line.label for line in old] == [line.label for line in new] == [line.label for line in levels(difference)]
    for first, second, third in zip(old, new, levels(difference), strict=True):
        np.testing.assert_allclose(second.points[1] - first.points[1], third.points[1], atol=1e-9)
    (over_load,) = panels_of(figures, "Cornering stiffness over load").values()
    assert over_load.y == "cornering stiffness (N/rad)"
    assert all((line.points[1] > 0.0).all() for line in over_load.series)


@pytest.mark.slow
def test_the_small_tire_has_points_and_the_full_range_of_slip(drawn):
    pure, combined = (drawing for drawing in drawn[0]["draw"] if hasattr(drawing, "title"))
    surfaces = [drawing for drawing in drawn[0]["draw"] if hasattr(drawing, "axes")]
    over_kappa = next(panel for panel in pure.panels if plain(panel.x) == "kappa (-)")
    assert over_kappa.x_limits == (-1.1, 1.1)
    for figure in (pure, combined):
        points = [series for panel in figure.panels for series in panel.series if series.kind == "points"]
        assert sum(series.points.shape[1] for series in points) > 20
    assert len(surfaces) == 3
    for figure in surfaces:
        solids = [ax for ax in figure.axes if ax.name == "3d"]
        assert len(solids) == 2
        assert sum(len(line.get_xdata()) for ax in solids for line in ax.get_lines() if line.get_marker() == "o") > 20
    assert [len(levels(panel)) for panel in combined.panels] == [9, 9, 9]  # -20 to 20 deg in steps of 5


@pytest.mark.slow
def test_levels_have_solid_lines_and_readable_names(drawn):
    for heading in ("Pure side force", "Forces at combined slip"):
        for found in panels_of(drawn[0]["fit"], heading).values():
            lines = levels(found)
            assert len({line.label for line in lines}) == len(lines)
            assert all(line.dashes == SOLID for line in lines)
            assert all(contrast(line.color) >= CONTRAST for line in lines)
