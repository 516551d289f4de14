"""An option of a fit is declared once: the command line, files and the window follow."""

from __future__ import annotations

from inspect import signature

import pytest

from tirefmu.applications.batch import OPTIONS
from tirefmu.applications.project import SECTIONS, Project
from tirefmu.commands.cli import cli
from tirefmu.fitting import FitOptions, declared_options, fit

DECLARED = declared_options()


def test_the_function_names_every_option():
    assert DECLARED.keys() <= signature(fit).parameters.keys()


@pytest.mark.parametrize("name", DECLARED)
def test_the_command_has_the_option_with_its_default(name):
    option, default = DECLARED[name]
    (parameter,) = (one for one in cli.commands["fit"].params if one.name == name)
    assert parameter.opts == [option.flag]
    context = cli.commands["fit"].make_context("fit", ["a.csv", "-o", "a.tir"])
    assert context.params[name] == default


def test_files_have_those_that_are_declared_for_them():
    assert declared_options("project").keys() == SECTIONS["fit"].keys() - {
        "model",
        "start",
        "cross_validate",
        "hold_out",
    }
    assert declared_options("jobs").keys() == OPTIONS.keys() - {"model", "start"}


def test_a_key_of_a_project_becomes_the_option(tmp_path):
    project = Project(tmp_path / "tirefmu.toml", {"fit": {"loss": "huber", "fixed": {"PCY1": 1.5}}})
    context = cli.commands["fit"].make_context("fit", ["a.csv", "-o", "a.tir", *project.options("fit")])
    options = FitOptions(**{name: context.params[name] for name in DECLARED})
    assert options == FitOptions(loss="huber", fixed={"PCY1": 1.5})


def test_choices_of_the_window_are_values_of_the_option():
    for name, (option, default) in DECLARED.items():
        assert bool(option.label) == bool(option.choices), name
        assert not option.choices or default in option.choices
