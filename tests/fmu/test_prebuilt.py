"""Binaries built beforehand: the same results as a compiled FMU, no compiler, files of values that are malformed."""

from __future__ import annotations

import json
import lzma
import os
import re
import shutil
import struct
import subprocess
import zipfile

import fmpy
import numpy as np
import pytest
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave

from tirefmu.boundary.errors import FmuError
from tirefmu.fmu import export
from tirefmu.fmu.packaging import prebuilding, prebuilt
from tirefmu.fmu.packaging.prebuilt import VALUES_FILE, generic, values_file

from .conftest import ERROR, OK
from .programs import linked
from .test_robustness import SANITIZERS

HEADER = 8 + 64  # format and structure
COUNT = HEADER + 48 + 256  # behind the texts


@pytest.fixture(scope="module")
def folder(compiler, tires, tmp_path_factory):
    """Return the folder with the binary of one set of variables: FMI 2 and 3, with lagged slips."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(prebuilt, "FOLDER", tmp_path_factory.mktemp("built") / "prebuilt")
        assert prebuilding.build([generic(tires["rolling"])], ["host"]) == 1
        return prebuilt.FOLDER


@pytest.fixture
def packed(folder, fmus, tires, fmi, tmp_path, monkeypatch):
    """Return a tire's FMU from the binary, packed on a machine without compiler."""
    assert VALUES_FILE not in zipfile.ZipFile(fmus["rolling", fmi]).namelist()  # compiled before
    monkeypatch.setattr(prebuilt, "FOLDER", folder)
    monkeypatch.setenv("CC", "no-such-compiler")
    return export(tires["rolling"], tmp_path / f"rolling_{fmi}.fmu", fmi=fmi)


def test_the_packed_fmu_is_the_compiled_one(packed, hosts, make_host, fmi):
    ours, compiled = make_host(packed), hosts("rolling", fmi)
    assert list(ours.variables) == list(compiled.variables)
    assert ours.slave.description.guid == compiled.slave.description.guid
    for host in (ours, compiled):
        host.start()
    rng = np.random.default_rng(3)
    for k in range(5):
        given = {"kappa": rng.uniform(-1, 1), "alpha": rng.uniform(-1, 1), "Fz": rng.uniform(0, 9000), "V": 20.0 * k}
        for host in (ours, compiled):
            assert host.set(**given, PDY1=1.0 + 0.1 * k) == OK
            assert host.step(0.01 * k, 0.01) == OK
        np.testing.assert_allclose(ours.everything(), compiled.everything(), rtol=1e-12, atol=1e-12)
    beyond = max(variable.valueReference for variable in ours.variables.values()) + 1
    assert ours.read([beyond])[0] == compiled.read([beyond])[0] == ERROR  # a quantity that is no output
    assert fmpy.validation.validate_fmu(str(packed)) == []


def test_other_sources_are_compiled(folder, tires, tmp_path, monkeypatch):
    monkeypatch.setattr(prebuilt, "FOLDER", folder)
    monkeypatch.setenv("CC", "no-such-compiler")
    for options in ({"axes": "sae"}, {"inputs": "wheel"}):
        with pytest.raises(FmuError, match="no-such-compiler"):
            export(tires["rolling"], tmp_path / "tire.fmu", **options)


def test_a_binary_that_differs_from_its_digest_is_an_error(folder, tires, tmp_path, monkeypatch):
    shutil.copytree(folder, tmp_path / "copy")
    monkeypatch.setattr(prebuilt, "FOLDER", tmp_path / "copy")
    (entry,) = json.loads((tmp_path / "copy" / prebuilt.MANIFEST).read_text()).values()
    path = tmp_path / "copy" / entry["file"]
    whole = path.read_bytes()
    for content in (lzma.compress(lzma.decompress(whole)[::-1]), whole[:-100], b""):
        path.write_bytes(content)
        with pytest.raises(FmuError, match="differs from its digest"):
            export(tires["rolling"], tmp_path / "tire.fmu")
    assert not (tmp_path / "tire.fmu").exists()


def damaged(good):
    """Return malformed files of values by the reason that the FMU logs."""

    def with_number(i, number):
        at = COUNT + 8 * (1 + i)
        return good[:at] + struct.pack("<d", number) + good[at + 8 :]

    n = (len(good) - COUNT - 8) // 8
    return {
        "shorter": (good[:-1], "size"),
        "longer": (good + b"\0", "size"),
        "empty": (b"", "size"),
        "of another format": (b"X" + good[1:], "not for this binary"),
        "for other variables": (good[:20] + b"!" + good[21:], "not for this binary"),
        "with a format character": (good[: COUNT - 256] + b"%n" + good[COUNT - 254 :], "text"),
        "with an endless text": (good[:HEADER] + b"x" * 304 + good[COUNT:], "text"),
        "with another number": (good[:COUNT] + struct.pack("<Q", 2**40) + good[COUNT + 8 :], "number of values"),
        "without values": (good[:COUNT] + bytes(8) + good[COUNT + 8 :], "number of values"),
        "with NaN": (with_number(20, np.nan), "not finite"),
        "with an empty range": (with_number(n - 2, np.nan), "range"),
    }


def test_malformed_values_are_an_error_in_the_log(packed, fmi, tmp_path):
    with zipfile.ZipFile(packed) as archive:
        archive.extractall(tmp_path / "unpacked")
    description, log = fmpy.read_model_description(str(packed)), []
    path = tmp_path / "unpacked" / VALUES_FILE
    good = path.read_bytes()
    kind = FMU3Slave if fmi == 3 else FMU2Slave
    fmu = kind(guid=description.guid, unzipDirectory=str(tmp_path / "unpacked"), instanceName="tire",
               modelIdentifier=description.coSimulation.modelIdentifier)  # fmt: skip

    def instantiate():
        if fmi == 3:
            fmu.instantiate(logMessage=lambda _environment, _status, _category, line: log.append(line.decode()))
        else:
            fmu.instantiate()

    for content, reason in damaged(good).values():
        path.write_bytes(content)
        with pytest.raises(Exception, match=r"[Ii]nstantiate"):
            instantiate()
        assert fmi == 2 or reason in log[-1]
    path.unlink()
    with pytest.raises(Exception, match=r"[Ii]nstantiate"):
        instantiate()
    path.write_bytes(good)
    instantiate()
    fmu.freeInstance()


@pytest.mark.skipif("TIREFMU_SANITIZE" not in os.environ, reason="runs by make sanitize")
def test_mutated_values_under_sanitizers(compiler, tires, tmp_path):
    structure = generic(tires["rolling"])
    (tmp_path / "resources of 100 %").mkdir()
    (tmp_path / "values").write_bytes(values_file(structure, "{1}", len(structure.shown.variables)))
    program = linked(compiler, tmp_path, "tire_file.c", structure.sources, *SANITIZERS)
    done = subprocess.run([str(program), str(tmp_path)], capture_output=True, text=True, check=False)
    assert (done.stderr, done.returncode) == ("", 0)
    accepted, refused = map(int, re.findall(r"\d+", done.stdout))
    assert min(accepted, refused) > 100
