"""Lists of effects, models and published tires; examples in the help of every command."""

from __future__ import annotations

import json
import re
import shlex

import click

from tirefmu.commands.cli import cli
from tirefmu.commands.command import SECTIONS, Command
from tirefmu.measurements import read_recording
from tirefmu.measurements.catalogue import effects
from tirefmu.symbolic.added import library
from tirefmu.symbolic.models import MODELS
from tirefmu.tires import published


def test_every_effect_that_a_tire_can_have_is_listed(command):
    listed = {entry["name"]: entry for entry in json.loads(command("effects", "--json", "-", "--quiet").out)["effects"]}
    assert set(listed) == {*library(), *(name for model in MODELS.values() for name in model.effects)}
    for name, model in MODELS.items():
        defaults = {
            effect for effect, entry in listed.items() if entry["kind"] == "default" and name in entry["models"]
        }
        assert defaults == model.default_effects
    out = command("effects").out
    assert all(name in out for name in listed)


def test_an_effect_is_described_with_formula_coefficients_and_measurement(command):
    out = command("effects", "temp_friction").text
    (declared,) = effects("temp_friction")
    for text in ("TMU1", "1/K", "-0.05 to 0.05", declared["source"], declared["formulas"][0]["factor"], "T"):
        assert text in out
    assert "camber_thrust" in command("effects", "--model", "mf61").out
    assert "camber_thrust" not in command("effects", "--model", "brush").out


def test_models_and_published_tires_are_listed(command):
    found = json.loads(command("models", "--json", "-", "--quiet").out)["models"]
    assert [model["name"] for model in found] == list(MODELS)
    tires = json.loads(command("published", "--json", "-", "--quiet").out)["published"]
    assert [tire["name"] for tire in tires] == list(published())
    out = command("models").out + command("published").out
    assert all(name in out for name in (*MODELS, *published()))


def test_every_command_has_examples_that_its_options_accept():
    for name, command in cli.commands.items():
        assert isinstance(command, Command)
        assert f"tirefmu {command.examples[0]}" in command.get_help(cli.make_context("tirefmu", [name]))
        for line in command.examples:
            first, *arguments = shlex.split(line)
            assert first == name
            command.make_context(name, arguments)


def test_the_help_has_every_command_once_under_a_heading_with_a_whole_sentence():
    assert {command.section for command in cli.commands.values()} == set(SECTIONS)
    shown = cli.get_help(click.Context(cli, terminal_width=80))
    for name in cli.commands:
        sentence = re.search(rf"^  {name}  +(.*)$", shown, re.MULTILINE)[1]
        assert sentence == sentence.removesuffix("...").removesuffix(".") + "."


def test_an_example_recording_is_that_of_the_tire_on_the_bench(command, tmp_path):
    """The forces are those of the tire but for noise, which the seed sets."""
    paths = [tmp_path / f"{seed}.csv" for seed in (1, 2)]
    for seed, path in zip((1, 2), paths, strict=True):
        outcome = command("example", "-o", path, "--sample-rate", 2, "--seed", seed, "--json", "-")
        assert outcome.status == 0, outcome.err
    reported = json.loads(outcome.out)
    first, second = (read_recording(path) for path in paths)
    assert reported["rows"] == len(first) == len(second)
    assert first.signs == "iso"
    tire = published("trento_hoosier")
    assert reported["nominal"]["R0"] == tire.values["UNLOADED_RADIUS"]
    assert abs(reported["nominal"]["Fz0"] - first.table["Fz"].median()) < 10.0
    evaluated = tire.evaluate(first.table, signs="iso")
    for channel in ("Fx", "Fy", "Mz"):
        error = first.table[channel] - evaluated[channel]
        assert 0.0 < error.std() < 0.1 * first.table[channel].std(), channel
        assert not first.table[channel].equals(second.table[channel])
