"""Figures of the data and the tire in the requested sign convention; slopes read from the data are correct."""

from dataclasses import replace
from math import radians

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tirefmu.boundary.errors import DataError, FitError
from tirefmu.fitting import draw_figures
from tirefmu.fitting.checks import compare
from tirefmu.fitting.reporting import (
    data_text,
    figures_of,
    friction_over_load,
    largest_friction,
    overview,
    stiffness_over_load,
    weighting_figure,
)
from tirefmu.measurements import (
    Noise,
    Recording,
    VirtualBench,
    alpha_sweeps,
    concatenate,
    kappa_sweeps,
    small_tire_program,
    trento_program,
)
from tirefmu.numerics import read_slope
from tirefmu.tires import SIGNS, Tire, published
from tirefmu.tires.code.modules import numpy_routine

TIRE = published("trento_hoosier")
RESIDUALS = ["residuals_over_inputs", "residuals"]
ALL = ["pure_Fx", "pure_Fy", "pure_Mz", "combined", "weighting", "stiffness", "friction", *RESIDUALS]
LATERAL = alpha_sweeps([220.0, 700.0, 1120.0], [0.0, radians(2.0)], sample_rate=50.0)
DRIVEN = kappa_sweeps([220.0, 700.0], [0.0, radians(6.0)], [0.0, radians(2.0)], sample_rate=50.0)


def run(program, noise=None, seed=1):
    return VirtualBench(TIRE, Noise.none() if noise is None else noise, seed=seed).run(program)


def per_load(comparison, channel, slip):
    family = comparison.pure(channel, slip)[0]
    assert family.by == "Fz"
    return family


@pytest.fixture(scope="module")
def bench():
    """Return a noisy recording of all channels."""
    return run(concatenate([LATERAL, DRIVEN]), Noise())


@pytest.fixture(scope="module")
def trento():
    """Return the report's program without noise."""
    return compare(TIRE, [run(trento_program())])


@pytest.fixture
def unrendered(monkeypatch):
    """Do not render the figures: which are drawn is the same."""
    monkeypatch.setattr("tirefmu.drawing.picture.png", lambda figure, dpi: b"")


@pytest.mark.usefixtures("drawn_figures")
def test_every_figure_is_complete(bench, tmp_path):
    some = replace(bench, table=bench.table.iloc[::5])
    drawn = draw_figures(TIRE, [some], tmp_path, prefix="fit_", truth=TIRE)
    assert [path.name for path in drawn] == [f"fit_{name}.png" for name in ALL]
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(path.name for path in drawn)
    assert all(path.read_bytes().endswith(b"IEND\xaeB`\x82") for path in drawn)


@pytest.mark.parametrize(
    ("program", "drawn"),
    [
        (LATERAL, ["pure_Fy", "pure_Mz", "stiffness", "friction", *RESIDUALS]),
        (kappa_sweeps([220.0, 700.0], sample_rate=50.0), ["pure_Fx", "stiffness", "friction", *RESIDUALS]),
        (kappa_sweeps([220.0], [radians(6.0)], sample_rate=50.0), ["combined", "weighting", *RESIDUALS]),
    ],
    ids=["cornering only", "driving only", "combined only"],
)
def test_figures_without_data_are_omitted(program, drawn, tmp_path, unrendered):
    paths = draw_figures(TIRE, [run(program)], tmp_path)
    assert [path.stem for path in paths] == drawn


def test_a_channel_that_was_not_measured_is_omitted(bench, tmp_path, unrendered):
    blind = replace(bench, table=bench.table.drop(columns="Mz").assign(Fy=np.nan))
    assert [path.stem for path in draw_figures(TIRE, [blind], tmp_path)] == [
        "pure_Fx", "combined", "weighting", "stiffness", "friction", *RESIDUALS,
    ]  # fmt: skip


def test_invalid_input_writes_no_file(bench, tmp_path, unrendered):
    blocked = tmp_path / "file"
    blocked.write_text("mine")
    with pytest.raises(FitError, match="figures cannot be written"):
        draw_figures(TIRE, [bench], blocked)
    with pytest.raises(FitError, match="no recording"):
        draw_figures(TIRE, [], tmp_path / "new")
    with pytest.raises(DataError, match="no measured output"):
        draw_figures(TIRE, [bench, Recording(bench.table[["alpha", "Fz"]], "iso", "a.csv")], tmp_path / "new")
    assert [path.name for path in tmp_path.iterdir()] == ["file"]
    assert blocked.read_text() == "mine"


def test_levels_of_the_report_are_found(trento):
    lateral, drive = trento.pure("Fy", "alpha"), trento.pure("Fx", "kappa")
    assert [group.level for group in lateral[0].groups] == pytest.approx([220, 440, 700, 900, 1120])
    assert np.degrees([group.level for group in lateral[1].groups]) == pytest.approx([0, 1, 2, 3, 4], abs=0.01)
    assert lateral[1].held["Fz"] == pytest.approx(TIRE.values["FNOMIN"])
    assert [group.level for group in drive[0].groups] == pytest.approx([220, 700, 900, 1120])
    combined = {(family.channel, family.by): family for family in trento.combined()}
    assert set(combined) == {("Fx", "alpha"), ("Fy", "alpha"), ("Fy", "Fz"), ("Fy", "gamma")}
    angles = [group.level for group in combined["Fx", "alpha"].groups]
    assert np.degrees(angles) == pytest.approx([0, 3, 6], abs=0.01)
    assert combined["Fy", "Fz"].held["alpha"] == pytest.approx(radians(6.0))
    assert combined["Fy", "gamma"].held["alpha"] == pytest.approx(radians(3.0))  # figure 17


def test_weighting_functions_are_drawn_over_both_slips(trento):
    """Figures 13 and 15. Over each slip the other one has several levels; without side slip Fx is not reduced."""
    figure = weighting_figure(trento)
    drawn = {}
    for panel in figure.panels:
        slip, symbol = (text.split(" (")[0] for text in (panel.x, panel.y))
        drawn[symbol, slip] = [series.points.T for series in panel.series]
    gxa, gyk, kappa, alpha = "Gxα", "Gyκ", "κ", "α"
    assert {key: len(lines) for key, lines in drawn.items()} == {
        (gxa, kappa): 3, (gxa, alpha): 5, (gyk, kappa): 3, (gyk, alpha): 5,
    }  # fmt: skip
    for lines in (drawn[gxa, alpha], drawn[gyk, alpha]):
        assert all((line[:, 1] > 0.0).all() for line in lines)
        assert np.ptp([line[:, 0].max() for line in lines]) == 0.0
    for line in drawn[gxa, alpha]:
        assert np.interp(0.0, *line.T) == pytest.approx(1.0, abs=0.02)
        assert line[np.argmax(line[:, 0]), 1] < 0.99


def test_steady_points_in_one_segment_are_found():
    comparison = compare(TIRE, [run(small_tire_program())])
    assert [group.level for group in per_load(comparison, "Fy", "alpha").groups] == [60.0, 110.0, 160.0]
    (angles,) = (f.groups for f in comparison.combined() if (f.channel, f.by) == ("Fx", "alpha"))
    assert sorted(np.degrees([group.level for group in angles])) == pytest.approx(range(-20, 21, 5))
    assert {len(group.rows) for group in angles} == {11}


def test_one_segment_without_a_clock_still_shows_its_levels():
    recording = run(concatenate([LATERAL, DRIVEN]))
    comparison = compare(TIRE, [replace(recording, table=recording.table.drop(columns="t"))])
    (angles,) = (f.groups for f in comparison.combined() if (f.channel, f.by) == ("Fx", "alpha"))
    assert np.degrees([group.level for group in angles]) == pytest.approx([0.0, 6.0], abs=0.01)


def test_a_panel_has_one_pressure(bench):
    """The larger recording gives the pressure of the panels by load; both pressures have a panel of their own."""
    soft, hard = (replace(bench, table=bench.table.assign(p=p)) for p in (55e3, 83e3))
    some = replace(soft, table=soft.table[:2000])
    comparison = compare(TIRE, [some, hard])
    families = {family.by: family for family in comparison.pure("Fy", "alpha")}
    assert families["Fz"].held["p"] == families["gamma"].held["p"] == 83e3
    for group in families["Fz"].groups + families["gamma"].groups:
        assert set(group.rows["p"]) == {83e3}
    assert [group.level for group in families["p"].groups] == [55e3, 83e3]


def test_groups_are_disjoint_and_have_equal_conditions(bench):
    comparison = compare(TIRE, [bench])
    families = comparison.pure("Fy", "alpha") + comparison.pure("Fx", "kappa") + comparison.combined()
    assert len(families) == 8
    for family in families:
        labels = np.concatenate([group.rows.index for group in family.groups])
        assert len(labels) == len(set(labels))
        for group in family.groups:
            for name, level in {**family.held, family.by: group.level}.items():
                assert (abs(group.rows[name] - level) <= comparison.tolerance(name)).all()
    rolling = comparison.pure("Fy", "alpha")[0].groups[0].rows["kappa"]
    assert (abs(rolling) <= comparison.tolerance("kappa")).all()


@pytest.mark.parametrize("signs", SIGNS)
def test_the_convention_of_the_data_changes_signs_only(bench, signs):
    native, other = compare(TIRE, [bench]), compare(TIRE, [bench.with_signs(signs)])
    assert other.signs == signs
    for channel, slip in (("Fy", "alpha"), ("Mz", "alpha"), ("Fx", "kappa")):
        one, two = per_load(native, channel, slip), per_load(other, channel, slip)
        assert [abs(g.level) for g in two.groups] == [abs(g.level) for g in one.groups]
        assert np.array(other.slopes_at_zero(two)) == pytest.approx(np.array(native.slopes_at_zero(one)))
    for channel in native.channels:
        there, here = (c.table[f"{channel}_fit"] - c.table[channel] for c in (native, other))
        assert abs(here).to_numpy() == pytest.approx(abs(there).to_numpy(), abs=1e-9)


def test_recordings_of_different_conventions_are_compared_in_iso(bench):
    sae = bench.with_signs("sae")
    comparison = compare(TIRE, [bench, sae])
    assert comparison.signs == "iso"
    half = comparison.table[["Fy", "Fy_fit", "alpha"]].to_numpy()
    assert half[: len(bench)] == pytest.approx(half[len(bench) :])


def test_absent_inputs_take_the_tires_nominal_value(bench):
    upright = replace(bench.with_signs("sae"), table=bench.with_signs("sae").table.drop(columns=["Fz", "gamma"]))
    comparison = compare(TIRE, [upright])
    assert (comparison.table["Fz"] == -TIRE.values["FNOMIN"]).all()
    assert (comparison.table["gamma"] == 0.0).all()


def test_a_curve_goes_through_noiseless_data(trento):
    for channel, slip in (("Fy", "alpha"), ("Mz", "alpha"), ("Fx", "kappa")):
        for group in per_load(trento, channel, slip).groups:
            rows, curve = group.rows.sort_values(slip), trento.curve(group, slip)
            there = np.interp(rows[slip], curve[slip], curve[channel])
            peak = abs(rows[channel]).max()
            assert there == pytest.approx(rows[channel].to_numpy(), abs=2e-3 * peak)


@pytest.mark.parametrize(("channel", "slip", "row", "column"), [("Fx", "kappa", 0, 0), ("Fy", "alpha", 1, 1)])
def test_slopes_read_from_noiseless_data_are_the_derivatives(trento, channel, slip, row, column):
    derivatives = numpy_routine(TIRE.symbolic_model, "jacobian_inputs")
    family = per_load(trento, channel, slip)
    read = trento.slopes_at_zero(family)
    assert len(read) == len(family.groups)
    for load, slope in read:
        true = derivatives((0.0, 0.0, 0.0, load), TIRE.parameters())[row][column]
        assert slope == pytest.approx(abs(true), rel=0.02)


@given(st.lists(st.floats(-10.0, 10.0), min_size=4, max_size=4), st.floats(0.01, 10.0))
def test_the_slope_of_a_cubic_is_read_exactly(coefficients, window):
    slip = np.linspace(-2.0, 2.0, 301) * window
    assert read_slope(slip, np.polyval(coefficients, slip), window).value == pytest.approx(
        coefficients[2], rel=1e-6, abs=1e-6 * (1.0 + max(map(abs, coefficients)) * (1.0 + window) ** 3 / window)
    )


