"""docs/report_figures.md: its commands draw every figure and panel that its tables name."""

from __future__ import annotations

import re
import shlex
from base64 import b64decode
from pathlib import Path

import numpy as np
import pytest

from tirefmu.cli import main
from tirefmu.tires.drawing.style import CONTRAST, contrast

PAGE = (Path(__file__).parents[2] / "docs" / "report_figures.md").read_text(encoding="utf-8")
COMMANDS = re.search(r"^```sh\n(.*?)^```$", PAGE, flags=re.MULTILINE | re.DOTALL)[1].splitlines()
#: Figure, what draws it, and where it is.
ROWS = re.findall(r"^\| ([\d, a-z]+) \| [^|]* \| `tirefmu (\w+)` \| (.*) \|$", PAGE, flags=re.MULTILINE)
#: An empty picture: the drawn figures are read before they are rendered.
PICTURE = b64decode("iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAQAAAC1HAwCAAAAC0lEQVR42mNk+A8AAQUBAScY42YAAAAASUVORK5CYII=")


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

            def kept(figure, *options, record=record, **more):
                record(figure)
                return PICTURE

            for module in ("tires.drawing.shown_figure.png", "tires.drawing.files.rendered"):
                patch.setattr(f"tirefmu.{module}", kept)
            assert main([command, *arguments, "--quiet"]) == 0
    return figures, {path.stem for path in folder.rglob("*.png")}


def plain(text):
    r"""Return a heading without the notation of mathematics: ``$F_x$ over $\kappa$`` is Fx over kappa."""
    return re.sub(r"\$[^$]*\$", lambda found: re.sub(r"[$_{}\\]", "", found[0]), text.split("\n")[0])


def axes_of(figures, heading):
    """Return the axes of the figure with a heading, by their titles."""
    (figure,) = [each for each in figures if plain(each.get_suptitle()) == heading]
    return {plain(ax.get_title()): ax for ax in figure.axes}


def panel(figures, heading, start):
    """Return the only panel of a figure whose title starts with a text, as a word of its own."""
    (found,) = [
        ax for title, ax in axes_of(figures, heading).items() if re.match(re.escape(start) + r"(?!\w| and)", title)
    ]
    return found


def levels(ax):
    """Return the curves with a label in the legend."""
    return [line for line in ax.get_lines() if not line.get_label().startswith("_")]


def test_every_figure_of_the_documents_is_listed():
    trento, campinas = (re.findall(r"^\| (\d[^|]*) \|", part, flags=re.MULTILINE) for part in PAGE.split("\n## ")[1:])
    assert {int(re.match(r"\d+", name)[0]) for name in trento} == set(range(1, 23))
    assert {"3a", "3b", "7a", "7b", "13a", "13b", "15a", "15b"} <= set(trento)
    assert campinas == ["1, 2", "3 to 5", *map(str, range(6, 11))]


@pytest.mark.parametrize(("figure", "command", "where"), ROWS, ids=[f"{row[1]} {row[0]}" for row in ROWS])
def test_a_figure_is_drawn_where_the_page_states(figure, command, where, drawn):
    figures, files = drawn
    names = re.findall(r"(?<!\*)\*([^*]+)\*", where.replace("\\|", "|"))
    stems = re.findall(r"`(\w+)`", where)
    assert names
    assert set(stems) <= files
    if command == "draw":  # every figure of a tire has the name of the tire in its heading
        shown = [title for each in figures["draw"] for title in map(plain, (ax.get_title() for ax in each.axes))]
        assert all(any(re.match(re.escape(name) + r"(?!\w| and)", title) for title in shown) for name in names)
        return
    heading, *panels = names
    assert axes_of(figures[command], heading)
    for start in panels:
        assert panel(figures[command], heading, start).get_lines()


def test_a_row_of_the_tables_is_read():
    assert len(ROWS) == len(re.findall(r"^\| \d", PAGE, flags=re.MULTILINE)) - 3


@pytest.mark.parametrize("force", ["Gxalpha", "Gykappa"])
def test_weighting_functions_are_drawn_over_both_slips(force, drawn):
    figures = drawn[0]["fit"]
    title = "Weighting functions of combined slip"
    over_kappa, over_alpha = (panel(figures, title, f"{force} per {slip}") for slip in ("slip angle", "longitudinal"))
    assert (plain(over_kappa.get_xlabel()), plain(over_alpha.get_xlabel())) == ("kappa (-)", "alpha (deg)")
    assert all(np.ptp(line.get_xdata()) > 0.5 for line in levels(over_kappa))  # kappa from -0.3 to 0.3
    assert all(np.ptp(line.get_xdata()) > 5.9 for line in levels(over_alpha))  # alpha to 6 deg


def test_side_force_over_kappa_at_three_degrees_has_a_curve_for_each_camber(drawn):
    ax = panel(drawn[0]["fit"], "Forces at combined slip", "Fy per camber")
    assert "alpha = 3 deg" in plain(ax.get_title())
    assert [line.get_label() for line in levels(ax)] == ["0 deg", "2 deg", "4 deg"]
    assert "R²" in ax.get_title()


def test_old_and_new_parameters_have_the_same_axes(drawn):
    figures = drawn[0]["compare"]
    old, new = (panel(figures, "Pure slip: Fy over alpha", name) for name in ("trento_hoosier", "my"))
    assert old.get_ylim() == new.get_ylim()
    assert [line.get_label() for line in levels(old)] == [line.get_label() for line in levels(new)]
    (ax,) = axes_of(figures, "Cornering stiffness over load").values()
    assert ax.get_ylabel() == "cornering stiffness (N/deg)"
    assert all((line.get_ydata() > 0.0).all() for line in ax.get_lines())


def test_the_small_tire_has_crosses_and_the_full_range_of_slip(drawn):
    pure, *surfaces, combined = drawn[0]["draw"]
    over_kappa = next(ax for ax in pure.axes if plain(ax.get_xlabel()) == "kappa (-)")
    assert over_kappa.get_xlim() == (-1.1, 1.1)
    for figure in (pure, *surfaces, combined):
        crosses = [line for ax in figure.axes for line in ax.get_lines() if line.get_marker() == "x"]
        assert sum(len(line.get_xdata()) for line in crosses) > 20
    for figure in surfaces:
        assert sum(ax.name == "3d" for ax in figure.axes) == 2
    assert [len(levels(ax)) for ax in combined.axes] == [9, 9, 9]  # -20 to 20 deg in steps of 5


def test_levels_differ_in_more_than_color_and_are_readable(drawn):
    for heading in ("Pure side force", "Forces at combined slip"):
        for ax in axes_of(drawn[0]["fit"], heading).values():
            lines = levels(ax)
            assert len({line.get_linestyle() + str(line._unscaled_dash_pattern) for line in lines}) == len(lines)
            assert all(contrast(line.get_color()) >= CONTRAST for line in lines)
