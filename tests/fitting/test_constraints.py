"""The physical constraints: their grids, names, margins and selection."""

from __future__ import annotations

from dataclasses import replace
from math import inf

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tirefmu.boundary.errors import UnknownName
from tirefmu.commands.demo import bench_tire
from tirefmu.fitting.constraints import (
    TOLERANCE,
    Constraint,
    VerifiedConstraints,
    chosen_constraints,
    declared_constraints,
    grid,
    measured_values,
    operating_range,
)
from tirefmu.symbolic.contract import CONSTRAINT_KINDS, MEASURES
from tirefmu.symbolic.models import MODELS
from tirefmu.tires import Tire
from tirefmu.tires.code import code_for
from tirefmu.tires.evaluation import quantities

INPUTS = ("kappa", "alpha", "gamma", "Fz")
NOMINAL = {"kappa": 0.0, "alpha": 0.0, "gamma": 0.0, "Fz": 700.0}
ALL = [
    (model, output, c)
    for model in MODELS
    for output in declared_constraints(model)
    for c in declared_constraints(model)[output]
]


def label(case):
    return f"{case[0]}-{case[2].name}"


def interval(low, high):
    return st.tuples(st.floats(low, high), st.floats(low, high)).map(lambda pair: tuple(sorted(pair)))


RANGES = st.tuples(interval(-1, 1), interval(-0.5, 0.5), interval(-0.1, 0.1), interval(10, 5000)).map(
    lambda bounds: dict(zip(INPUTS, bounds, strict=True))
)


@given(ranges=RANGES, over=st.sets(st.sampled_from(INPUTS)), density=st.sampled_from([1, 4]))
def test_the_grid_has_the_ends_of_every_range_and_zero_slip(ranges, over, density):
    points = grid(Constraint("E_y", -inf, 1.0, tuple(over)), ranges, NOMINAL, density=density)
    assert points.shape[0] == 4
    for i, name in enumerate(INPUTS):
        if name not in over:
            assert set(points[i]) == {NOMINAL[name]}
            continue
        assert {*ranges[name]} <= set(points[i])
        if name in ("kappa", "alpha"):
            size = 0.02 * max(map(abs, ranges[name]))
            assert {-size, 0.0, size} <= set(points[i])
        else:
            assert points[i].min() == ranges[name][0]
            assert points[i].max() == ranges[name][1]
    # Every combination, once.
    assert points.shape[1] == np.prod([len(set(row)) for row in points])
    assert len(np.unique(points, axis=1).T) == points.shape[1]


@settings(max_examples=25)
@given(ranges=RANGES, over=st.sets(st.sampled_from(INPUTS), min_size=1))
def test_the_verification_grid_contains_the_imposed_one(ranges, over):
    constraint = Constraint("E_y", -inf, 1.0, tuple(over))
    imposed, verified = (grid(constraint, ranges, NOMINAL, density=density) for density in (1, 4))
    size = np.array([max(abs(v) for v in ranges[name]) for name in INPUTS])[:, None] + 1e-12
    for point in imposed.T:
        assert (np.abs(verified - point[:, None]) / size).max(axis=0).min() < 1e-9
    assert verified.shape[1] >= imposed.shape[1]


@pytest.mark.parametrize("case", ALL, ids=label)
def test_a_constraint_varies_every_input_of_its_quantity(case):
    """Inputs that are not in `varied` must have no influence, because the grid contains only one value of them."""
    model, _, constraint = case
    code, symbolic_model = code_for(model, "numpy"), MODELS[model]
    rng = np.random.default_rng(0)
    values = []
    for declaration in symbolic_model.coefficients.values():  # a tire with every effect
        bound = declaration.upper if rng.random() < 0.5 else declaration.lower
        values.append(declaration.generic + (0.1 * (bound - declaration.generic) if declaration.fitted else 0.0))
    parameters = np.array([*values, *(0.0 for _ in symbolic_model.options)])
    index = code.quantities_names.index(constraint.quantity)
    free = {
        "kappa": (-0.3, 0.3), "alpha": (-0.2, 0.2), "gamma": (-0.1, 0.1), "Fz": (500.0, 3000.0), "p": (1.8e5, 2.6e5),
        "V": (10.0, 30.0), "phit": (0.0, 0.0),
    }  # fmt: skip
    names = [quantity.name for quantity in symbolic_model.inputs]
    here = {name: rng.uniform(*free[name]) for name in names}
    moved = np.array(
        [np.full(50, here[name]) if name in constraint.varied else rng.uniform(*free[name], 50) for name in names]
    )
    values = code.quantities(moved, parameters)[index]
    np.testing.assert_allclose(values, values[0], rtol=1e-9)


