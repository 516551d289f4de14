"""Misuse by a host in C that is linked with the sources of the FMU; with sanitizers if TIREFMU_SANITIZE is set."""

from __future__ import annotations

import os
import re
import subprocess
from pathlib import Path

import pytest

from tirefmu.fmu.description.interface import interface
from tirefmu.fmu.packaging.binaries import FLAGS, SMALL
from tirefmu.fmu.packaging.export import contents, fmi_headers
from tirefmu.fmu.packaging.model_code import model_files
from tirefmu.tires.code.compiler import compiled_object

SOURCE = Path(__file__).with_name("robust.c")
CASES = re.findall(r"CASE\((\w+)\)", SOURCE.read_text(encoding="ascii").split("CASES[] =")[1])
SANITIZERS = ["-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=all", "-fno-omit-frame-pointer"]


@pytest.fixture(scope="module", params=[2, 3], ids=["fmi2", "fmi3"])
def results(request, tires, compiler, tmp_path_factory):
    """Return the printed lines, the errors and the exit status of the program."""
    fmi, folder = request.param, tmp_path_factory.mktemp("robust")
    files = contents(tires["rolling"], fmi, "tire")
    sources = {name.removeprefix("sources/"): text for name, text in files.items() if name.startswith("sources/")}
    for name, text in sources.items():
        (folder / name).write_bytes(text)
    (token,) = re.findall(rb'(?:guid|instantiationToken)="([^"]+)"', files["modelDescription.xml"])
    shown = [variable.name for variable in interface(tires["rolling"]).variables]
    assert shown[1:13] == [*tires["rolling"].inputs, *tires["rolling"].outputs]
    sanitized = bool(os.environ.get("TIREFMU_SANITIZE"))
    models = [folder / name for name in model_files("mf61")]
    if not sanitized:  # the model's code is compiled once for both versions
        header = [folder / "mf61.h"]
        models = [
            compiled_object("robust", model, headers=header, include=[folder], flags=[*FLAGS, *SMALL])
            for model in models
        ]
    program = folder / "robust"
    command = [
        *compiler,
        "-std=gnu99",
        "-O1",
        *(SANITIZERS if sanitized else ()),
        f"-DFMI={fmi}",
        f"-DLMUX_REFERENCE={shown.index('LMUX')}",
        f"-I{folder}",
        f"-I{fmi_headers()}",
        str(SOURCE),
        *(str(folder / name) for name in sources if name.endswith(".c") and name not in model_files("mf61")),
        *map(str, models),
        "-o",
        str(program),
        "-lm",
        "-lpthread",
    ]
    built = subprocess.run(command, capture_output=True, text=True, check=False)
    assert built.returncode == 0, built.stderr
    done = subprocess.run([str(program), token.decode()], capture_output=True, text=True, check=False)
    return done.stdout.splitlines(), done.stderr, done.returncode


def test_there_are_enough_cases():
    assert len(CASES) == len(set(CASES)) >= 30


@pytest.mark.parametrize("case", CASES)
def test_case(results, case):
    lines, _, _ = results
    assert [line for line in lines if line.startswith(case)] == [f"{case} ok"]


def test_nothing_else_is_reported(results):
    _, errors, status = results
    assert errors == ""
    assert status == 0


@pytest.mark.parametrize("inputs", ["hub", "hub-torque"])
def test_random_calls_with_hub_inputs(tires, compiler, tmp_path, inputs):
    """No call crashes, returns a value that is not finite, or changes the state when it is refused."""
    files = contents(tires["first"], 3, "tire", inputs=inputs)
    sources = {name.removeprefix("sources/"): text for name, text in files.items() if name.startswith("sources/")}
    for name, text in sources.items():
        (tmp_path / name).write_bytes(text)
    (token,) = re.findall(rb'instantiationToken="([^"]+)"', files["modelDescription.xml"])
    shown = interface(tires["first"], inputs=inputs)
    program, sanitized = tmp_path / "fuzz", bool(os.environ.get("TIREFMU_SANITIZE"))
    command = [
        *compiler, "-std=gnu99", "-O1", *(SANITIZERS if sanitized else ()), f"-I{tmp_path}", f"-I{fmi_headers()}",
        str(SOURCE.with_name("fuzz_hub.c")), *(str(tmp_path / name) for name in sources if name.endswith(".c")),
        "-o", str(program), "-lm",
    ]  # fmt: skip
    built = subprocess.run(command, capture_output=True, text=True, check=False)
    assert built.returncode == 0, built.stderr
    calls = 100 * int(os.environ.get("TIREFMU_FUZZ", "200"))
    numbers = map(str, (calls, len(shown.contact_inputs) + 1, len(shown.variables), int(shown.spins)))
    done = subprocess.run([str(program), token.decode(), *numbers], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    accepted, refused, handled = map(int, re.findall(r"\d+", done.stdout))
    assert accepted + refused == calls
    assert (handled > 0) == shown.spins
    assert accepted > 0.25 * calls
    assert refused > 0.05 * calls
