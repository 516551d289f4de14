"""The scripts of examples/hosts: four FMUs in a program, in a few lines, with the forces of direct evaluation."""

from __future__ import annotations

from pathlib import Path

import pytest

import tirefmu

SCRIPTS = sorted(path.name for path in (Path(__file__).parents[2] / "examples" / "hosts").glob("in_*.py"))
CASES = {"CoSimulation": ("wheel", 2, "CoSimulation", 4), "ModelExchange": ("wheel", 2, "ModelExchange", 4)}


@pytest.fixture(scope="module")
def paths(compiler, example, tmp_path_factory):
    folder, tires = tmp_path_factory.mktemp("fmu"), example("host_table").tires()
    return {
        (end, "wheel", 2): tirefmu.export(tire, folder / f"{end}.fmu", inputs="wheel", fmi=2)
        for end, tire in tires.items()
    }


@pytest.mark.parametrize("script", SCRIPTS)
def test_four_tires_in_a_program_have_the_forces_of_direct_evaluation(example, paths, script):
    table = example("host_table")
    (program,) = (program for program in table.PROGRAMS if program.script == script)
    if not table.installed(program)[0]:
        pytest.skip("needs the extra cosimulation, or a Python in TIREFMU_PYTHONS")
    case = next(case for case in CASES.values() if not program.reason(case))
    assert table.error_of(program, paths, case) < table.TOLERANCE


def test_a_program_that_fails_has_no_error(example, tmp_path):
    table = example("host_table")
    absent = {("front", "slip", 2): tmp_path / "absent.fmu"}
    assert table.error_of(table.PROGRAMS[0], absent, ("slip", 2, "CoSimulation", 1)) == float("inf")


def test_tires_that_are_exchanged_are_an_error(example):
    table = example("host_table")
    tires = table.tires()
    shown = {"kappa": 0.02, "alpha": 0.05}
    shown |= {name: float(value) for name, value in tires["rear"].forces(**shown, Fz=220.0, gamma=0.0).items()}
    assert table.force_error(tires["rear"], shown | {"Fz": 220.0}) == 0.0
    assert table.force_error(tires["front"], shown | {"Fz": 220.0}) > 0.1
