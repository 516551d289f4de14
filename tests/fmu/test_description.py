"""Contents of modelDescription.xml."""

from __future__ import annotations

import xml.etree.ElementTree as ET
from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from fmpy import read_model_description, simulate_fmu
from fmpy.validation import validate_fmu
from hypothesis import given
from hypothesis import strategies as st

from tirefmu.fmu.description.interface import INPUTS
from tirefmu.fmu.description.model_description import Header, model_description
from tirefmu.fmu.description.units import FACTORS, base_unit
from tirefmu.fmu.description.variables import TIME, direct_feedthrough, variables
from tirefmu.fmu.packaging.export import contents
from tirefmu.tires import published

from ..relatives import slow_but
from .conftest import OK, TIRES


@pytest.fixture(
    scope="module",
    params=[pytest.param((name, fmi), id=f"{name}-fmi{fmi}", marks=[pytest.mark.slow] * (fmi == 2 and name != "first"))
            for name, fmi in product(TIRES, (2, 3))],
)  # fmt: skip
def described(request, fmus, tires):
    """Return tire and description as fmpy reads it, schema and all."""
    return tires[request.param[0]], read_model_description(str(fmus[request.param]), validate=True)


@pytest.mark.parametrize(
    ("name", "inputs"),
    slow_but(
        [("first", "slip"), ("rolling", "hub")],
        [*((name, "slip") for name in ("first", "mf62", "rolling")),
         ("rolling", "wheel"), ("rolling", "hub"), ("first", "hub-torque")],
    ),
)  # fmt: skip
def test_fmpy_reports_no_problem(fmus, name, fmi, inputs):
    key = (name, fmi) if inputs == "slip" else (name, fmi, inputs)
    assert validate_fmu(str(fmus[key])) == []


def test_start_values_are_the_tire_to_the_last_bit(described):
    tire, description = described
    parameters = [v for v in description.modelVariables if v.causality == "parameter"]
    reported = dict(zip(tire.symbolic_model.parameters, tire.parameters().tolist(), strict=True))
    assert reported.pop("SIGNS", 0.0) == 0.0  # the sign convention of the FMU is fixed
    assert {v.name: float(v.start) for v in parameters} == reported
    assert {v.variability for v in parameters} == {"tunable"}


def test_limits_contain_the_start_values(described):
    _, description = described
    for variable in description.modelVariables:
        if variable.causality == "parameter":
            low = -np.inf if variable.min is None else float(variable.min)
            high = np.inf if variable.max is None else float(variable.max)
            assert low <= float(variable.start) <= high, variable.name


def test_limits_are_mirrored_with_the_signs():
    tire = published("trento_hoosier")
    listed = {variable.name: variable for variable in variables(tire.in_signs("iso"))}
    mirrored = [c for c in tire.symbolic_model.coefficients.values() if c.flips and c.lower != -c.upper]
    inside = [c for c in mirrored if c.lower <= tire.values[c.name] <= c.upper and np.isfinite(c.upper)]
    assert inside
    for declared in inside:
        assert (listed[declared.name].lower, listed[declared.name].upper) == (-declared.upper, -declared.lower)


def test_names_and_units(described):
    tire, description = described
    by_cause = {
        cause: [v.name for v in description.modelVariables if v.causality == cause]
        for cause in ("input", "output", "local")
    }
    turning = "turn_slip" in tire.has
    radii = [] if tire.model == "mf96" else ["R_e", "R_l"]
    states = ["kappa_lagged", "tan_alpha_lagged"]
    assert by_cause == {
        "input": [key for key in tire.inputs if key != "phit" or turning],
        "output": [*tire.outputs, "friction_use", *radii],
        "local": [*states, *(f"der({state})" for state in states), "alpha_lagged"] if tire.lags else [],
    }
    units = {v.name: v.unit for v in description.modelVariables}
    for item in (*tire.symbolic_model.inputs, *tire.symbolic_model.outputs, *tire.symbolic_model.coefficients.values()):
        assert units.get(item.name, item.unit) == item.unit
    assert all(v.description for v in description.modelVariables)
    assert {u.name for u in description.unitDefinitions} == set(units.values())


