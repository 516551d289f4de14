"""FMUs with hub inputs and a road inside: heights of Python's reader, forces of a road from the host."""

from __future__ import annotations

import numpy as np
import pytest
from fmpy.validation import validate_fmu

from tirefmu.boundary.errors import FmuError
from tirefmu.cli import main
from tirefmu.fmu.packaging.export import export
from tirefmu.fmu.packaging.road_file import ROAD_FILE
from tirefmu.fmu.simulation.simulate import loaded
from tirefmu.tires.roads.opencrg import read_crg

from .programs import unzipped, zipped

OK, DISCARD = 0, 2
PLANE = ("road_z", "road_nx", "road_ny", "road_nz")
ROWS, COLUMNS = 150, 7


@pytest.fixture(scope="module")
def crg(tmp_path_factory):
    """Return an OpenCRG file of a road that winds, with unequal columns, heights of 20 digits and a gap."""
    path, generator = tmp_path_factory.mktemp("road") / "winding.crg", np.random.default_rng(5)
    heading = 0.02 * np.cumsum(generator.normal(size=ROWS))
    heights = np.cumsum(generator.normal(scale=0.01, size=(ROWS, COLUMNS)), axis=0)
    across = np.cumsum([-3.0, 0.5, 1.0, 0.25, 1.5, 2.0, 0.75])
    header = ["$CT", "$ROAD_CRG", "REFERENCE_LINE_INCREMENT = 0.4", "REFERENCE_LINE_START_X = -5.0", "$",
              "$KD_Definition", "#:LDFI", "U:reference line u,m,0,0.4", "D:reference line phi,rad",
              *(f"D:long section at v = {float(v)!r},m" for v in across), "$", "$" * 72]  # fmt: skip
    rows = []
    for phi, row in zip(heading, heights, strict=True):
        numbers = [f"{x:20.12f}" for x in (phi, *row)]
        rows += ["".join(numbers[i : i + 4]) for i in range(0, len(numbers), 4)]
    path.write_text("\n".join([*header, *rows]) + "\n", encoding="ascii")
    return path


@pytest.fixture(scope="module")
def paths(tires, fmus, crg, tmp_path_factory):
    path = tmp_path_factory.mktemp("fmus") / "road.fmu"
    return {"road": export(tires["first"], path, inputs="hub", road=crg), "plain": fmus["first", 3, "hub"]}


def test_it_is_valid(paths):
    assert validate_fmu(str(paths["road"])) == []


def test_heights_and_normals_are_those_of_the_reader(paths, crg, make_host):
    road, host = read_crg(crg), make_host(paths["road"]).start()
    generator = np.random.default_rng(6)
    on_road = road.nodes[generator.integers(0, ROWS, 200)] + generator.normal(scale=1.5, size=(200, 2))
    far = generator.uniform(-300.0, 300.0, size=(60, 2))
    points = np.concatenate([on_road, far, road.nodes[:20], road.nodes[-5:]])
    found = []
    for x, y in points:
        assert host.set(r_x=x, r_y=y) == OK
        found.append(host.get(*PLANE))
    expected = road.plane(*points.T)
    np.testing.assert_allclose(np.transpose(found), np.stack([expected[name] for name in PLANE]), rtol=0, atol=1e-12)
    assert np.ptp(expected["road_z"]) > 0.1


def test_forces_are_those_of_the_same_road_from_the_host(paths, crg, make_host):
    road, host, plain = read_crg(crg), make_host(paths["road"]), make_host(paths["plain"])
    x, y = road.nodes[60] + [0.13, 0.4]
    height = float(road.height(x, y)) + 0.22
    for each in (host, plain):
        assert each.set(r_x=x, r_y=y, r_z=height, v_x=12.0, v_y=0.3, omega=50.0) == OK
    assert plain.set(**{name: float(value) for name, value in road.plane(x, y).items()}) == OK
    host.start(), plain.start()
    names = ("F_x", "F_y", "F_z", "M_x", "M_y", "M_z", "c_x", "c_y", "c_z", "R_l_rate")
    np.testing.assert_allclose(host.get(*names), plain.get(*names), rtol=1e-9)
    assert host.get("F_z")[0] > 50.0
    assert host.step(0.0, 0.01) == plain.step(0.0, 0.01) == OK
    np.testing.assert_allclose(host.get(*names), plain.get(*names), rtol=1e-9)
    (slope,) = host.derivative(["road_z"], ["r_x"], [1.0])[1]
    assert slope == pytest.approx(float(road.height(x + 1e-6, y) - road.height(x - 1e-6, y)) / 2e-6, rel=1e-4)


def test_a_state_of_another_instance_has_the_same_road(paths, make_host):
    first, second = make_host(paths["road"]).start(), make_host(paths["road"]).start()
    assert first.set(r_x=7.0, r_y=0.3) == OK
    status, state = second.deserialize(first.serialized())
    assert status == second.restore(state) == OK
    np.testing.assert_array_equal(second.everything(), first.everything())
    assert second.set(r_x=-2.0) == first.set(r_x=-2.0) == OK
    np.testing.assert_array_equal(second.get(*PLANE), first.get(*PLANE))


@pytest.mark.parametrize("damage", ["cut", "longer", "format", "nan", "rows", "absent"])
def test_a_damaged_road_is_refused(paths, tmp_path, damage):
    files = unzipped(paths["road"])
    content = files[ROAD_FILE]
    files[ROAD_FILE] = {
        "cut": content[:-8], "longer": content + b"x", "format": b"X" + content[1:],
        "nan": content[:-8] + np.float64(np.nan).tobytes(), "absent": b"",
        "rows": content[:8] + (2**62).to_bytes(8, "little") + content[16:],
    }[damage]  # fmt: skip
    if damage == "absent":
        del files[ROAD_FILE]
    with pytest.raises(FmuError, match="instantiate"), loaded(zipped(tmp_path / "bad.fmu", files)):
        pass


def test_a_road_for_other_inputs_is_one_line(tires, crg, tmp_path, capsys):
    with pytest.raises(FmuError, match="needs a native FMU with hub inputs, not wheel inputs"):
        export(tires["first"], tmp_path / "tire.fmu", inputs="wheel", road=crg)
    command = ["export", "trento_hoosier", "-o", str(tmp_path / "tire.fmu"), "--inputs", "hub", "--road"]
    assert main([*command, str(tmp_path / "absent.crg")]) == 2
    assert main([*command, str(crg), "--kind", "sti"]) == 2
    assert "absent.crg" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())
