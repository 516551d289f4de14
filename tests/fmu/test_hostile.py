"""Third-party FMUs: whatever their code does, `check` ends with a result or a one-line error, and no file remains."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import threading
import time
import zipfile
from pathlib import Path

import pandas as pd
import pytest

from tirefmu.boundary.errors import FmuError
from tirefmu.cli import main
from tirefmu.fmu import check
from tirefmu.fmu.packaging.binaries import binary_path
from tirefmu.fmu.simulation import simulate
from tirefmu.tires.property_file.writing import tir_text

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="the hostile FMU is written for POSIX systems")

DESCRIPTION = """<?xml version="1.0" encoding="UTF-8"?>
<fmiModelDescription fmiVersion="2.0" modelName="hostile" guid="{fault}">
<CoSimulation modelIdentifier="{identifier}" canHandleVariableCommunicationStepSize="true"/>
<ModelVariables>
<ScalarVariable name="alpha" valueReference="1" causality="input"><Real start="0" unit="rad"/></ScalarVariable>
<ScalarVariable name="{output}" valueReference="2" causality="output"><Real unit="{unit}"/></ScalarVariable>
</ModelVariables>
<ModelStructure><Outputs><Unknown index="2"/></Outputs></ModelStructure>
</fmiModelDescription>
"""


@pytest.fixture(scope="session")
def hostile_library(compiler, tmp_path_factory):
    """Return the compiled code of hostile.c."""
    library = tmp_path_factory.mktemp("hostile") / "hostile.so"
    source = Path(__file__).with_name("hostile.c")
    subprocess.run([*compiler, "-shared", "-fPIC", str(source), "-o", str(library)], check=True, capture_output=True)
    return library.read_bytes()


@pytest.fixture
def hostile(hostile_library, tmp_path):
    """Return a function that packs an FMU which has a fault, with additional files."""

    def pack(fault="", identifier="hostile", output="Fy", unit="N", **resources):
        path = tmp_path / "hostile.fmu"
        with zipfile.ZipFile(path, "w") as archive:
            description = DESCRIPTION.format(fault=fault, identifier=identifier, output=output, unit=unit)
            archive.writestr("modelDescription.xml", description)
            archive.writestr(binary_path(2, "hostile"), hostile_library)
            for name, content in resources.items():
                archive.writestr(f"resources/{name.replace('_', '.')}", content)
        return path

    return pack


@pytest.fixture
def temporary(tmp_path, monkeypatch):
    """Return the folder of temporary files; it is empty in the end."""
    folder = tmp_path / "temporary"
    folder.mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(folder))
    yield folder
    assert list(folder.iterdir()) == []


@pytest.fixture
def table():
    return pd.DataFrame({"t": [0.0, 0.1, 0.2], "alpha": [0.0, 0.01, 0.02], "Fy": [0.0, -10.0, -20.0]})


@pytest.mark.parametrize(
    ("fault", "message"),
    [
        ("load crash", r"the FMU crashed \(SIGSEGV\)"),
        ("step crash", r"the FMU crashed \(SIGSEGV\)"),
        ("free crash", r"the FMU crashed \(SIGSEGV\)"),
        ("step abort", r"the FMU crashed \(SIGABRT\)"),
        ("load exit", r"the FMU ended its process \(exit code 0\)"),
        ("step exit", r"the FMU ended its process \(exit code 0\)"),
        ("step refuse", r"row 0: fmi2DoStep failed with status 3 \(error\): \\x1b\[2J a line\\x0aand another"),
    ],
)
def test_a_failure_is_reported_in_one_line(hostile, table, temporary, fault, message):
    with pytest.raises(FmuError, match=rf"hostile\.fmu: {message}$"):
        check(hostile(fault), table)


@pytest.mark.parametrize("fault", ["load hang", "step hang"])
def test_an_fmu_that_hangs_is_terminated(hostile, table, temporary, fault):
    with pytest.raises(FmuError, match=r"hostile\.fmu: the FMU does not end within 1\.5 s; --timeout SECONDS"):
        check(hostile(fault), table, timeout=1.5)


@pytest.mark.parametrize("timeout", [0.0, -1.0, float("nan"), float("inf")])
def test_the_time_limit_must_be_a_positive_number(hostile, table, temporary, timeout):
    with pytest.raises(FmuError, match="is not a positive finite time"):
        check(hostile(), table, timeout=timeout)


def test_the_time_limit_grows_with_the_table(hostile, table, temporary, monkeypatch):
    limits = []
    monkeypatch.setattr(simulate, "_run", lambda _folder, limit: limits.append(limit))
    for rows in (table, pd.concat([table] * 1000)):
        with pytest.raises(FmuError, match="does not end within"):
            check(hostile(), rows.assign(t=range(len(rows))))
    assert limits[1] - limits[0] == pytest.approx(simulate.TIME_LIMIT_PER_ROW * 2997)


def test_what_it_prints_is_not_shown(hostile, table, temporary, capfd):
    result = check(hostile("step print"), table)
    assert result.rows == 3
    assert list(result.simulated["Fy"]) == [0.0, 0.0, 0.0]
    assert capfd.readouterr() == ("", "")


def is_alive(process):
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    # Without a process that waits for orphans, a terminated one remains a zombie.
    state = Path(f"/proc/{process}/stat")
    return not state.is_file() or state.read_text(encoding="ascii").rpartition(")")[2].split()[0] != "Z"


def wait_until(condition):
    for _ in range(6000):
        if condition():
            return
        time.sleep(0.01)
    pytest.fail("did not happen within a minute")


def test_its_child_processes_end_with_it(hostile, table, temporary, tmp_path, monkeypatch):
    left = tmp_path / "left"
    monkeypatch.setenv("HOSTILE_FILE", str(left))
    assert check(hostile("load leave"), table).rows == 3
    wait_until(lambda: not is_alive(int(left.read_text(encoding="ascii"))))


def test_ctrl_c_ends_it(hostile, table, temporary, monkeypatch):
    started = []
    popen = subprocess.Popen

    def remembered(*arguments, **options):
        started.append(popen(*arguments, **options))
        threading.Timer(1.0, signal.raise_signal, (signal.SIGINT,)).start()
        return started[-1]

    monkeypatch.setattr(simulate.subprocess, "Popen", remembered)
    before = signal.signal(signal.SIGINT, signal.default_int_handler)  # what a shell runs in the background ignores it
    try:
        with pytest.raises(KeyboardInterrupt):
            check(hostile("step hang"), table)
    finally:
        signal.signal(signal.SIGINT, before)
    (process,) = started
    assert process.returncode == -signal.SIGKILL


def test_it_ends_with_the_process_that_checks(hostile, table, tmp_path):
    table.to_csv(tmp_path / "table.csv", index=False)
    program = tmp_path / "checks.py"
    program.write_text(
        "import subprocess, sys\n"
        "from tirefmu.fmu import check\nfrom tirefmu.fmu.simulation import simulate\n"
        "popen = subprocess.Popen\n"
        "def reported(*arguments, **options):\n"
        "    process = popen(*arguments, **options)\n"
        "    print(process.pid, flush=True)\n"
        "    return process\n"
        "simulate.subprocess.Popen = reported\n"
        "check(sys.argv[1], sys.argv[2])\n",
        encoding="ascii",
    )
    command = [sys.executable, str(program), str(hostile("step hang")), str(tmp_path / "table.csv")]
    environment = {**os.environ, "TMPDIR": str(tmp_path)}  # files of a killed process are deleted with the test
    with subprocess.Popen(command, stdout=subprocess.PIPE, env=environment) as process:
        pid = int(process.stdout.readline())
        assert is_alive(pid)
        process.kill()
    wait_until(lambda: not is_alive(pid))


def test_the_command_is_one_line_and_exits_2(hostile, table, temporary, tmp_path, capfd):
    table.to_csv(tmp_path / "table.csv", index=False)
    answer = tmp_path / "answer.json"
    command = ["check", str(hostile("step crash")), str(tmp_path / "table.csv"), "--json", str(answer)]
    assert main([*command, "--timeout", "50"]) == 2
    out, err = capfd.readouterr()
    assert out == ""
    assert err == f"tirefmu: error: {tmp_path / 'hostile.fmu'}: the FMU crashed (SIGSEGV)\n"
    assert not answer.exists()


def test_a_library_outside_is_not_loaded(hostile, table, temporary, tmp_path):
    with pytest.raises(FmuError, match=r"modelIdentifier '\.\./\.\./evil' is not a C identifier"):
        check(hostile(identifier="../../evil"), table)


def test_control_characters_are_not_shown(hostile, table, temporary):
    result = check(hostile(unit="&#x9b;2JN" + "m" * 1000), table)
    assert "\x9b" not in str(result)
    assert len(result.channels[0].unit) == 20


@pytest.mark.parametrize(
    ("interface", "message"),
    [
        (b"{", r"not JSON \(.*\)"),
        (b"\xff", r"not JSON \(.*\)"),
        (b"[" * 100_000, r"not JSON \(.*\)"),
        (b"[]", "not an object"),
        (b'{"axes": "\\u001b[2J"}', r"unknown axes '\\x1b\[2J': known are iso and sae"),
        (b'{"axes": {}}', r"unknown axes '\{\}': known are iso and sae"),
        (b" " * 1_000_001, "larger than 1 MB"),
    ],
)
def test_a_broken_interface(hostile, table, temporary, interface, message):
    with pytest.raises(FmuError, match=rf"hostile\.fmu: resources/interface\.json: {message}$"):
        check(hostile(interface_json=interface), table)


def test_a_broken_tire(hostile, table, temporary):
    with pytest.raises(FmuError, match=r"hostile\.fmu: resources/tire\.tir:1: section '\[MODEL' is not closed"):
        check(hostile(tire_tir="[MODEL\n"), table)


def test_a_tire_of_another_model(hostile, table, temporary, tires):
    path = hostile(output="Mx", unit="N.m", tire_tir=tir_text(tires["first"]))
    with pytest.raises(FmuError, match=r"hostile\.fmu: resources/tire\.tir is of mf96, which has no output Mx$"):
        check(path, table.assign(Mx=1.0))


def test_a_broken_answer(hostile, table, temporary, monkeypatch):
    def answer(text):
        def run(folder, _limit):
            (folder / "answer.json").write_text(text, encoding="ascii")
            return 0

        return run

    for text in ("", "[]", "{}", json.dumps({"problems": 3}), "[" * 100_000, " " * 1_000_001):
        monkeypatch.setattr(simulate, "_run", answer(text))
        with pytest.raises(FmuError, match=r"hostile\.fmu: the FMU's process wrote an invalid answer"):
            check(hostile(), table)
