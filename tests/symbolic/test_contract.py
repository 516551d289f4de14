"""A model is its declarations: faults are reported before it is evaluated, and no other package names it."""

from __future__ import annotations

import ast
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from tirefmu.boundary.errors import ModelError, TirefmuWarning
from tirefmu.diagnosis import diagnose
from tirefmu.fitting import fit, load_recipe
from tirefmu.fmu import check, export
from tirefmu.measurements import Recording
from tirefmu.symbolic.contract import Baseline, FitDeclaration, PropertyFile, Role, positive
from tirefmu.symbolic.declarations import Coefficient, Section
from tirefmu.symbolic.model.discovery import register
from tirefmu.symbolic.model.verification import verify
from tirefmu.symbolic.models import MODELS
from tirefmu.tires import Tire, read_tir
from tirefmu.tires.code import code_for
from tirefmu.tires.property_file.names import not_given

ROOT = Path(__file__).parents[2]
VALUES = {"FNOMIN": 1000.0, "UNLOADED_RADIUS": 0.3, "UMAX": 1.2, "USOFT": -0.2, "CLONG": 2.5e4, "CSIDE": 1.8e4}


def bench(tire, n=400):
    """Return a recording in adapted SAE of slow sweeps at three loads."""
    t = np.linspace(0.0, 40.0, n)
    slips = {"kappa": 0.15 * np.sin(1.3 * t), "alpha": 0.2 * np.sin(2.1 * t + 0.4)}
    table = pd.DataFrame({"t": t, **slips, "Fz": np.repeat([600.0, 1000.0, 1400.0, 800.0], n // 4)})
    forces = tire.evaluate(table, signs="adapted-sae")[["Fx", "Fy", "Mz"]]
    noise = np.random.default_rng(0).normal(size=forces.shape) * [3.0, 3.0, 0.1]
    return pd.concat([table, forces + noise], axis=1)


@pytest.fixture(scope="module")
def tire(toy):
    return Tire("toy", VALUES, signs="adapted-sae")


@pytest.mark.parametrize("name", MODELS)
def test_every_model_satisfies_its_declarations(name):
    verify(MODELS[name])


def test_a_missing_sign_change_is_reported_before_evaluation(made, monkeypatch):
    monkeypatch.setitem(MODELS, "unmarked", made("unmarked", flips=False))
    tire = Tire("unmarked", VALUES, signs="adapted-sae")
    with pytest.raises(ModelError, match=r"unmarked: Fy and Mz .*: CSIDE has to flip"):
        tire.forces(alpha=0.1)


@pytest.mark.parametrize(("name", "coefficient"), [("mf96", "PVY1"), ("mf96", "PDY1"), ("mf96", "SSZ3")])
def test_a_wrong_sign_mark_is_reported(name, coefficient, monkeypatch):
    declaration = MODELS[name].coefficients[coefficient]
    monkeypatch.setattr(declaration, "flips", not declaration.flips)
    with pytest.raises(ModelError, match=coefficient):
        verify(MODELS[name])


@pytest.mark.parametrize("name", ["mf61", "fiala", "mf96"])
def test_a_wrong_statement_about_reverse_is_reported(name):
    motion = MODELS[name].motion
    wrong = replace(MODELS[name], motion=replace(motion, reverses=not motion.reverses))
    with pytest.raises(ModelError, match=f"{name}: reverses is {not motion.reverses}, but Fx"):
        verify(wrong)


def test_both_conventions_are_one_tire(tire):
    forces, mirrored = tire.forces(alpha=0.1, kappa=0.05), tire.in_signs("iso").forces(alpha=0.1, kappa=0.05)
    assert forces["Fy"] > 0
    assert (mirrored["Fx"], mirrored["Fy"], mirrored["Mz"]) == (forces["Fx"], -forces["Fy"], -forces["Mz"])


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"roles": {"grip": Role("mu")}}, "unknown role 'grip'"),
        ({"roles": {"friction_x": Role("mu_x")}}, "role friction_x has mu_x, which is no named quantity"),
        ({"roles": {"friction_x": Role("mu", ("UMIX",))}}, "role friction_x has UMIX, .*did you mean UMAX"),
        ({"roles": {"friction_x": Role("mu")}}, "role friction_y is missing"),
        ({"fit": FitDeclaration({"Fx": (positive("K_z", 0.0),)})}, "constraint of Fx has K_z"),
        ({"fit": FitDeclaration({"My": ()})}, "constraints of My, which is no output"),
        ({"baseline": Baseline(("UMAX", "CALPHA"))}, "the baseline has CALPHA"),
        ({"baseline": Baseline(starts=({"PCX1": 1.0},))}, "a start has PCX1"),
        ({"sections": ()}, "no section has the coefficient FNOMIN"),
    ],
)
def test_a_wrong_declaration_is_named(made, change, message):
    with pytest.raises(ModelError, match=message):
        verify(replace(made(), **change))