@pytest.mark.parametrize("wrong", [{"kind": "friction_faling"}, {"measure": "grow"}])
def test_an_unknown_kind_or_measure_is_refused(wrong):
    (name,) = wrong.values()
    with pytest.raises(UnknownName, match=f"unknown .*{name}.*did you mean (friction_falling|growth)"):
        Constraint("mu_x", -inf, 0.0, ("Fz",), **wrong)


@pytest.mark.parametrize("measure", MEASURES)
def test_each_measure_is_said_in_words_of_its_own(measure):
    others = {Constraint("mu_x", -inf, 0.0, ("Fz",), measure=other).text for other in MEASURES if other != measure}
    assert Constraint("mu_x", -inf, 0.0, ("Fz",), measure=measure).text not in others


def test_distance_and_name():
    curvature, friction = Constraint("E_x", -inf, 1.0, ("Fz",)), Constraint("mu_x", 0.01, inf, ())
    assert (curvature.text, friction.text) == ("E_x <= 1", "mu_x > 0")
    np.testing.assert_allclose(curvature.distance(np.array([-3.0, 1.0, 1.5])), [4.0, 0.0, -0.5])
    np.testing.assert_allclose(friction.distance(np.array([1.01, 0.01, 0.0, np.nan])), [1.0, 0.0, -0.01, -inf])


@pytest.mark.parametrize("size", [0.1, 1.0, 5e4])
def test_a_constraint_within_the_solver_tolerance_is_satisfied(size):
    """The solver's variable is quantity / size, which may violate both bounds within the solver's tolerance."""
    constraint = Constraint("K_x", -2.0, 3.0, (), size=size)
    low, high = constraint.scaled_bounds
    assert low < high
    reached = size * np.array([low - TOLERANCE, high + TOLERANCE])
    assert constraint.distance(reached).min() >= -TOLERANCE * (1.0 + 1e-6)


def test_margins_are_distances_to_the_nearest_bound(known):
    """A margin is positive if the constraint is satisfied; E_x has an upper bound."""
    ranges = {"kappa": (-0.1, 0.1), "alpha": (-0.1, 0.1), "gamma": (0.0, 0.0), "Fz": (500.0, 900.0)}
    curvature = {"Fx": chosen_constraints("mf96", also=["curvature"])["Fx"]}
    for value, holds in ((-0.5, True), (1.5, False)):
        tire = replace(known, values={**known.values, "PEX1": value, "PEX2": 0.0, "PEX3": 0.0})
        margins = VerifiedConstraints(tire, curvature, ranges).margins(["Fx"], tire.parameters())
        (found,) = [each for each in margins if each.name == "curvature:E_x"]
        assert (found.margin > 0.0) == holds
        assert found.margin == pytest.approx(1.0 - found.worst, rel=1e-12)


def with_curvature(tire, first, second, third):
    """Return a tire whose E_x is a parabola of the load."""
    return replace(tire, values={**tire.values, "PEX1": first, "PEX2": second, "PEX3": third, "PEX4": 0.0})


@pytest.mark.parametrize("peak", [0.011, 0.2, 0.29])
def test_a_margin_is_smallest_between_the_grid_points(known, peak):
    """The largest E_x of a parabola of the load, at dfz = peak, is known exactly."""
    ranges = {"kappa": (-0.1, 0.1), "alpha": (-0.1, 0.1), "gamma": (0.0, 0.0), "Fz": (500.0, 930.0)}
    tire = with_curvature(known, 0.9 - peak**2, 2.0 * peak, -1.0)
    verified = VerifiedConstraints(tire, {"Fx": [Constraint("E_x", -inf, 1.0, ("Fz", "kappa"))]}, ranges)
    (margin,) = verified.margins(["Fx"], tire.parameters())
    assert margin.worst == pytest.approx(0.9, abs=1e-12)
    assert margin.at["Fz"] == pytest.approx(700.0 * (1.0 + peak), rel=1e-6)


def test_a_fit_satisfies_constraints_between_the_grid_points(known, make):
    """The data have E_x up to 1.01, at a load between those of the grid."""
    tire = with_curvature(known, 0.97, 0.4, -1.0)
    recording = make.bench(tire, loads=(220.0, 500.0, 840.0, 1120.0), cambers=(0.0,))
    table = recording.table.drop(columns=["Fy", "Mz"])
    effects = ["load_friction", "load_stiffness", "load_curvature"]
    result = make.fit(table[np.abs(table["alpha"]) < 1e-9], effects=effects, signs=recording.signs)
    loads = np.linspace(table["Fz"].abs().min(), table["Fz"].abs().max(), 100_000)
    curvature = code_for("mf96", "numpy")
    inputs = np.zeros((4, len(loads)))
    inputs[known.inputs.index("Fz")], inputs[known.inputs.index("kappa")] = loads, 0.1
    scanned = curvature.quantities(inputs, result.tire.in_signs("adapted-sae").parameters())
    assert result.status == "converged"
    assert 1.0 - 1e-3 < scanned[curvature.quantities_names.index("E_x")].max() <= 1.0 + TOLERANCE


