"""FMUs with hub inputs: their kinematics, their load, and the same tire as with wheel inputs."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from scipy.spatial.transform import Rotation

from tirefmu.fmu.description.interface import interface
from tirefmu.symbolic.wheel.quantities import CARRIER, CONTACT_FORCES, GLOBAL_WRENCH, ROAD, SPIN, WRENCH
from tirefmu.tires.hub import hub_wrench, wheel_motion

from .conftest import DISCARD, OK

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
