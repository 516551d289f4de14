"""Recordings of the benchmark: the same everywhere, made without this package, with the truth that is stated."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from missing_effects.generator.cases import TIRES, fitted_vector, made
from missing_effects.generator.draws import Draws, low_pass
from missing_effects.generator.effects import DECOYS, NAMES, UNKNOWN, true_forces
from missing_effects.generator.files import PUBLISHED_SEEDS, commitment, texts_of
from missing_effects.generator.formula import BASE, drawn_tire
from missing_effects.generator.programs import other_maneuvers
from missing_effects.generator.systems import SYSTEMS

import tirefmu
from tirefmu.symbolic.models import model_named

FOLDER = Path(__file__).parents[2] / "benchmarks" / "missing_effects"
#: Of the recordings of seed 1. Whoever changes it changes `files.VERSION` and the tables of docs/missing_effects.md.
DIGEST = "2c1e852248c4b573e75a5853f0dbd538ac48537610c8c7f10942c9961f8f1a3a"


def test_recordings_are_the_same_on_every_python_and_made_without_this_package(tmp_path):
    code = (
        "import sys; from pathlib import Path; from generator.files import write_recordings;"
        "print(write_recordings(1, Path(sys.argv[1])));"
        "print(sorted({'tirefmu', 'scipy', 'pandas', 'sympy'} & sys.modules.keys()))"
    )
    run = subprocess.run([sys.executable, "-c", code, tmp_path], cwd=FOLDER, capture_output=True, text=True, check=True)
    assert run.stdout.split("\n")[:2] == [DIGEST, "[]"]
    about = json.loads((tmp_path / "benchmark.json").read_text())
    assert about["digest"] == DIGEST
    assert about["commitment"] == commitment(1)
    assert "seed" not in about


@pytest.mark.parametrize("seed", PUBLISHED_SEEDS[:2])
def test_a_seed_has_the_declared_kinds_in_an_order_of_its_own(seed):
    cases = list(made(seed))
    kinds = [case.truth.kind for case in cases if case.about["system"] == "tire"]
    assert {kind: kinds.count(kind) for kind in TIRES} == TIRES
    assert kinds != sorted(kinds)
    assert [case.truth.kind for case in cases[len(kinds) :]].count("null") == 2
    for case in cases:
        told = json.loads(texts_of(case)["case.json"])
        assert set(case.truth.hidden) <= set(told["candidates"])
        assert not {"kind", "hidden", "truth", "variables"} & told.keys()
        assert set(case.other) == set(told["inputs"])


def test_the_effects_of_the_baseline_model_do_not_show_what_is_hidden():
    cases = [case for seed in (1, 2) for case in made(seed) if case.about["system"] == "tire"]
    bases = [set(case.about["base"]) for case in cases if case.truth.kind == "null"]
    assert any(base < set(BASE) for base in bases)
    assert any(base == set(BASE) for base in bases)


def tire_and_inputs(hidden=(), turning=True):
    draws = Draws(7, len(hidden))
    tire = drawn_tire(draws, hidden)
    return tire, other_maneuvers(draws, tire, turning)


@pytest.mark.parametrize("hidden", [(), ("load_stiffness",), ("combined_Gxa", "combined_Gyk"), tuple(BASE)])
def test_baseline_model_is_the_core_of_mf61(hidden):
    tire, x = tire_and_inputs(hidden)
    v = {"mu_x_load": 0.0, "mu_y_load": 0.0, "K_y_load": 2.0, **tire.values}
    values = {
        "FNOMIN": tire.load, "UNLOADED_RADIUS": tire.radius, "LONGVL": tire.speed, "PCX1": v["C_x"], "PDX1": v["mu_x"],
        "PDX2": v["mu_x"] * v["mu_x_load"], "PEX1": v["E_x"], "PKX1": v["K_x"], "PCY1": v["C_y"], "PDY1": v["mu_y"],
        "PDY2": v["mu_y"] * v["mu_y_load"], "PEY1": v["E_y"], "PKY1": -v["K_y"], "PKY2": v["K_y_load"],
        "QBZ1": v["B_t"], "QCZ1": v["C_t"], "QDZ1": v["trail"], "RBX1": v.get("G_x", 0.0), "RBY1": v.get("G_y", 0.0),
        "RBX2": v.get("G_x_kappa", 0.0), "RBY2": v.get("G_y_alpha", 0.0),
    }  # fmt: skip
    mf61 = tirefmu.Tire("mf61", values, effects=tire.base)
    computed = mf61.forces(**{name: x[name] for name in ("kappa", "alpha", "Fz", "V")})
    for channel, force in tire.forces(x).items():
        assert np.allclose(computed[channel], force, rtol=0.0, atol=1e-6 * np.abs(force).max()), channel


@pytest.mark.parametrize("name", [*NAMES, *UNKNOWN])
def test_a_hidden_effect_changes_forces_and_grows_with_its_size(name):
    tire, x = tire_and_inputs((name,))
    without, small, large = (true_forces(tire, x, hidden) for hidden in ({}, {name: 0.5}, {name: 1.0}))
    change = {size: max(np.sqrt(np.mean((one[c] - without[c]) ** 2)) / np.std(without[c]) for c in one)
              for size, one in (("small", small), ("large", large))}  # fmt: skip
    assert 0.004 < change["large"] < 1.0
    if name != "load_stiffness":  # the peak of the saturation, not its depth
        assert change["small"] < change["large"]


@pytest.mark.parametrize("name", UNKNOWN)
def test_an_unknown_effect_depends_on_the_stated_variables_only(name):
    tire, x = tire_and_inputs()
    variables, law = UNKNOWN[name]
    (place, before), = law(1.0, tire, x).items()  # fmt: skip
    changed = {key: values if key in variables else values[::-1] for key, values in x.items()}
    assert np.array_equal(law(1.0, tire, changed)[place], before)
    for key in set(variables) - {"Fz", "alpha"}:
        assert not np.allclose(law(1.0, tire, {**x, key: x[key][::-1]})[place], before)


def test_candidates_are_effects_of_the_library():
    known = set(model_named("mf61").effects)
    known |= {path.stem for path in (Path(tirefmu.symbolic.__file__).parent / "effects").glob("*.toml")}
    assert set(NAMES) | set(DECOYS) <= known


def test_a_lag_follows_a_ramp_at_a_constant_distance_and_keeps_its_start():
    ramp = np.arange(200.0)
    lagged = low_pass(ramp, np.full(200, 0.25))
    assert lagged[0] == 0.0
    assert np.isclose(ramp[-1] - lagged[-1], 4.0)
    assert np.allclose(low_pass(ramp, np.full(200, 1e6)), ramp, atol=1e-5)


def test_baseline_columns_of_systems_are_fitted_exactly():
    for system in SYSTEMS.values():
        x = system.program(Draws(3), False)
        values = np.array([high for _, high in system.values])
        clean, noise = system.outputs(values, x, {}), dict.fromkeys(system.channels, 1.0)
        found = fitted_vector(0.8 * values, lambda v, s=system, x=x: s.outputs(v, x, {}), clean, noise)
        assert np.allclose(found, values, rtol=1e-5)