def test_every_constraint_has_a_unique_name():
    for model in MODELS:
        declared = declared_constraints(model)
        every = [each for own in declared.values() for each in own]
        assert len({each.name for each in every}) == len(every)
        assert len({each.text for each in every}) == len(every)
        assert {each.kind for each in every} <= set(CONSTRAINT_KINDS)
        assert {each.quantity for each in every} <= set(code_for(model, "numpy").quantities_names)
        assert declared.keys() <= {quantity.name for quantity in MODELS[model].outputs}
        assert all(each.lower < each.upper for each in every)
        default, requested = (
            {each.name for own in chosen_constraints(model, also=also).values() for each in own}
            for also in ([], ["all"])
        )
        assert requested == {each.name for each in every}
        assert requested - default == {each.name for each in every if each.on_request}


@pytest.mark.parametrize(("without", "removed"), [
    (["curvature:E_y"], {"curvature:E_y"}),
    (["friction_falling"], {"friction_falling:mu_x", "friction_falling:mu_y"}),
    (["stiffness_saturating", "signs:C_x"], {"stiffness_saturating:K_yalpha", "signs:C_x"}),
])  # fmt: skip
def test_constraints_are_selected_by_name(without, removed):
    default, rest = (
        {each.name for own in chosen_constraints("mf61", without=names).values() for each in own}
        for names in ([], without)
    )
    assert default - rest == removed
    assert rest < default


def test_an_unknown_constraint_is_rejected():
    with pytest.raises(UnknownName, match="constraint of mf61 'friction_faling': did you mean friction_falling"):
        chosen_constraints("mf61", without=["friction_faling"])
    with pytest.raises(UnknownName, match="curvature:E_q"):
        chosen_constraints("mf61", also=["curvature:E_q"])


def test_a_published_tire_satisfies_the_default_constraints():
    """Default constraints must not affect the fit of a valid tire; those that it violates are on request only."""
    tire = bench_tire().in_signs("adapted-sae")
    ranges = {"kappa": (-0.2, 0.2), "alpha": (-0.2, 0.2), "gamma": (0.0, 0.07), "Fz": (220.0, 1120.0)}
    violated = set()
    for own in declared_constraints(tire.model).values():
        for each in own:
            values = measured_values(
                tire.symbolic_model, each, grid(each, ranges, NOMINAL, density=4), tire.parameters()
            )
            violated |= {each.kind} if each.distance(values).min() < 0 else set()
    assert violated == {"extrapolation"}


def test_an_extrapolation_widens_only_load_and_slip():
    ranges = {"kappa": (-0.2, 0.1), "alpha": (-0.1, 0.2), "gamma": (0.0, 0.05), "Fz": (300.0, 1200.0), "p": (7e4, 1e5)}
    far = Constraint("G_xa", 0.01, inf, tuple(ranges), kind="extrapolation")
    points = grid(far, ranges, {}, density=4)
    expected = [(-0.3, 0.15), (-0.15, 0.3), (0.0, 0.05), (200.0, 1800.0), (7e4, 1e5)]
    np.testing.assert_allclose([(row.min(), row.max()) for row in points], expected)


def test_operating_range(known, make):
    table = make.sideways(known).table.drop(columns="kappa")
    ranges = operating_range(table, known)
    assert list(ranges) == list(known.inputs)
    assert ranges["kappa"] == (0.0, 0.0)
    assert ranges["Fz"] == (220.0, 1120.0)
    assert ranges["alpha"] == (table["alpha"].min(), table["alpha"].max())


@pytest.mark.parametrize("model", [model for model in MODELS if "RHX1" in MODELS[model].coefficients])
def test_weighting_functions_are_bounded_on_both_sides(model):
    values = {"FNOMIN": 3000.0, "UNLOADED_RADIUS": 0.3, "RBX1": 20.0, "RCX1": 1.0, "RHX1": 0.05}
    bounded = [c for c in declared_constraints(model)["Fx"] if c.quantity == "G_xa" and c.kind == "signs"]
    assert [c.text for c in bounded] == ["0.01 <= G_xa <= 1.05"]
    for shift, within in ((0.0, True), (0.005, True), (0.05, False)):
        tire = Tire(model, {**values, "RHX1": shift}, signs="adapted-sae")
        shares = quantities(tire, {"alpha": np.linspace(-0.2, 0.2, 41)})["G_xa"]
        assert bool((bounded[0].distance(shares) >= 0.0).all()) == within


def test_the_text_of_a_change_with_load_follows_from_its_bounds():
    falling = Constraint("mu_y", -inf, 0.0, ("Fz",), kind="friction_falling", measure="growth")
    assert falling.text == "mu_y falls with load"
    assert replace(falling, quantity="D_t", lower=0.0, upper=inf).text == "D_t grows with load"
