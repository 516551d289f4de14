"""Tires as a system (SSP): valid by the standard's schemas, run by fmpy, and parameter sets that replace a tire."""

from __future__ import annotations

import xml.etree.ElementTree as ET
import zipfile
from dataclasses import replace
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
from fmpy.ssp.simulation import simulate_ssp
from fmpy.ssp.ssd import read_ssd, read_ssm, read_ssv
from lxml import etree

from tirefmu.boundary.errors import FmuError
from tirefmu.commands.cli import main
from tirefmu.fmu import export_parameters, export_system
from tirefmu.fmu.description.interface import INPUTS, interface

from .conftest import OK
from .programs import zipped

SCHEMAS = {"ssd": "Description", "ssv": "ParameterValues", "ssm": "ParameterMapping"}


@pytest.fixture(scope="module")
def car(compiler, tires, tmp_path_factory):
    front, rear = tires["first"], tires["second"]
    return export_system([front, front, rear, rear], tmp_path_factory.mktemp("car") / "my car.ssp", mirror=False)


def test_equal_tires_have_one_fmu(car):
    with zipfile.ZipFile(car) as archive:
        names = archive.namelist()
    assert sum(name.endswith(".fmu") for name in names) == 2
    assert {f"resources/{name}.ssv" for name in ("FL", "FR", "RL", "RR")} <= set(names)
    assert "SystemStructure.ssd" in names


def test_the_system_runs_in_fmpy(car, tires):
    read_ssd(str(car))  # validates by the schema of SSP 1.0
    values, mapping = read_ssv(str(car), "resources/RR.ssv"), read_ssm(str(car), "resources/" + _mappings(car)[0])
    assert {p.name: float(p.value) for p in values.parameters}["PDY1"] == tires["second"].values["PDY1"]
    assert {entry.source for entry in mapping.mappingEntries} == {p.name for p in values.parameters}
    loads = {"FL": 900.0, "FR": 600.0, "RL": 700.0, "RR": 400.0}
    given = {f"{name}_Fz": lambda _t, load=load: load for name, load in loads.items()}
    given |= {f"{name}_alpha": lambda _t: 0.05 for name in loads}
    run = simulate_ssp(str(car), stop_time=0.05, step_size=0.01, input=given)[-1]
    for name, load in loads.items():
        tire = tires["first" if name.startswith("F") else "second"]
        assert run[f"{name}.Fy"] == pytest.approx(tire.forces(kappa=0.0, alpha=0.05, Fz=load)["Fy"], rel=1e-12)
        assert run[f"{name}_Fy"] == run[f"{name}.Fy"]


@pytest.mark.parametrize("side", ["left", "right", "symmetric", ""])
def test_corners_of_the_other_side_have_the_mirror_image(side, tires, tmp_path, monkeypatch):
    monkeypatch.setattr("tirefmu.fmu.packaging.system.export", lambda tire, path, **options: car_file(path))
    tire = replace(tires["first"], side=side)
    other = {"left": ("FR", "RR"), "right": ("FL", "RL")}.get(side, ())
    for mirror in (True, False):
        path = export_system([tire] * 4, tmp_path / "car.ssp", mirror=mirror)
        for name in ("FL", "FR", "RL", "RR"):
            values = {p.name: float(p.value) for p in read_ssv(str(path), f"resources/{name}.ssv").parameters}
            sign = -1.0 if mirror and name in other else 1.0
            assert (values["PHY1"], values["PDY1"]) == (sign * tire.values["PHY1"], tire.values["PDY1"]), name
    assert tire.values["PHY1"]


