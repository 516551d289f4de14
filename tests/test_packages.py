"""Conda recipe, container file and release notes agree with the project."""

from __future__ import annotations

import re
import runpy

import pytest

from .rooms import ROOT
from .test_wheel import PROJECT

#: Names of conda-forge that differ from those of PyPI.
CONDA_NAMES = {"matplotlib": "matplotlib-base"}
RECIPE = ROOT / "conda" / "recipe.yaml"
NOTES = runpy.run_path(str(ROOT / ".ci" / "release_notes.py"))


def test_the_recipe_has_version_and_requirements_of_the_project():
    ruamel = pytest.importorskip("ruamel.yaml", reason="comes with check-jsonschema (extra dev)")
    recipe, project = ruamel.YAML(typ="safe").load(RECIPE.read_text(encoding="utf-8")), PROJECT["project"]
    assert recipe["context"]["version"] == project["version"]
    assert f">={recipe['context']['python_min']}" == project["requires-python"]
    run = {f"{CONDA_NAMES.get(name, name)} {limit}" for name, limit in map(parts, project["dependencies"])}
    assert set(recipe["requirements"]["run"]) == run | {"python >=${{ python_min }}", "c-compiler"}
    assert {f"{name} {limit}" for name, limit in map(parts, PROJECT["build-system"]["requires"])} < set(
        recipe["requirements"]["host"]
    )
    commands = [f"{name} = {function}" for name, function in project["scripts"].items()]
    assert recipe["build"]["python"]["entry_points"] == commands
    assert (recipe["about"]["summary"], recipe["about"]["license"]) == (project["description"], project["license"])


def parts(requirement):
    """Return name and limit of a requirement of PyPI."""
    return re.fullmatch(r"([\w-]+)(>=[\d.]+)", requirement).groups()


def test_rattler_build_accepts_the_recipe():
    """Its parser and its rendering, which need no channel; a package is not built."""
    rattler_build = pytest.importorskip("rattler_build", reason="the extra release is not installed")
    (rendered,) = rattler_build.Stage0Recipe.from_file(RECIPE).render()
    assert rendered.recipe.package.name == "tirefmu"
    wrong = RECIPE.read_text(encoding="utf-8").replace("noarch:", "noarh:")
    with pytest.raises(rattler_build.RecipeParseError):
        rattler_build.Stage0Recipe.from_yaml(wrong)


def test_the_notes_of_a_release_are_its_section_of_the_changelog():
    text = "# Changelog\n\n## 0.2.0 (2027-01-01)\n\n- Two.\n\n## 0.1.0\n\n- One.\n"
    notes = NOTES["release_notes"]
    assert notes("0.2.0", text) == "- Two."
    assert notes("0.1.0", text) == "- One."
    with pytest.raises(SystemExit, match=r"no notes of 0\.3\.0: it has 0\.2\.0, 0\.1\.0"):
        notes("0.3.0", text)
    assert notes(PROJECT["project"]["version"], (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"))
