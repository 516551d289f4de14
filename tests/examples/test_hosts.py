"""The scripts of examples/hosts: an FMU in a program, in ten lines, with the forces of direct evaluation."""

from __future__ import annotations

import pytest

import tirefmu


@pytest.fixture(scope="module")
def path(compiler, tmp_path_factory):
    return tirefmu.export("trento_hoosier", tmp_path_factory.mktemp("fmu") / "wheel.fmu", inputs="wheel", fmi=2)


TITLES = ["fmpy", "libcosim", "ecos", "fmucontainer", "PathSim", "CasADi (DaeBuilder)", "fmuloader", "CoFMuPy"]


@pytest.mark.parametrize("title", TITLES)
def test_a_program_has_the_forces_of_direct_evaluation(example, path, title):
    table = example("host_table")
    (program,) = (program for program in table.PROGRAMS if program.title == title)
    if not table.installed(program):
        pytest.skip("needs the extra cosimulation, or what examples/host_table.py names")
    assert table.error_of(program, path, "wheel", program.kinds[0]) < table.TOLERANCE


def test_a_program_that_fails_has_no_error(example, tmp_path):
    table = example("host_table")
    assert table.error_of(table.PROGRAMS[0], tmp_path / "absent.fmu", "slip", "CoSimulation") == float("inf")