@pytest.mark.parametrize("inputs", INPUTS)
def test_inputs_of_the_system_have_the_start_values_of_its_tires(fmi, inputs, tires, tmp_path, monkeypatch):
    monkeypatch.setattr("tirefmu.fmu.packaging.system.export", lambda tire, path, **options: car_file(path))
    path = export_system([tires["first"], tires["second"]], tmp_path / "car.ssp", fmi=fmi, inputs=inputs)
    with zipfile.ZipFile(path) as archive:
        system, values = (ET.fromstring(archive.read(name)) for name in ("SystemStructure.ssd", "resources/inputs.ssv"))
    spaces = {prefix: f"http://ssp-standard.org/SSP1/SystemStructure{name}" for prefix, name in
              (("ssd", "Description"), ("ssv", "ParameterValues"))}  # fmt: skip
    bindings = system.findall("ssd:System/ssd:ParameterBindings/ssd:ParameterBinding", spaces)
    assert [binding.get("source") for binding in bindings] == ["resources/inputs.ssv"]
    connectors = system.findall("ssd:System/ssd:Connectors/ssd:Connector[@kind='input']", spaces)
    starts = {p.get("name"): float(p.find("ssv:Real", spaces).get("value"))
              for p in values.iterfind("ssv:Parameters/ssv:Parameter", spaces)}  # fmt: skip
    expected = {
        f"tire_{i}_{variable.name}": variable.start
        for i, name in enumerate(("first", "second"), start=1)
        for variable in interface(tires[name], inputs=inputs).group("input")
        if variable.causality == "input"
    }
    assert starts == expected
    assert {connector.get("name") for connector in connectors} == set(expected)


def _mappings(car):
    with zipfile.ZipFile(car) as archive:
        return [Path(name).name for name in archive.namelist() if name.endswith(".ssm")]


def test_a_parameter_set_replaces_the_tire(hosts, tires, tmp_path):
    values = {name: 0.9 * value if name.startswith("PD") else value for name, value in tires["first"].values.items()}
    other = replace(tires["first"], values=values)
    path = export_parameters(other, tmp_path / "other.ssv")
    host = hosts("first", 2)
    assert host.set(**{p.name: float(p.value) for p in read_ssv(str(path)).parameters}) == OK
    given = {"kappa": 0.03, "alpha": -0.07, "gamma": 0.02, "Fz": 800.0}
    expected = other.forces(**given)
    assert expected["Fy"] != pytest.approx(tires["first"].forces(**given)["Fy"], rel=0.01)
    np.testing.assert_allclose(host.start().forces(**given), [expected[name] for name in host.outputs], rtol=1e-12)


@pytest.mark.parametrize("with_vehicle", [False, True], ids=["tires", "vehicle"])
def test_valid_by_the_schemas(fmi, with_vehicle, tires, tmp_path, monkeypatch):
    package = find_spec("pyssp_standard")
    if not package:
        pytest.skip("needs pyssp-standard")
    monkeypatch.setattr("tirefmu.fmu.packaging.system.export", lambda tire, path, **options: car_file(path))
    vehicle = {"vehicle": vehicle_file(tmp_path, fmi, *VEHICLE)} if with_vehicle else {}
    path = export_system([tires["first"]] * 4, tmp_path / "car.ssp", fmi=fmi, inputs="hub", **vehicle)
    folder = Path(package.submodule_search_locations[0]) / "resources" / ("ssp2" if fmi == 3 else "")
    with zipfile.ZipFile(path) as archive:
        for name in archive.namelist():
            kind = SCHEMAS.get(name.rpartition(".")[2])
            if kind:
                schema = etree.XMLSchema(file=str(folder / f"SystemStructure{kind}.xsd"))
                assert schema.validate(etree.fromstring(archive.read(name))), (name, schema.error_log)
        written = archive.read("SystemStructure.ssd")
    assert (b"Float64" in written) == (fmi == 3)
    assert ET.fromstring(written).get("version") == f"{fmi - 1}.0"


#: Names, causalities and units of a vehicle.
VEHICLE = (("FL_r_z", "output", "m"), ("FL_F_z", "input", ""), ("RR_omega", "output", "rad/s"), ("speed", "output", ""))


def vehicle_file(folder, fmi, *variables, simulates=True):
    """Return an FMU of a vehicle without binary."""
    path, listed = folder / "vehicle.fmu", []
    for i, (name, causality, unit) in enumerate(variables):
        about = f'name="{name}" valueReference="{i}" causality="{causality}"'
        real = f'Real unit="{unit}"' if unit else "Real"
        listed.append(f"<{real.replace('Real', 'Float64', 1)} {about}/>" if fmi == 3 else
                      f"<ScalarVariable {about}><{real}/></ScalarVariable>")  # fmt: skip
    kind = '<CoSimulation modelIdentifier="car"/>' if simulates else ""
    text = f'<fmiModelDescription fmiVersion="{fmi}.0" numberOfContinuousStates="0" numberOfEventIndicators="0">'
    text += f"{kind}<ModelVariables>{''.join(listed)}</ModelVariables>"
    return zipped(path, {"modelDescription.xml": f"{text}</fmiModelDescription>"})