@pytest.mark.parametrize(
    ("declared", "message"),
    [
        (("Grip on ice",), "the description 'Grip on ice' has to begin in lower case"),
        (("Fun",), "the description 'Fun' has to begin"),
        (("grip", "1", 1.0, 1.0), "the start 0 is not within its bounds, 1 to 1"),
        (("grip", "1", -1.0, 1.0, 0.0, 9.0), "the start 9 is not within its bounds, -1 to 1"),
        (("Fy at rest", "1", -1.0, 1.0), ""),
        (("MF5.2: grip", "1", -1.0), ""),
    ],
)
def test_a_wrong_coefficient_is_named(made, declared, message):
    added = type("Added", (Section,), {"NEW": Coefficient(*declared)}, title="ADDED")
    wrong = replace(made(), sections=(*made().sections, added))
    with pytest.raises(ModelError, match=f"toy: coefficient NEW: {message}") if message else nullcontext():
        verify(wrong)


def test_names_and_numbers_are_taken_once(made):
    twin = replace(made("twin"), property_file=MODELS["mf61"].property_file)
    for wrong, message in (
        (made("mf61"), "is there twice"),
        (made("My tire"), "lower-case"),
        (twin, "FITTYP 6[01] is mf61's"),
    ):
        with pytest.raises(ModelError, match=message):
            register(wrong, dict(MODELS))


def test_every_code_agrees_and_differentiates(tire):
    rows = np.array([[0.05, -0.1, 0.0], [0.1, 0.02, -0.2], [900.0, 1300.0, 0.0]])
    parameters = tire.parameters()
    results = {language: code_for(tire.symbolic_model, language) for language in ("numpy", "c", "casadi", "batch")}
    for code in results.values():
        np.testing.assert_allclose(
            code.forces(rows, parameters), results["casadi"].forces(rows, parameters), rtol=1e-12
        )
        for routine in ("jacobian_inputs", "jacobian_parameters"):
            expected = getattr(results["casadi"], routine)(rows, parameters)
            np.testing.assert_allclose(getattr(code, routine)(rows, parameters), expected, rtol=1e-9, atol=1e-9)


def test_a_property_file_of_its_own_format_survives_a_round_trip(tire, tmp_path):
    tire.save(tmp_path / "toy.tir")
    text = (tmp_path / "toy.tir").read_text(encoding="utf-8")
    assert "PROPERTY_FILE_FORMAT = 'TOY'" in text
    assert "USE_MODE = 2" in text
    assert "FITTYP" not in text
    again = read_tir(tmp_path / "toy.tir")
    assert again == replace(tire.in_signs("iso"), name=again.name)
    (tmp_path / "field.tir").write_text(text[: text.index("$ What follows")], encoding="utf-8")
    assert read_tir(tmp_path / "field.tir").model == "toy"


def test_a_property_file_declares_how_its_units_apply(made, monkeypatch, tmp_path):
    file = PropertyFile(formats=("ANGLED",), aliases={"TRAIL": "ARM"}, per_angle=True, in_si=("TRAIL",))
    monkeypatch.setitem(MODELS, "angled", replace(made("angled"), property_file=file))
    text = "[UNITS]\nLENGTH = 'mm'\nANGLE = 'degree'\n[MODEL]\nPROPERTY_FILE_FORMAT = 'ANGLED'\n[PARAMETER]\n"
    text += "UNLOADED_RADIUS = 300\nFNOMIN = 1000\nCSIDE = 314.159\n"
    for line in ("TRAIL = 0.02", "ARM = 20"):
        (tmp_path / "t.tir").write_text(text + line, encoding="utf-8")
        with pytest.warns(TirefmuWarning, match="UMAX = 1"):
            values = read_tir(tmp_path / "t.tir").values
        assert values["UNLOADED_RADIUS"] == pytest.approx(0.3)
        assert values["ARM"] == pytest.approx(0.02)
        assert values["CSIDE"] == pytest.approx(314.159 * 180 / np.pi)


