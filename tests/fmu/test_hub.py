"""FMUs with hub inputs: their kinematics, their load, and the same tire as with wheel inputs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from fmpy.validation import validate_fmu
from scipy.spatial.transform import Rotation

from tirefmu.boundary.errors import FmuError
from tirefmu.commands.cli import main
from tirefmu.fmu.description.interface import interface
from tirefmu.fmu.packaging.export import export
from tirefmu.fmu.packaging.road_file import ROAD_FILE
from tirefmu.fmu.simulation.simulate import loaded
from tirefmu.symbolic.wheel.quantities import CARRIER, CONTACT_FORCES, GLOBAL_WRENCH, ROAD, SPIN, WRENCH
from tirefmu.tires.hub import hub_wrench, wheel_motion
from tirefmu.tires.roads.opencrg import read_crg

from .conftest import DISCARD, OK
from .programs import unzipped, zipped

MOVED = tuple(quantity.name for quantity in (*CARRIER, *ROAD, SPIN))
FORCES = tuple(quantity.name for quantity in CONTACT_FORCES)
NAMES = ("first", "mf61")


@pytest.fixture
def host_of(hosts):
    return lambda name, inputs="hub": hosts(name, 3, inputs)


def rotation(*angles):
    """Return the orientation of a carrier by yaw, roll and pitch."""
    matrix = Rotation.from_euler("ZXY", angles).as_matrix()
    return {f"R_{i + 1}{j + 1}": matrix[i, j] for i in range(3) for j in range(3)}


def pose(rng, radius):
    """Return a random motion of a wheel on an inclined road that moves."""
    numbers = rng.uniform(-1.0, 1.0, 20)
    return {
        "r_x": numbers[0], "r_y": numbers[1], "r_z": 0.95 * radius + 0.01 * numbers[2],
        **rotation(*numbers[3:6] * 0.15),
        "v_x": 15.0 + 5.0 * numbers[6], "v_y": numbers[7], "v_z": 0.1 * numbers[8], "w_x": 0.2 * numbers[9],
        "w_y": numbers[10], "w_z": 0.5 * numbers[11],
        "omega": (15.0 + 5.0 * numbers[6]) / radius * (1 + 0.05 * numbers[12]),
        "road_nx": 0.1 * numbers[13], "road_ny": 0.1 * numbers[14], "road_vx": numbers[15], "road_vy": numbers[16],
        "road_vz": 0.1 * numbers[17],
    }  # fmt: skip


@pytest.mark.parametrize("name", NAMES)
def test_its_kinematics_is_that_of_python_and_its_tire_that_of_wheel_inputs(host_of, tires, name):
    hub, wheel = host_of(name), host_of(name, "wheel")
    radius, rng, time = tires[name].values["UNLOADED_RADIUS"], np.random.default_rng(3), 0.0
    same = ("V_x", "V_y", "psi_dot", "gamma", "Fz")
    touched = 0
    for host in (hub, wheel):
        host.initialize()
    for step in range(12):
        # Fast, slow, in reverse, and up to 80 m/s.
        given = {key: value * (1.0, 0.01, -1.0, 4.0)[step % 4 * (key in ("v_x", "omega"))] for key, value in
                 pose(rng, radius).items()}  # fmt: skip
        assert hub.set(**given) == OK
        motion = wheel_motion(**dict(zip(MOVED, hub.get(*MOVED), strict=True)))
        np.testing.assert_allclose(hub.get(*motion), list(motion.values()), rtol=1e-12, atol=1e-13)
        assert wheel.set(omega=hub.get("wheel_speed")[0]) == OK
        assert wheel.set(**{shown: hub.get(shown)[0] for shown in same if shown in wheel.inputs}) == OK
        forces = wheel.get(*wheel.outputs)
        np.testing.assert_allclose(hub.get(*wheel.outputs), forces, rtol=1e-9, atol=1e-9)
        contact = dict.fromkeys(FORCES, 0.0) | dict(zip(wheel.outputs, forces, strict=True)) | {"Fz": hub.get("Fz")[0]}
        moved = {key: value for key, value in given.items() if key.startswith(("R_", "road_n"))}
        wrench = hub_wrench(**contact, R_l=motion["R_l"], **moved)
        assert list(wrench) == [quantity.name for quantity in (*WRENCH, *GLOBAL_WRENCH)]
        np.testing.assert_allclose(hub.get(*wrench), list(wrench.values()), rtol=1e-9, atol=1e-8)
        touched += contact["Fz"] > 0.0
        if step < 3:
            continue  # in steady state until the end of initialization
        for host in (hub, wheel):
            assert step > 3 or host.call("ExitInitializationMode") == OK
            assert host.step(time, 0.01) == OK
        time += 0.01
    assert touched > 8


@pytest.mark.parametrize("name", ["mf52", "mf61", "mf62"])
def test_load_and_forces_are_those_of_the_golden_files(host_of, tires, golden, name):
    """The loaded radius that the reference program computed for a load gives that load, and its forces."""
    (path,) = (path for path in golden.glob(f"{name}_*.csv.xz") if "turnslip" not in path.name)
    table = pd.read_csv(path)
    # The reference has no loaded radius where the tire does not deflect, and corrects the slips of a slow wheel.
    table = table[(table.rho > 1e-6) & (table.V_in > 5.0) & (table.kappa_in > -0.9) & (table.Fz_in > 100.0)]
    table = table[table.Rl < table.Re.max() * 1.02].iloc[:: max(1, len(table) // 25)]
    host = host_of(name)
    host.initialize()
    # The reference solves MF6.2's equation of the loaded radius to 1e-6 nominal loads.
    reached = 2e-6 * tires[name].values["FNOMIN"] if name == "mf62" else 1e-6
    for row in table.itertuples():
        given = {"r_z": row.Rl * np.cos(row.gamma_in), **rotation(0.0, row.gamma_in, 0.0), "v_x": row.V_in,
                 "v_y": row.V_in * np.tan(row.alpha_in), "omega": row.omega, "p": row.p_in}  # fmt: skip
        assert host.set(**given) == OK
        for _ in range(4):  # the reference stops its iteration of slip and rolling radius early
            kappa, omega = host.get("kappa", "omega")
            assert host.set(omega=omega * (1.0 + row.kappa_in) / (1.0 + kappa)) == OK
        shown = host.get("Fz", "Fx", "Fy", "Mz", "kappa")
        expected = [row.Fz_in, row.Fx, row.Fy, row.Mz, row.kappa_in]
        np.testing.assert_allclose(shown, expected, rtol=1e-9, atol=reached)


def test_damper_and_rim_add_to_the_spring_which_lifts_off(host_of, tires):
    host, free = host_of("first"), tires["first"].values["UNLOADED_RADIUS"]
    host.initialize()
    stiffness = host.get("VERTICAL_STIFFNESS")[0]
    assert host.set(VERTICAL_DAMPING=100.0, BOTTOM_STIFF=1e6, BOTTOM_RADIUS=0.8 * free, r_z=0.9 * free) == OK
    assert host.get("Fz") == pytest.approx(stiffness * 0.1 * free)
    host.set(v_z=-1.0)
    assert host.get("Fz") == pytest.approx(stiffness * 0.1 * free + 100.0)
    host.set(v_z=100.0)
    assert host.get("Fz", "F_x", "F_y", "F_z", "M_y") == pytest.approx(0.0)
    host.set(v_z=0.0, r_z=0.7 * free)
    assert host.get("Fz") == pytest.approx(stiffness * 0.3 * free + 1e6 * 0.1 * free)
    host.set(r_z=1.001 * free)
    assert host.get("Fz", "deflection") == pytest.approx([0.0, -0.001 * free])


def test_a_tire_whose_file_has_no_damping_has_the_assumed_one(host_of):
    """Its model has a coefficient of damping, which is 0 if it is not stated."""
    assert host_of("fiala").get("VERTICAL_DAMPING")[0] == 50.0


def test_the_road_scales_friction(host_of, tires):
    """As the tire's own scaling factors do."""
    host, other = host_of("mf61"), host_of("mf61")
    for wheel in (host, other):
        wheel.initialize()
        assert wheel.set(v_y=1.5) == OK
    assert host.set(road_mu=0.4) == OK
    assert other.set(LMUX=0.4, LMUY=0.4) == OK
    np.testing.assert_allclose(host.get(*host.outputs), other.get(*host.outputs), rtol=1e-12)
    assert host.set(road_mu=0.0) == DISCARD


def test_a_road_at_the_hub_or_a_wheel_without_a_plane_is_no_number(host_of):
    host = host_of("first").start()
    before = host.everything()
    for given in ({"R_12": 0.0, "R_22": 0.0}, {"road_nz": 0.0}, {"road_ny": 1.0, "road_nz": 0.0}):
        assert host.set(**given) == OK
        assert host.read(["F_z"])[0] == DISCARD
        assert host.step(0.0, 0.01) == DISCARD
        assert host.set(R_22=1.0, road_ny=0.0, road_nz=1.0) == OK
        np.testing.assert_array_equal(host.everything(), before)


@pytest.mark.parametrize(
    ("text", "expected"), [("2e5 N/m", 2e5), ("1.5D5", 1.5e5), ("0", None), ("-5", None), ("soft", None)]
)
def test_an_entry_of_the_file_without_a_usable_number_is_the_default(tires, text, expected):
    def starts(**changed):
        shown = interface(replace(tires["first"], **changed), inputs="hub").variables
        return {variable.name: variable.start for variable in shown if variable.name in ("r_z", "VERTICAL_STIFFNESS")}

    given, default = starts(other_entries=(("VERTICAL", "VERTICAL_STIFFNESS", text),)), starts(other_entries=())
    stiffness = expected or default["VERTICAL_STIFFNESS"]
    assert given["VERTICAL_STIFFNESS"] == stiffness
    values = tires["first"].values
    assert given["r_z"] == pytest.approx(values["UNLOADED_RADIUS"] - values["FNOMIN"] / stiffness)


@pytest.mark.parametrize("name", ["UNLOADED_RADIUS", "FNOMIN"])
def test_a_wheel_without_size_is_one_line(tires, tmp_path, name):
    tire = replace(tires["first"], values={**tires["first"].values, name: 0.0})
    with pytest.raises(FmuError, match=f"hub inputs need {name} > 0, not 0"):
        export(tire, tmp_path / "x.fmu", inputs="hub")


# ------------------ FMUs with hub inputs and a road inside: heights of Python's reader, forces of a road from the host


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
    planes = []
    for x, y in points:
        assert host.set(r_x=x, r_y=y) == OK
        planes.append(host.get(*PLANE))
    expected = road.plane(*points.T)
    np.testing.assert_allclose(np.transpose(planes), np.stack([expected[name] for name in PLANE]), rtol=0, atol=1e-12)
    assert np.ptp(expected["road_z"]) > 0.1


def test_forces_are_those_of_the_same_road_from_the_host(paths, crg, make_host):
    road, host, plain = read_crg(crg), make_host(paths["road"]), make_host(paths["plain"])
    x, y = road.nodes[60] + [0.13, 0.4]
    height = float(road.height(x, y)) + 0.22
    for wheel in (host, plain):
        assert wheel.set(r_x=x, r_y=y, r_z=height, v_x=12.0, v_y=0.3, omega=50.0) == OK
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