def test_a_vehicle_is_connected_by_names(tires, tmp_path, monkeypatch):
    monkeypatch.setattr("tirefmu.fmu.packaging.system.export", lambda tire, path, **options: car_file(path))
    path = export_system(
        [tires["first"]] * 4, tmp_path / "car.ssp", inputs="hub", vehicle=vehicle_file(tmp_path, 2, *VEHICLE)
    )
    system = read_ssd(str(path)).system
    ends = ("startElement", "startConnector", "endElement", "endConnector")
    assert sorted(tuple(getattr(connection, end) for end in ends) for connection in system.connections) == [
        ("FL", "F_z", "vehicle", "FL_F_z"),
        ("vehicle", "FL_r_z", "FL", "r_z"),
        ("vehicle", "RR_omega", "RR", "omega"),
    ]
    assert [element.name for element in system.elements] == ["vehicle", "FL", "FR", "RL", "RR"]
    assert system.connectors == []


@pytest.mark.parametrize(
    ("version", "variables", "message"),
    [
        (3, VEHICLE, "the vehicle is of FMI 3, the tires are of FMI 2"),
        (2, [("FL_r_zz", "output", "m")], "the tires have no FL_r_zz, but FL_r_z"),
        (2, [("FL_r_z", "input", "m")], "FL_r_z is an input of the tire and of the vehicle"),
        (2, [("FL_r_z", "output", "mm")], "FL_r_z has the unit mm, that of the tire m"),
        (
            2,
            [("speed", "output", "m/s")],
            "no input or output of the vehicle is named as one of a tire, such as FL_r",
        ),
    ],
)
def test_a_vehicle_that_cannot_be_connected_is_one_line(tires, tmp_path, capsys, version, variables, message):
    vehicle = vehicle_file(tmp_path, version, *variables)
    given = [*["trento_hoosier"] * 4, "--inputs", "hub", "--ssp", str(tmp_path / "car.ssp"), "--vehicle", str(vehicle)]
    assert main(["export", *given]) == 2
    assert message in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == [vehicle]


def test_an_archive_that_is_no_vehicle_is_one_line(tires, tmp_path, monkeypatch):
    monkeypatch.setattr("tirefmu.fmu.packaging.system.export", lambda tire, path, **options: car_file(path))
    broken = zipped(tmp_path / "broken.fmu", {"modelDescription.xml": "<fmiModelDescription"})
    for write, message in (
        (lambda: vehicle_file(tmp_path, 2, *VEHICLE, simulates=False), "does not support Co-Simulation"),
        (lambda: vehicle_file(tmp_path, 1, *VEHICLE), r"FMI 1\.0 is not supported"),
        (lambda: broken, r"broken.fmu: not a readable FMU"),
    ):
        with pytest.raises(FmuError, match=message):
            export_system([tires["first"]] * 4, tmp_path / "car.ssp", inputs="hub", vehicle=write())


def car_file(path):
    path.write_bytes(b"")
    return path


def test_misuse_is_one_line(tires, tmp_path, capsys):
    with pytest.raises(FmuError, match="at least one tire"):
        export_system([], tmp_path / "car.ssp")
    with pytest.raises(FmuError, match="inputs 'motion' are unknown"):
        export_parameters(tires["first"], tmp_path / "tire.ssv", inputs="motion")
    tire = ["export", "trento_hoosier"]
    for arguments, message in (
        ([*tire, "trento_hoosier", "-o", "t.fmu"], "--ssp"),
        (tire, "-o or --ssp"),
        ([*tire, "--ssp", "car.ssp", "--kind", "ssv"], "native"),
    ):
        assert main(arguments) == 2
        assert message in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []
