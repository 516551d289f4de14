"""The FMU with Python inside: valid, equal to the native one, robust against misuse, and editable."""

from __future__ import annotations

import zipfile

import numpy as np
import pandas as pd
import pytest
from fmpy.validation import validate_fmu

from tirefmu.boundary.errors import FmuError
from tirefmu.commands.cli import main
from tirefmu.fmu import check, export
from tirefmu.fmu.packaging.binaries import host_platform
from tirefmu.measurements import Recording
from tirefmu.tires import read_tir

from .conftest import DISCARD, OK, TIRES
from .programs import unzipped, zipped

pytestmark = pytest.mark.skipif(
    host_platform() not in ("x86_64-linux", "x86_64-windows"), reason="pythonfmu brings no binary for this machine"
)


@pytest.fixture(scope="module")
def python_fmus(tires, tmp_path_factory):
    folder = tmp_path_factory.mktemp("python fmus")
    return {name: export(tires[name], folder / f"{name}.fmu", kind="pythonfmu") for name in TIRES}


@pytest.fixture
def python_host(make_host, python_fmus):
    """Return a function that loads the Python variant of a tire."""
    return lambda name: make_host(python_fmus[name])


def drive(tire, n=120):
    """Return a recording with a variation of every input, in uneven steps."""
    draw = np.random.default_rng(2)
    t = np.cumsum(draw.uniform(0.001, 0.05, n))
    spans = {"kappa": 0.2, "alpha": 0.25, "gamma": 0.1, "phit": 0.05}
    table = pd.DataFrame({name: draw.uniform(-a, a, n) for name, a in spans.items() if name in tire.inputs})
    table["Fz"] = tire.values["FNOMIN"] * draw.uniform(0.2, 1.3, n)
    if "V" in tire.inputs:
        table["V"] = draw.uniform(-2.0, 30.0, n)
    table = table.assign(t=t)
    table = table.assign(**tire.evaluate(table, hold=True)[list(tire.outputs)])
    # The slips lag behind random inputs so much that Fy seems to rise with alpha; the columns are as stated.
    return Recording(table, "iso", "drive", {"asserted": " ".join(table)})


def test_is_valid(python_fmus, name):
    assert validate_fmu(str(python_fmus[name])) == []


def test_outputs_are_those_of_the_tire(python_fmus, tires, name):
    result = check(python_fmus[name], drive(tires[name]))
    assert result.ok
    assert result.evaluation_difference < 1e-9


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("variable", ["alpha", "PCY1"])
def test_values_that_are_not_finite_are_rejected(python_host, variable, value):
    host = python_host("first").start()
    before = host.forces(alpha=0.1, Fz=900.0)
    stored = host.get(variable)
    host.set(Fz=500.0, **{variable: value})
    assert host.get(variable) == stored
    assert host.get(*host.outputs).tolist() == before.tolist()
    assert host.step(0.0, 0.1) == DISCARD
    assert host.set(Fz=900.0) == OK
    assert host.step(0.0, 0.1) == OK


def test_an_invalid_input_stops_the_step(python_host):
    host = python_host("first").start()
    before = host.everything()
    host.set(Fy=1.0)
    assert host.step(0.0, 0.1) == DISCARD
    host.set_references([9999], [1.0])
    assert host.step(0.0, 0.1) == DISCARD
    assert host.everything().tolist() == before.tolist()
    assert np.isnan(host.get(9999)).all()


@pytest.mark.parametrize("size", [-0.1, np.nan, np.inf])
def test_invalid_step_sizes_are_rejected(python_host, lagging, size):
    host = python_host(lagging).start()
    host.forces(alpha=0.1)
    before = host.everything()
    assert host.step(0.0, size) == DISCARD
    assert host.everything().tolist() == before.tolist()


