"""Every tire with an effect of the library converts for every host, and the message states what happened to it."""

from __future__ import annotations

import json
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from tirefmu import convert
from tirefmu.applications.exports import HOSTS, acting, relative_errors, without_added
from tirefmu.applications.exports import convert as conversion
from tirefmu.commands.cli import main
from tirefmu.symbolic.added import library, read_effect
from tirefmu.symbolic.models import MODELS, whole_library
from tirefmu.tires import Tire, read_tir

from .conftest import FIALA

#: Models that take long.
LARGE = {name for name in MODELS if name != "brush"}
#: Few operating conditions, for the laws without a fit.
ROWS = pd.DataFrame({"kappa": [0.0, 0.05, -0.1, 0.0], "alpha": [0.08, 0.0, 0.05, -0.15], "gamma": 0.02, "Fz": 3000.0})


def with_effect(tire, effect):
    """Return a tire with an effect of the library at its typical size, or at its declared start without a detection."""
    neutral = {declaration.name: declaration.neutral or 0.0 for declaration in effect.declarations}
    given = {name: value for name, value in tire.values.items() if name not in tire.defaulted}
    if not effect.detection:
        given |= {
            declaration.name: declaration.start for declaration in effect.declarations if declaration.start is not None
        }
    for form in effect.detection.forms if effect.detection else ():
        for probe in form.probes:
            given |= {name: neutral[name] + size for name, size in probe.items()}
        given |= {name: sizes[0] for name, sizes in form.grid.items()}
    extended = replace(
        tire, added=whole_library(tire.symbolic_model)
    )  # with the whole library a model is not printed anew
    return replace(extended, values=given, effects={*tire.has, effect.name})


@pytest.mark.parametrize("model", [pytest.param(name, marks=[pytest.mark.slow] * (name in LARGE)) for name in MODELS])
def test_a_tire_with_an_effect_converts_for_every_host(model, tire_of, tmp_path, monkeypatch):
    """The fits are replaced by their start: what is fitted is tested below."""
    monkeypatch.setattr(conversion, "_operating_range", lambda tire: ROWS)
    monkeypatch.setattr(conversion, "fit", lambda table, model, *, start, **options: SimpleNamespace(tire=start))

    def start(tire, forces, lacking, table):
        neutral = {name: tire.symbolic_model.coefficients[name].neutral for name in acting(tire, lacking)}
        return replace(tire, values={**tire.values, **neutral})

    monkeypatch.setattr(conversion, "nearest", start)
    tire = tire_of(model)
    for effect in library().values():
        if not tire.symbolic_model.has_place_for(effect):
            continue
        whole = with_effect(tire, effect)
        for host in HOSTS:
            result = convert(whole, tmp_path / "x.tir", host)
            texts = [finding.text for finding in result.findings if finding.severity == "error"]
            # The start of a fit describes some forces poorly: each of these is an error, and nothing else is.
            poor = [f"{name} of the file differs by " for name, error in result.errors.items() if error > 0.5]
            errors = [text for text in texts if not text.startswith(tuple(poor))]
            assert len(texts) == len(poor)
            stated = [finding.text for finding in result.findings if f"added effect {effect.name} is " in finding.text]
            assert (errors, len(stated)) == ([], 1), (effect.name, host)
            assert {"Fx", "Fy"} <= result.errors.keys()
            assert np.isfinite(list(result.errors.values())).all()
            written = read_tir(result.path)
            if "folded" in stated[0]:
                assert not written.added, (effect.name, host)


def test_a_user_defined_effect_is_folded_and_its_error_printed(tmp_path, capsys):
    """A tire that a diagnosis delivers has its effects in its file."""
    effect = read_effect(
        'name = "sliding_grip"\nphysics = "p"\nsource = "s"\n[coefficients]\nSLIDE1 = {description = "d", unit = "1"}\n'
        '[[acts]]\non = "friction_y"\nfactor = "1 - SLIDE1*tan(alpha)**2"\n',
        "sliding.toml",
    )
    whole = Tire("fiala", {**FIALA, "SLIDE1": 2.0}, added=(effect,), effects=("sliding_grip",))
    whole.save(tmp_path / "improved.tir")
    line = ["convert", str(tmp_path / "improved.tir"), "-o", str(tmp_path / "x.tir"), "--for", "adams"]
    assert main([*line, "--json", str(tmp_path / "x.json")]) == 0
    out = capsys.readouterr().out
    assert "coefficients fitted to the tire's forces; RMS error over its range, in steady state: Fx " in out
    assert "the added effect sliding_grip is folded into the coefficients" in out
    errors = json.loads((tmp_path / "x.json").read_text(encoding="utf-8"))["errors"]
    assert 1e-4 < errors["Fy"] < 0.1


def test_an_effect_is_folded_into_the_coefficients_that_a_host_reads(mf61, tmp_path):
    whole = with_effect(mf61, library()["heat_friction"])
    result = convert(whole, tmp_path / "x.tir", "simcenter")
    table = pd.DataFrame({"alpha": np.linspace(-0.2, 0.2, 41), "Fz": 4000.0})
    forces = whole.evaluate(table, steady=True)
    before, after = (relative_errors(tire, table, forces)["Fy"] for tire in (without_added(whole), result.tire))
    assert after < 0.3 * before
    assert result.refitted
    assert [finding.text for finding in result.findings if "heat" in finding.text] == [
        "the added effect heat_friction is folded into the coefficients: its forces at nominal conditions"
    ]
