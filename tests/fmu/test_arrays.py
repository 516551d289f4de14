"""Array variables of FMI 3: vectors in place of scalars, with equal values and derivatives."""

from __future__ import annotations

import ctypes
import xml.etree.ElementTree as ET
import zipfile

import numpy as np
import pytest
from fmpy import read_model_description
from fmpy.validation import validate_fmu

from tirefmu.boundary.errors import FmuError
from tirefmu.commands.cli import main
from tirefmu.fmu import export

from .conftest import ERROR, OK

MOVED = {
    "r": [0.3, -0.2, 0.2265], "R": [0.99, -0.1, 0.05, 0.1, 0.99, -0.04, -0.05, 0.04, 0.99], "v": [12.0, 0.4, -0.1],
    "w": [0.1, 0.2, 0.3], "road_n": [-0.02, 0.01, 1.0], "road_v": [0.5, 0.0, 0.0],
}  # fmt: skip


@pytest.fixture(scope="module")
def paths(tires, fmus, tmp_path_factory):
    path, inputs = tmp_path_factory.mktemp("arrays") / "arrays.fmu", "hub-torque"
    return {False: fmus["first", 3, inputs], True: export(tires["first"], path, inputs=inputs, arrays=True)}


def scalars(name):
    if name == "R":
        return [f"R_{i}{j}" for i in (1, 2, 3) for j in (1, 2, 3)]
    stem, _, rest = name.partition("_")
    if name.startswith("road"):
        return [f"{name}{axis}" for axis in "xyz"]
    return [f"{stem}_{axis}{'_' + rest if rest else ''}" for axis in "xyz"]


def set_arrays(host, values):
    names, numbers = list(values), np.concatenate(list(values.values()))
    array = (ctypes.c_double * len(numbers))(*numbers)
    return host.call("SetFloat64", host.references(names), len(names), array, len(numbers))


def get_arrays(host, names, n):
    values = (ctypes.c_double * n)()
    return host.call("GetFloat64", host.references(names), len(names), values, n), np.array(values)


def test_it_is_valid_and_has_no_scalar_of_an_array(paths):
    assert validate_fmu(str(paths[True])) == []
    described = {arrays: read_model_description(str(path), validate=True) for arrays, path in paths.items()}
    names = {arrays: [v.name for v in description.modelVariables] for arrays, description in described.items()}
    arrays = [v for v in described[True].modelVariables if v.dimensions]
    replaced = {scalar for array in arrays for scalar in scalars(array.name)}
    assert len(arrays) == 11
    assert set(names[False]) - replaced == set(names[True]) - {array.name for array in arrays}
    assert replaced < set(names[False])
    for array in arrays:
        starts = [v.start for v in described[False].modelVariables if v.name in scalars(array.name)]
        assert (array.start or "None " * len(starts)).split() == [str(start) for start in starts]


def test_terminals_and_documentation_name_the_arrays(paths):
    with zipfile.ZipFile(paths[True]) as archive:
        terminals = ET.fromstring(archive.read("terminalsAndIcons/terminalsAndIcons.xml"))
        described = ET.fromstring(archive.read("modelDescription.xml"))
        assert b">road_n<" in archive.read("documentation/index.html")
    listed = {element.get("name") for element in described.find("ModelVariables")}
    members = {element.get("variableName") for element in terminals.iter("TerminalMemberVariable")}
    assert {"R", "F_global"} < members <= listed
    named = {
        terminal.get("name"): [member.get("variableName") for member in terminal.iter("TerminalMemberVariable")]
        for terminal in terminals.iter("Terminal")
    }
    assert named["carrier"] == ["r", "R", "v", "w", "omega"]
    assert named["road"] == ["road_z", "road_n", "road_v", "road_mu"]
    assert named["torques"] == ["T_drive", "T_brake"]
    assert named["hub"] == ["F", "M", "F_global", "M_global", "brake_torque"]
    assert set(named) == {"carrier", "road", "torques", "hub", "contact"}


def test_values_and_derivatives_are_those_of_the_scalars(paths, make_host):
    host, other = make_host(paths[True]), make_host(paths[False])
    host.start(), other.start()
    assert set_arrays(host, MOVED) == OK
    given = {name: value for array, values in MOVED.items() for name, value in zip(scalars(array), values, strict=True)}
    assert other.set(**given) == OK
    outputs = ["c", "F", "M", "F_global", "M_global"]
    listed = [scalar for name in outputs for scalar in scalars(name)]
    for instance in (host, other):
        assert instance.step(0.0, 0.01) == OK
    status, values = get_arrays(host, ["omega", *outputs], 16)
    assert status == OK
    np.testing.assert_array_equal(values, other.get("omega", *listed))
    assert np.ptp(values) > 100.0
    seed = np.linspace(-1.0, 1.0, 12)
    expected = other.derivative(["Fz", *scalars("F")], [*scalars("R"), *scalars("v")], seed)
    assert expected[0] == OK
    names, result = (host.references(["R", "v"]), host.references(["Fz", "F"])), (ctypes.c_double * 4)()
    seeds = (ctypes.c_double * 12)(*seed)
    assert host.call("GetDirectionalDerivative", names[1], 2, names[0], 2, seeds, 12, result, 4) == OK
    np.testing.assert_array_equal(list(result), expected[1])
    back = (ctypes.c_double * 12)()
    four = (ctypes.c_double * 4)(*[1.0, -1.0, 0.5, 2.0])
    assert host.call("GetAdjointDerivative", names[1], 2, names[0], 2, four, 4, back, 12) == OK
    assert np.dot(back, seed) == pytest.approx(np.dot(four, list(result)), rel=1e-9)


def test_a_wrong_number_of_values_changes_nothing(paths, make_host):
    host = make_host(paths[True])
    host.start()
    before = get_arrays(host, ["r", "R", "F"], 15)
    assert set_arrays(host, {"r": [1.0, 2.0]}) == ERROR
    assert host.log[-1] == "the variables have 3 values, not 2"
    assert get_arrays(host, ["R"], 3)[0] == ERROR
    assert host.call("GetFloat64", (ctypes.c_uint * 1)(0x10000 + 11), 1, (ctypes.c_double * 1)(), 1) == ERROR
    assert "there is no value reference" in host.log[-1]
    assert get_arrays(host, ["R"] * 1000, 9000)[0] == ERROR
    np.testing.assert_array_equal(get_arrays(host, ["r", "R", "F"], 15)[1], before[1])


def test_arrays_need_hub_inputs_and_fmi_3(tires, tmp_path, capsys):
    for options in ({"inputs": "wheel"}, {"inputs": "hub", "fmi": 2}):
        with pytest.raises(FmuError, match="arrays need"):
            export(tires["first"], tmp_path / "tire.fmu", arrays=True, **options)
    given = ["export", "trento_hoosier", "--ssp", str(tmp_path / "car.ssp"), "--inputs", "hub", "--arrays"]
    assert main(given) == 2
    assert "--arrays" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []
