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

from tirefmu.cli import main
from tirefmu.fmu import export_parameters, export_system
from tirefmu.symbolic.errors import FmuError

from .conftest import OK

SCHEMAS = {"ssd": "Description", "ssv": "ParameterValues", "ssm": "ParameterMapping"}


@pytest.fixture(scope="module")
def car(compiler, tires, tmp_path_factory):
    front, rear = tires["first"], tires["second"]
    return export_system([front, front, rear, rear], tmp_path_factory.mktemp("car") / "my car.ssp")


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
    found = simulate_ssp(str(car), stop_time=0.05, step_size=0.01, input=given)[-1]
    for name, load in loads.items():
        tire = tires["first" if name.startswith("F") else "second"]
        assert found[f"{name}.Fy"] == pytest.approx(tire.forces(kappa=0.0, alpha=0.05, Fz=load)["Fy"], rel=1e-12)
        assert found[f"{name}_Fy"] == found[f"{name}.Fy"]


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


def test_valid_by_the_schemas_of_ssp_2(tires, tmp_path, monkeypatch):
    found = find_spec("pyssp_standard")
    if not found:
        pytest.skip("needs pyssp-standard")
    monkeypatch.setattr("tirefmu.fmu.packaging.system.export", lambda tire, path, **options: car_file(path))
    path = export_system([tires["first"], tires["rolling"]], tmp_path / "axle.ssp", fmi=3, inputs="wheel")
    folder = Path(found.submodule_search_locations[0]) / "resources" / "ssp2"
    with zipfile.ZipFile(path) as archive:
        for name in archive.namelist():
            kind = SCHEMAS.get(name.rpartition(".")[2])
            if kind:
                schema = etree.XMLSchema(file=str(folder / f"SystemStructure{kind}.xsd"))
                assert schema.validate(etree.fromstring(archive.read(name))), (name, schema.error_log)
        assert b"Float64" in archive.read("SystemStructure.ssd")
        assert ET.fromstring(archive.read("SystemStructure.ssd")).get("version") == "2.0"


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
