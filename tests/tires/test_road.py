"""Roads from OpenCRG files: geometry, bilinear heights, and files that are none."""

from __future__ import annotations

import re

import numpy as np
import pytest

from tirefmu.boundary.errors import DataError
from tirefmu.tires.roads.opencrg import read_crg
from tirefmu.tires.roads.road import Road

HEADER = """$CT
a road ! of a test
$ROAD_CRG ! parameters
REFERENCE_LINE_INCREMENT = 0.5
REFERENCE_LINE_START_X = 2.0
LONG_SECTION_V_INCREMENT = 1.0
$
$KD_Definition
#:LRFI
U:reference line u,m,0,0.5
D:reference line phi,rad
D:long section 1,m
D:long section 2,m
D:long section 3,m
$
$$$$$$$$10
"""
ROWS = "**unused** 0.0000000 0.1000000 0.2000000\n 0.0000000 0.0000000 0.3000000*missing**\n"


def file(folder, text):
    path = folder / "road.crg"
    path.write_text(text, encoding="latin-1")
    return path


def arc(radius, increment, n):
    """Return a road along an arc whose height is its v."""
    v = np.linspace(-2.0, 2.0, 5)
    turn = 2.0 * np.arcsin(0.5 * increment / radius)
    return Road(increment, v, np.tile(v, (n, 1)), turn * (np.arange(n) - 0.5))


def test_the_numbers_of_a_file(tmp_path):
    road = read_crg(file(tmp_path, HEADER + ROWS))
    assert road.v.tolist() == [-1.0, 0.0, 1.0]
    assert road.heights.tolist() == [[0.0, 0.1, 0.2], [0.0, 0.3, 0.3]]  # the gap has the height of its neighbour
    assert road.nodes.tolist() == [[2.0, 0.0], [2.5, 0.0]]
    assert road.height([2.0, 2.5, 2.25, 9.0], [0.5, -0.5, 0.0, 5.0]) == pytest.approx([0.15, 0.15, 0.2, 0.3])


def test_long_numbers_in_several_records_with_slope_and_banking(tmp_path):
    text = HEADER.replace("LRFI", "LDFI").replace(
        "D:reference line phi", "D:reference line slope,m/m\nD:reference line banking"
    )
    rows = [[np.nan, 0.1, 1.0, 2.0, 3.0], [0.2, 0.1, 1.0, 2.0, 3.0], [0.4, 0.0, 1.0, 2.0, 3.0]]
    records = [[f"{x:20.12f}" if np.isfinite(x) else "*" * 20 for x in row] for row in rows]
    data = "".join("".join(row[:4]) + "\n" + row[4] + "\n" for row in records)
    road = read_crg(file(tmp_path, text + data))
    expected = np.array([0.0, 0.1, 0.3])[:, None] + np.array([0.1, 0.1, 0.0])[:, None] * road.v + [1.0, 2.0, 3.0]
    np.testing.assert_allclose(road.heights, expected, rtol=1e-12)


def test_points_of_an_arc_return_to_their_place():
    radius, road = 20.0, arc(20.0, 0.1, 300)
    rng = np.random.default_rng(2)
    angle, v = rng.uniform(0.1, 1.4, 200), rng.uniform(-2.0, 2.0, 200)
    x, y = (radius - v) * np.sin(angle), radius - (radius - v) * np.cos(angle)
    along, across = road.along_and_across(x, y)
    np.testing.assert_allclose(across, v, atol=1e-4)
    np.testing.assert_allclose(along, radius * angle, atol=2e-4)
    np.testing.assert_allclose(road.height(x, y), v, atol=1e-4)


def test_heights_are_continuous_over_the_corners_of_the_reference_line():
    road = arc(4.0, 0.5, 40)
    angle = np.linspace(0.0, 4.0, 40001)
    heights = road.height(5.7 * np.sin(angle), 4.0 - 5.7 * np.cos(angle))  # outside the arc
    assert np.abs(np.diff(heights)).max() < 1e-4
    assert np.ptp(heights) < 0.05


def test_the_plane_of_an_inclined_road_is_itself():
    v = np.array([-1.0, 1.0])
    road = Road(1.0, v, 0.05 * np.arange(4.0)[:, None] + 0.02 * v, np.zeros(4))
    plane = road.plane([1.0, 1.7], [0.3, 0.0])
    np.testing.assert_allclose(plane["road_z"], [0.056, 0.085], rtol=1e-12)
    for name, value in (("road_nx", -0.05), ("road_ny", -0.02), ("road_nz", 1.0)):
        np.testing.assert_allclose(plane[name], value, rtol=1e-12)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("$CT", "$XY", "it begins with $CT"),
        ("$$$$$$$$10", "$ROAD", "its data follow a line $$$$"),
        ("#:LRFI", "#:KRBI", "line 9: binary data (KRBI) are not supported"),
        ("#:LRFI", "#:LRFT", "line 9: format 'LRFT' is unknown: did you mean LRFI?"),
        ("#:LRFI", "", "no format"),
        ("D:long section 2", "D:lnog section 2", "line 13: channel 'lnog section 2' is unknown"),
        ("D:long section 2", "D:long section at v = 1", "some long sections have a number"),
        ("D:long section 2", "D:long section at v = 1e", "'1e' is no number"),
        ("INCREMENT = 0.5", "INCREMENT = nan", "line 4: 'REFERENCE_LINE_INCREMENT' has no number"),
        ("INCREMENT = 0.5", "INCREMENT = -1", "a positive increment"),
        ("REFERENCE_LINE_INCREMENT = 0.5\n", "", "REFERENCE_LINE_INCREMENT is missing"),
        ("LONG_SECTION_V_INCREMENT = 1.0", "", "LONG_SECTION_V_INCREMENT is missing"),
        ("LONG_SECTION_V_INCREMENT = 1.0", "LONG_SECTION_V_INCREMENT = 0.0", "v that increases"),
        ("$KD_Def", "$ROAD_CRG_MODS\nSCALE_Z = 2\n$KD_Def", "line 9: 'SCALE_Z' in $ROAD_CRG_MODS is not supported"),
        ("$KD_Def", "$ROAD_CRG_OPTS\nBORDER_MODE_U = 3\n$KD_Def", "'BORDER_MODE_U' in $ROAD_CRG_OPTS"),
        ("$KD_Def", "$ROAD_CRG_FILE\nother.crg\n$KD_Def", "'OTHER.CRG' in $ROAD_CRG_FILE"),
        (" 0.3000000*missing**", " 0.3000000 0.3x00000", "line 18: '0.3x00000' is no number"),
        (" 0.0000000 0.3000000*missing**", " 0.0000000*missing**", "line 18: '' is no number"),
        (" 0.0000000 0.3000000*missing**", "*missing***missing***missing**", "row 2 has no height"),
        ("\n 0.0000000 0.0000000 0.3000000*missing**\n", "\n", "less than 2 rows"),
    ],
)  # fmt: skip
def test_a_file_that_is_no_road_is_one_line(tmp_path, old, new, message):
    text = HEADER + ROWS
    assert old in text
    path = file(tmp_path, text.replace(old, new, 1))
    with pytest.raises(DataError, match=re.escape(message)) as caught:
        read_crg(path)
    assert str(caught.value).startswith(str(path))


def test_a_file_that_does_not_exist(tmp_path):
    with pytest.raises(DataError, match="cannot be read"):
        read_crg(tmp_path / "none.crg")