def test_reset_restarts(python_host, lagging):
    host = python_host(lagging)
    runs = []
    for _ in range(2):
        host.start()
        host.set(alpha=0.1, V=15.0)
        assert host.step(0.0, 0.01) == OK
        runs.append(host.everything())
        assert host.call("Reset") == OK
    assert runs[0].tolist() == runs[1].tolist()


def test_a_saved_state_restores_the_run(python_host, lagging):
    host = python_host(lagging).start()
    host.set(alpha=0.1, V=15.0)
    assert host.step(0.0, 0.01) == OK
    state, before = host.fmu.getFMUstate(), host.everything()
    host.set(alpha=-0.1)
    assert host.step(0.01, 0.01) == OK
    assert host.everything().tolist() != before.tolist()
    again = host.fmu.deSerializeFMUstate(host.fmu.serializeFMUstate(state))
    host.fmu.setFMUstate(again)
    assert host.everything().tolist() == before.tolist()


def test_two_tires_in_one_process_are_independent(python_host, tires):
    first, other = python_host("first").start(), python_host("mf61").start()
    for host, tire in ((first, tires["first"]), (other, tires["mf61"])):
        expected = tire.forces(alpha=0.1, Fz=800.0)["Fy"].item()
        host.set(alpha=0.1, Fz=800.0)
        assert host.get("Fy")[0] == pytest.approx(expected, rel=1e-12)


def test_its_files_can_be_changed(python_fmus, tires, tmp_path):
    files = unzipped(python_fmus["first"])
    # Python has already loaded a module of the original name, so the changed one has another name.
    slave, changed = files["resources/slavemodule.txt"].decode(), {}
    for name, content in files.items():
        if name == f"resources/{slave}.py":
            assert content.count(b"map(float, forces)") == 1
            content = content.replace(b"map(float, forces)", b"(0.5 * float(force) for force in forces)")
        content = content.replace(b'modelIdentifier="first"', b'modelIdentifier="changed"')
        changed[name.replace(slave, "changed_tire").replace("/first.", "/changed.")] = content
    changed["resources/slavemodule.txt"] = b"changed_tire"
    fmu = zipped(tmp_path / "changed.fmu", changed)
    table = pd.DataFrame({"alpha": [0.1, 0.2], "Fz": 900.0})
    table["Fy"] = 0.5 * tires["first"].forces(alpha=table["alpha"], Fz=900.0)["Fy"]
    assert check(fmu, table).channels[0].rmse < 1e-9


def test_contents(python_fmus, tires, tmp_path):
    with zipfile.ZipFile(python_fmus["first"]) as archive:
        names = set(archive.namelist())
        assert read_tir(archive.extract("resources/tire.tir", tmp_path)).values == tires["first"].values
        assert b"MIT" in archive.read("documentation/licenses/pythonfmu.txt")
        description = archive.read("modelDescription.xml").decode()
    assert {"resources/mf96.py", "resources/variables.json", "resources/slavemodule.txt"} <= names
    assert not any(name.startswith("sources/") for name in names)
    assert 'needsExecutionTool="true"' in description
    assert "DirectionalDerivative" not in description


def test_equal_tires_give_equal_bytes(python_host, python_fmus, tires, tmp_path):
    python_host("first").start()  # which loads its copy of pythonfmu into this process
    again = export(tires["rolling"], tmp_path / "rolling.fmu", kind="pythonfmu")
    assert again.read_bytes() == python_fmus["rolling"].read_bytes()


# ------------------------------------------------------------------ errors


def test_fmi_3_is_refused(tires, tmp_path):
    with pytest.raises(FmuError, match="the pythonfmu variant supports FMI 2 only, not FMI 3"):
        export(tires["first"], tmp_path / "t.fmu", fmi=3, kind="pythonfmu")
    call = ["export", "trento_hoosier", "-o", str(tmp_path / "t.fmu"), "--kind", "pythonfmu", "--fmi", "3"]
    assert main(call) == 2
    assert list(tmp_path.iterdir()) == []