@given(st.lists(st.integers(0, 200), min_size=1, max_size=15, unique=True))
def test_outliers_hardly_change_the_slope(spoiled):
    rng = np.random.default_rng(0)
    slip = np.linspace(-1.0, 1.0, 201)
    force = 100.0 * slip + rng.normal(0.0, 1.0, len(slip))
    clean = read_slope(slip, force, 1.0).value
    force[spoiled] += 1000.0
    assert read_slope(slip, force, 1.0).value == pytest.approx(clean, abs=5.0)


@pytest.mark.parametrize("model", ["mf96", "mf61"])
def test_slopes_over_slip_are_drawn_for_every_model(model):
    """At zero slip they are the slip stiffness, also of a model that has no formula for the slope."""
    tire = TIRE if model == "mf96" else Tire(model, {"FNOMIN": 700.0, "UNLOADED_RADIUS": 0.23})
    loads = [400.0, 700.0]
    program = concatenate([alpha_sweeps(loads, sample_rate=10.0), kappa_sweeps(loads, [0.0], sample_rate=10.0)])
    comparison = compare(tire, [VirtualBench(tire, Noise.none()).run(program)])
    over_load, over_slip, *lateral = stiffness_over_load(comparison, None, None).panels
    for stiffness, slopes in ((over_load, over_slip), lateral):
        measured, values = next(series.points for series in stiffness.series if series.label == "tire")
        for series in slopes.series:
            x, y = series.points
            load = float(series.label.removesuffix(" N"))
            inside = np.isfinite(values)
            expected = np.interp(load, measured[inside], values[inside])
            assert np.interp(0.0, x, y) == pytest.approx(expected, rel=0.02)


@pytest.mark.parametrize("drawn", ["stiffness", "friction"])
def test_loads_beyond_the_measured_ones_are_marked(trento, drawn):
    figure = stiffness_over_load(trento, None, None) if drawn == "stiffness" else friction_over_load(trento, None)
    over_load = [panel for panel in figure.panels if panel.x.startswith("load")]
    assert len(over_load) == 2
    for panel, (channel, slip) in zip(over_load, (("Fx", "kappa"), ("Fy", "alpha")), strict=True):
        measured = [group.level for group in per_load(trento, channel, slip).groups]
        lines = {series.label.split("\n")[0]: series for series in panel.series}
        loads, values = lines["tire"].points
        known = loads[np.isfinite(values)]
        assert (known.min(), known.max()) == pytest.approx((min(measured), max(measured)))
        loads, values = lines["not measured"].points
        beyond = loads[np.isfinite(values)]
        assert ((beyond <= min(measured)) | (beyond >= max(measured))).all()
        assert beyond.max() == pytest.approx(1.25 * max(measured))
        assert lines["not measured"].dashes != lines["tire"].dashes


def test_the_friction_read_from_data_is_that_of_the_tire(trento):
    """Without noise the points are on the line, but for the median of a part of the slip range."""
    for channel, slip in (("Fx", "kappa"), ("Fy", "alpha")):
        family = trento.pure(channel, slip)[0]
        for group in family.groups:
            exact = (group.rows[channel] / group.rows["Fz"]).abs().max()
            assert largest_friction(group, family) == pytest.approx(exact, rel=0.03)


def test_only_some_of_many_recordings_are_listed(bench):
    comparison = replace(compare(TIRE, [bench]), sources=tuple(f"run{n}.mat" for n in range(100)))
    rows = comparison.table.iloc[:100].assign(recording=np.arange(100))
    assert "run29.mat and 70 more" in data_text(comparison, rows)


def test_the_first_figure_of_a_report_names_the_file_of_each_panel():
    files = [replace(run(steps), source=f"{name}.mat") for steps, name in ((LATERAL, "cornering"), (DRIVEN, "driven"))]
    alone, both = (overview(figures_of(TIRE, given))[0] for given in (files[:1], files))
    assert (len(alone.panels), len(both.panels)) == (1, 2)
    assert "Fy: data" not in alone.note
    assert "; Fy: data: cornering.mat; " in both.note
    assert "; Fx: data: driven.mat; " in both.note
    assert both.note.count("points: data") == 1


def test_recordings_with_equal_names_are_distinguished(bench):
    assert compare(TIRE, [bench, bench]).sources == (bench.source, f"{bench.source} (2)")