def test_states(described):
    tire, description = described
    states = ["kappa_lagged", "tan_alpha_lagged"] if tire.lags else []
    assert [v.derivative.name for v in description.modelVariables if v.derivative is not None] == states
    assert [unknown.variable.name for unknown in description.derivatives] == [f"der({state})" for state in states]
    assert description.modelExchange is not None
    assert description.numberOfContinuousStates == len(states)
    assert description.numberOfEventIndicators == 0


def test_only_fmi_3_lists_the_time(described):
    _, description = described
    independent = [v.name for v in description.modelVariables if v.causality == "independent"]
    assert independent == (["time"] if description.fmiVersion == "3.0" else [])
    assert "time" in independent or all(v.name != "time" for v in description.modelVariables)


def test_value_references_are_the_same_in_both_versions(fmus):
    two, three = (
        {v.name: v.valueReference for v in read_model_description(str(fmus["first", fmi])).modelVariables}
        for fmi in (2, 3)
    )
    assert sorted(three.values()) == list(range(len(three)))
    assert three == {"time": 0, **two}


def test_outputs_depend_on_the_inputs_that_reach_them(described):
    tire, description = described
    reached = direct_feedthrough(tire.symbolic_model)
    shown = {v.name for v in description.modelVariables if v.causality == "input"}
    for unknown in description.outputs:
        if unknown.variable.name in reached:
            named = {variable.name for variable in unknown.dependencies}
            assert named & shown == reached[unknown.variable.name] & shown


@pytest.mark.parametrize("name", ["first", "mf52", "mf61", "mf62"])
def test_an_input_that_is_not_listed_has_no_influence(name, tires):
    tire = tires[name]
    model = tire.symbolic_model
    generator = np.random.default_rng(5)
    points = {q.name: generator.uniform(0.5, 1.0, 50) * q.typical for q in model.inputs}
    moved = {key: value * 1.1 for key, value in points.items()}
    for output, reached in direct_feedthrough(model).items():
        for key in points:
            difference = tire.forces(**points | {key: moved[key]})[output] - tire.forces(**points)[output]
            felt = bool(np.any(difference != 0.0))
            assert felt <= (key in reached), (output, key)
            assert felt or key not in reached or name != "first", (output, key)


def test_characters_that_xml_cannot_contain_are_omitted(fmi):
    text = model_description(fmi, Header("a\x00\x07b\ud800", "a", "\ufffe", ("a.c",)), [TIME], "{1}")
    assert ET.fromstring(text).get("modelName") == "a\ufffd\ufffdb\ufffd"


def test_states_that_a_tire_was_converted():
    tire = published("trento_hoosier")
    assert tire.signs == "adapted-sae"
    for written, stated in ((tire, True), (tire.in_signs("iso"), False)):
        text = contents(written, 3, "t")["modelDescription.xml"].decode()
        assert ("converted from adapted-sae signs" in text) == stated


def test_token_ties_tire_code_and_description(tires):
    def token(tire, fmi=3, identifier="t"):
        root = ET.fromstring(contents(tire, fmi, identifier)["modelDescription.xml"])
        return root.get("instantiationToken") or root.get("guid")

    tire = tires["first"]
    nudged = np.nextafter(tire.values["PDY1"], np.inf)
    others = [
        token(replace(tire, values={**tire.values, "PDY1": nudged})),
        token(tire, fmi=2),
        token(tire, identifier="u"),
    ]
    assert token(tire) == token(tire)
    assert len({token(tire), *others}) == 4


# ------------------------------------------------------------------ Units in SI base exponents


@pytest.mark.parametrize(
    ("unit", "expected"),
    [
        ("1", {}),
        ("N", {"kg": 1, "m": 1, "s": -2}),
        ("N m", {"kg": 1, "m": 2, "s": -2}),
        ("N/rad", {"kg": 1, "m": 1, "s": -2, "rad": -1}),
        ("1/rad^2", {"rad": -2}),
        ("Pa", {"kg": 1, "m": -1, "s": -2}),
        ("1/Pa", {"kg": -1, "m": 1, "s": 2}),
        ("m/s", {"m": 1, "s": -1}),
        ("N/m", {"kg": 1, "s": -2}),
        ("m/m", {}),
        ("deg C", {"K": 1, "offset": 273.15}),
    ],
)
def test_known_units(unit, expected):
    assert base_unit(unit) == expected


@given(st.sampled_from(sorted(FACTORS)), st.sampled_from(sorted(FACTORS)), st.integers(1, 4))
def test_a_product_divided_by_itself_is_one(a, b, power):
    product = f"{a}^{power} {b}"
    assert base_unit(f"{product}/{product}") == {}
    assert base_unit(f"1/{product}") == {name: -n for name, n in base_unit(product).items()}


KINDS = [("first", "slip"), ("rolling", "slip"), ("lagged", "slip"), *((("first", kind)) for kind in INPUTS[1:])]


@pytest.mark.parametrize(("name", "inputs"), KINDS)
@pytest.mark.parametrize("fmi", [2, 3])
def test_every_unknown_has_its_dependencies(tires, fmi, name, inputs):
    """At initialization, too: what changes an unknown there is listed."""
    root = ET.fromstring(contents(tires[name], fmi, "tire", inputs=inputs)["modelDescription.xml"])
    unknowns = root.findall("ModelStructure//*[@dependencies]")
    key = "index" if fmi == 2 else "valueReference"
    assert unknowns
    assert [e for e in root.iterfind("ModelStructure//*") if e.get(key) and e not in unknowns] == []


@pytest.mark.parametrize(("name", "inputs"), [(name, inputs) for name, inputs in KINDS if name != "lagged"])
def test_what_changes_an_unknown_at_initialization_is_listed(hosts, name, inputs):
    host = hosts(name, 3) if inputs == "slip" else hosts(name, 3, inputs)
    structure = host.slave.description
    listed = {
        unknown.variable.name: {variable.name for variable in unknown.dependencies}
        for unknown in structure.initialUnknowns
    }
    host.initialize()
    known = [v for v in structure.modelVariables if v.causality in ("input", "parameter") or v.initial == "exact"]
    before = host.get(*listed)
    missing = set()
    for variable in known:
        start = float(variable.start)
        for value in (start + 0.01 * (abs(start) or 0.1), start - 0.01 * (abs(start) or 0.1)):
            if host.set(**{variable.name: value}) == OK:
                changed = host.get(*listed) != before
                missing |= {(n, variable.name) for n, c in zip(listed, changed, strict=True) if c} - {
                    (n, cause) for n, causes in listed.items() for cause in causes
                }
        assert host.set(**{variable.name: start}) == OK
    assert missing == set()


def test_parameters_of_one_force_are_no_causes_of_another(fmus):
    description = read_model_description(str(fmus["first", 3]))
    causes = {u.variable.name: {v.name for v in u.dependencies} for u in description.initialUnknowns}
    assert "PDX1" in causes["Fx"]
    assert "PDX1" not in causes["Fy"]


@pytest.mark.parametrize(("inputs", "expected"), [("slip", None), *((kind, "1e-7") for kind in INPUTS[1:])])
@pytest.mark.parametrize("fmi", [2, 3])
def test_an_fmu_with_continuous_states_declares_the_tolerance_that_it_needs(tires, fmi, inputs, expected):
    root = ET.fromstring(contents(tires["first"], fmi, "tire", inputs=inputs)["modelDescription.xml"])
    assert root.find("DefaultExperiment").get("tolerance") == expected


@pytest.mark.parametrize("inputs", INPUTS[1:])
def test_the_declared_tolerance_is_small_enough(fmus, inputs):
    """Forces within 1e-4 of their largest one, against a solver at 1e-10."""
    path = fmus["first", 2, inputs]
    starts = {"T_drive": 100.0, "V_y": 1.0, "v_y": -1.0}
    description = read_model_description(str(path))
    given = {v.name: starts[v.name] for v in description.modelVariables if v.name in starts and v.causality == "input"}
    options = {"fmi_type": "ModelExchange", "stop_time": 0.3, "output": ["Fx", "Fy"], "start_values": given}
    coarse = simulate_fmu(str(path), **options)
    fine = simulate_fmu(str(path), relative_tolerance=1e-10, **options)
    for force in ("Fx", "Fy"):
        expected = np.interp(coarse["time"], fine["time"], fine[force])
        assert np.max(np.abs(coarse[force] - expected)) < 1e-4 * np.max(np.abs(fine[force]))
