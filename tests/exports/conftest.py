"""Tires that are printed in every language, and the run of a printout's self-test."""

from __future__ import annotations

from dataclasses import replace
from functools import wraps

import pytest

from tirefmu.applications.exports import generate
from tirefmu.symbolic.added import AddedEffect
from tirefmu.symbolic.added.effect import Act
from tirefmu.symbolic.declarations import Coefficient
from tirefmu.symbolic.printers.languages.program import FUNCTIONS, TOLERANCE
from tirefmu.tires import Tire, published, read_tir

from . import self_tests
from .self_tests import NotInstalledError, differences

#: Ends comments and strings of several languages.
HOSTILE = '*/ -- }% """ \' #= =# \\end{document} ??/ \u2028 $(touch ran) <script> {{7}} @name@ \\'


def wet_grip(text=HOSTILE):
    """Return a user-defined effect whose texts are a given one; its formula has a power with a quotient."""
    coefficient = Coefficient(text, "1", -1.0, 1.0)
    coefficient.name = "GRIPT"
    formula = "1 + GRIPT*sin(gamma)*(1 + gamma**2)**(1/(2 + GRIPT))"
    return AddedEffect("wet_grip", text, text, (coefficient,), (Act("friction_y", "factor", formula),))


SIZE = {"FNOMIN": 3000.0, "UNLOADED_RADIUS": 0.31}
FIALA = {**SIZE, "WIDTH": 0.15, "VERTICAL_STIFFNESS": 2e5, "CSLIP": 9e4, "CALPHA": 6e4, "UMIN": 0.7, "UMAX": 1.1}


@pytest.fixture(scope="session")
def tire_of(golden):
    """Return a function: the tire of a model, with all effects if it is a Magic Formula."""

    def tire(model):
        if model in ("mf52", "mf61", "mf62"):
            return read_tir(golden / f"MagicFormula{model[2:]}_Parameters.tir")
        return published("trento_hoosier") if model == "mf96" else Tire(model, FIALA if model == "fiala" else SIZE)

    return tire


@pytest.fixture(scope="session")
def mf61(tire_of):
    return tire_of("mf61")


@pytest.fixture(scope="session")
def trento(tire_of):
    return tire_of("mf96")


@pytest.fixture(scope="session")
def wet(trento):
    """Return an MF96 tire with a user-defined effect, all texts hostile, and effects with states of each kind."""
    effects = {*trento.has, "wet_grip", "heat_friction", "slip_history", "temperature", "temp_friction"}
    values = {**trento.values, "GRIPT": 0.01, "HMU": 0.016, "SHMUX": 0.05, "SHMUY": 0.05, "SHKX": 0.1, "SHKY": 0.1}
    values |= {"TMU1": -0.002, "TREF": 50.0, "THACT": 1.0, "THSHAREX": 0.8}
    return replace(trento, values=values, effects=effects, name=HOSTILE, added=(wet_grip(),))


def or_skip(function):
    """Return a function that skips the test if a program or package is missing."""

    @wraps(function)
    def call(*given):
        try:
            return function(*given)
        except NotInstalledError as error:
            pytest.skip(str(error))

    return call


tool, command_of = or_skip(self_tests.tool), or_skip(self_tests.command_of)


def with_faults(stored):
    """Return the text of a self-test's file twice: its last result wrong, a result of its first row not a number.

    Later rows are correct, and a comparison with NaN is false: NaN must not be lost.
    """
    head, sizes, first, *rows = stored.splitlines()
    *values, last = rows[-1].split()
    wrong = [*values, repr(float(last) + 1e-3 * max(1.0, abs(float(last))))]
    undefined = [*first.split()[:-1], "nan"]
    return (
        "\n".join([head, sizes, first, *rows[:-1], " ".join(wrong), ""]),
        "\n".join([head, sizes, " ".join(undefined), *rows, ""]),
    )


@pytest.fixture(scope="session")
def assert_agrees():
    """Return a function that runs a printout's self-test, correct and with faults in its stored results."""

    def check(command, folder, functions=FUNCTIONS):
        code, largest = differences(command, folder)
        assert code == 0, largest
        assert set(largest) == set(functions)
        for name, difference in largest.items():
            assert 0 <= difference <= TOLERANCE[name], (name, difference)
        assert not (folder / "ran").exists()
        (stored,) = folder.glob("*_selftest.txt")
        correct = stored.read_text()
        try:
            for wrong in with_faults(correct):
                stored.write_text(wrong)
                assert differences(command, folder)[0] == 1
        finally:
            stored.write_text(correct)

    return check


@pytest.fixture(scope="session")
def printout(tmp_path_factory):
    """Return a function that prints a tire and returns the folder."""

    def make(tire, language, name, rows=40, **selection):
        folder = tmp_path_factory.mktemp(f"{language}_{name}")
        generate(tire, language, folder, rows=rows, **selection)
        return folder

    return make