def test_a_format_without_a_nominal_load_assumes_one(made, monkeypatch, tmp_path):
    model = made()
    monkeypatch.setitem(MODELS, "toy", model)
    monkeypatch.setattr(model.coefficients["FNOMIN"], "assumed", 1500.0)
    text = "[MODEL]\nPROPERTY_FILE_FORMAT = 'TOY'\n[DIMENSION]\nUNLOADED_RADIUS = 0.3\n"
    (tmp_path / "t.tir").write_text(text, encoding="utf-8")
    with pytest.warns(TirefmuWarning, match="UMAX = 1"):
        read = read_tir(tmp_path / "t.tir")
    assert read.values["FNOMIN"] == 1500.0
    assert "FNOMIN" in not_given(read)
    read.save(tmp_path / "t.tir")
    assert read_tir(tmp_path / "t.tir") == read
    assert "FNOMIN" in not_given(read_tir(tmp_path / "t.tir"))


@pytest.mark.parametrize("start", [None, "features"])
def test_a_fit_finds_it_in_adapted_sae_and_saves_it_in_iso(tire, tmp_path, start):
    recording = Recording(bench(tire), "adapted-sae", "bench.csv")
    result = fit([recording], "toy", nominal={"Fz0": 1000.0, "R0": 0.3}, start=start, screening=False)
    assert result.ok
    result.tire.save(tmp_path / "toy.tir")
    for name in ("UMAX", "USOFT", "CLONG"):
        assert read_tir(tmp_path / "toy.tir").values[name] == pytest.approx(VALUES[name], rel=0.02)
    assert read_tir(tmp_path / "toy.tir").values["CSIDE"] == pytest.approx(-VALUES["CSIDE"], rel=0.02)


def test_its_recipe_is_in_its_folder(made, monkeypatch, tmp_path):
    (tmp_path / "toy_folder").mkdir()
    (tmp_path / "toy_folder" / "__init__.py").write_text("", encoding="utf-8")
    stages = 'name = "short"\n[[stage]]\nname = "all"\nsections = ["PARAMETER"]\n'
    (tmp_path / "toy_folder" / "short.toml").write_text(stages, encoding="utf-8")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setitem(MODELS, "toy", made(folder="toy_folder", recipes=("short",)))
    assert [stage.name for stage in load_recipe(None, "toy").stages] == ["all"]
    assert load_recipe("joint", "toy").name == "joint"


@pytest.mark.parametrize("inputs", ["slip", "wheel"])
def test_its_fmu_is_the_tire(tire, tmp_path, inputs):
    fmu = export(tire, tmp_path / "toy.fmu", inputs=inputs)
    if inputs == "slip":
        result = check(fmu, bench(tire).assign(gamma=0.0), signs="adapted-sae")
        assert all(channel.r2 > 0.999 for channel in result.channels)


@pytest.mark.slow
def test_a_diagnosis_identifies_the_missing_effect(tire):
    nominal = {"Fz0": 1000.0, "R0": 0.3, "p0": 2e5}
    result = diagnose(bench(tire, 1200), signs="adapted-sae", model="toy", nominal=nominal)
    assert [effect.effect for effect in result.found] == ["softening"]
    assert result.found[0].coefficients["USOFT"].value == pytest.approx(VALUES["USOFT"], rel=0.1)


#: The built-in demonstration uses one tire.
OF_ONE_MODEL = {"commands/demo.py"}


def written(path):
    """Return the texts in the code of a file, without docstrings."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    plain = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
    return {node.value for node in ast.walk(tree) if isinstance(node, ast.Constant) and id(node) not in plain}


def test_no_other_package_names_a_model_or_its_coefficients():
    # Names common to every model or every property file belong to no model.
    shared = {"FNOMIN", "UNLOADED_RADIUS", "NOMPRES", "INFLPRES", "LONGVL", "WIDTH", "RIM_RADIUS", "VERTICAL_STIFFNESS"}
    names = {
        name for model in MODELS.values() for name, declaration in model.coefficients.items() if declaration.fitted
    } | set(MODELS)
    names |= {"SIGX", "SIGY", "SIGC", "SIGK", "VXLOW"}
    named = {}
    for folder in ("tires", "measurements", "numerics", "fitting", "fmu", "diagnosis", "drawing", "commands"):
        for path in (ROOT / folder).rglob("*.py"):
            name = path.relative_to(ROOT).as_posix()
            texts = {text for text in written(path) if isinstance(text, str)} & (names - shared)
            if texts and name not in OF_ONE_MODEL:
                named[name] = texts
    assert named == {}
