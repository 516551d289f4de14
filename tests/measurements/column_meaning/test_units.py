"""Units, constant, copied and missing columns: wrong tables are refused with the option that corrects them."""

import numpy as np
import pandas as pd
import pytest

from tirefmu.boundary.errors import DataError, TirefmuError
from tirefmu.measurements import POUND, Interpretation, Recording, check_columns, column_notes, recording_from

from ...relatives import slow_but

DEGREE = np.pi / 180.0


def table(friction=1.4, stiffness=18.0):
    """Return sweeps of both slips at three loads and cambers, in ISO."""
    ramp = np.tile(np.linspace(-0.2, 0.2, 80), 18)
    lateral = np.arange(len(ramp)) < len(ramp) // 2
    load = np.tile(np.repeat([400.0, 800.0, 1200.0], 80), 6)
    gamma = np.tile(np.repeat([0.0, 0.035, 0.07], 240), 2)
    alpha, kappa = np.where(lateral, ramp, 0.0), np.where(lateral, 0.0, ramp)
    shifted = stiffness * (alpha + 0.07 * gamma)
    side = -friction * load * np.sin(1.4 * np.arctan(shifted / friction / 1.4))
    return pd.DataFrame(
        {
            "kappa": kappa, "alpha": alpha, "gamma": gamma, "Fz": load, "p": 83e3,
            "Fx": friction * load * np.sin(1.5 * np.arctan(1.2 * stiffness * kappa / friction / 1.5)),
            "Fy": side, "Mz": -0.03 * side * np.cos(1.1 * np.arctan(9.0 * alpha)), "Mx": 0.03 * side,
        }
    )  # fmt: skip


#: Factor of the numbers, the declared unit, and the option that corrects them.
UNITS = {
    "Fz lbf": ({"Fz": 1.0 / POUND}, {}, "--units Fz=lbf"),
    "Fz kgf": ({"Fz": 1.0 / 9.80665}, {}, "--units Fz=kgf"),
    "Fz times 10": ({"Fz": 10.0}, {}, "--units Fz=0.1N"),
    "Fy kN": ({"Fy": 1e-3}, {}, "--units Fy=kN"),
    "Fx lbf": ({"Fx": 1.0 / POUND}, {}, "--units Fx=lbf"),
    "Fx and Fy lbf": ({"Fx": 1.0 / POUND, "Fy": 1.0 / POUND}, {}, "--units Fx=lbf,Fy=lbf"),
    "Mz N mm": ({"Mz": 1e3}, {}, "--units Mz=Nmm"),
    "Mx N mm": ({"Mx": 1e3}, {}, "--units Mx=Nmm"),
    "alpha in rad, header deg": ({"alpha": DEGREE}, {"alpha": "deg"}, "--units alpha=rad"),
    "gamma in rad, header deg": ({"gamma": DEGREE}, {"gamma": "deg"}, "--units gamma=rad"),
    "kappa a fraction, header %": ({"kappa": 0.01}, {"kappa": "%"}, "--units kappa=1"),
    "p psi, header kPa": ({"p": 1.0 / 6.894757}, {"p": "kPa"}, "--units p=psi"),
}


def changed(factors, declared=()) -> Recording:
    about = {f"unit of {name}": unit for name, unit in dict(declared).items()} | {"declared": " ".join(declared)}
    made = table()
    return Recording(made.assign(**{name: factor * made[name] for name, factor in factors.items()}), "iso", "a", about)


@pytest.mark.parametrize("case", slow_but(list(UNITS)[::3], UNITS))
def test_a_wrong_unit_is_refused_and_its_option_gives_the_right_table(case):
    factors, declared, option = UNITS[case]
    wrong = changed(factors, declared)
    (note,) = column_notes(wrong)
    assert option in note
    units = dict(pair.split("=") for pair in option.removeprefix("--units ").split(","))
    right = Interpretation(units=units).applied(wrong)
    assert column_notes(right) == []
    for name in factors:
        assert right.table[name].to_numpy() == pytest.approx(table()[name].to_numpy(), rel=1e-6)


@pytest.mark.parametrize("friction", [0.9, 1.4, 2.4])
@pytest.mark.parametrize("stiffness", [9.0, 18.0, 35.0])
def test_right_tables_of_many_tires_stand(friction, stiffness):
    assert column_notes(Recording(table(friction, stiffness), "iso", "a")) == []


@pytest.mark.parametrize(
    "part",
    [
        lambda t: t.drop(columns=["kappa", "Fx"]).iloc[:720],
        lambda t: t[t["gamma"] == 0.0].drop(columns="gamma"),
        lambda t: t[["alpha", "Fz", "Fy"]].iloc[:720],
        lambda t: t[t["Fz"] == 800.0],
        lambda t: t.iloc[720:].drop(columns=["Fy", "Mz", "Mx"]),
        lambda t: t.iloc[720:].drop(columns=["alpha", "gamma", "Fy", "Mz", "Mx"]),
        lambda t: t.drop(columns="Fz"),
        lambda t: t[["alpha", "gamma", "Fz"]],
        lambda t: t.iloc[:0],
        lambda t: t.iloc[::60],
    ],
)
def test_parts_of_a_right_table_stand(part):
    """No column, load or camber is needed for a table to be right."""
    assert column_notes(Recording(part(table()), "iso", "a")) == []


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        (lambda t: t.assign(Fy=0.0), "Fy is 0 in every row although alpha is swept"),
        (lambda t: t.assign(Mz=3.0), "Mz is 3 in every row although alpha is swept"),
        (lambda t: t.assign(Fx=t["Fy"]), "Fx and Fy have the same numbers: one of them is a copy"),
        (lambda t: t.drop(columns="Fy"), "no column Fy although alpha is swept"),
        (lambda t: t.drop(columns="alpha"), "alpha is missing although Fy changes from -1.4 to 1.4 times the load"),
        (lambda t: t.assign(kappa=0.0), "kappa is constant although Fx changes"),
        (lambda t: t.assign(Fz=0.0), "Fz is 0 in every row"),
        (lambda t: t.rename(columns={"Mx": "Mz", "Mz": "Mx"}), "the columns Mx and Mz are exchanged"),
    ],
)
def test_constant_copied_missing_and_exchanged_columns_are_refused(change, expected):
    with pytest.raises(DataError) as caught:
        check_columns(Recording(change(table()), "iso", "a"))
    assert expected in str(caught.value)
    assert "--columns " in str(caught.value)


def test_columns_and_units_of_a_dataframe():
    rows = pd.DataFrame({"SA": [0.1], "IA": [2.0], "Fz": [1.0], "F": [3.0], "Fy": [1.0]})
    read = recording_from(
        rows, columns={"alpha": "-SA", "gamma": "IA", "Fx": "F", "Fy": "none"}, units={"gamma": "deg", "Fz": "kN"}
    )
    assert read.table.round(4).iloc[0].to_dict() == {"alpha": -0.1, "gamma": 0.0349, "Fz": 1000.0, "Fx": 3.0}
    for options, expected in (
        ({"columns": {"alpha": "SAA"}}, "no column 'SAA' (alpha): did you mean SA?"),
        ({"columns": {"aplha": "SA"}}, "unknown channel 'aplha': did you mean alpha?"),
        ({"columns": {"Fx": "My"}}, "no column 'My' (Fx)"),
        ({"units": {"Fz": "psi"}}, "unit 'psi' measures pressure, not force"),
        ({"units": {"T": "K"}}, "no column 'T', whose unit is given as K"),
    ):
        with pytest.raises(TirefmuError) as caught:
            recording_from(rows, **options)
        assert expected in str(caught.value)


def test_what_the_user_asserts_is_not_doubted():
    """An option states a unit: a strange tire can be read as it is."""
    strange = table().assign(Fz=table()["Fz"] / POUND)
    with pytest.raises(DataError, match="Fz is in lbf"):
        check_columns(recording_from(strange))
    check_columns(recording_from(strange, units={"Fz": "N"}))
    leaning = table().assign(gamma=-table()["gamma"])
    check_columns(recording_from(leaning, columns={"gamma": "gamma"}))
    with pytest.raises(DataError, match="the columns Fx and Fy are exchanged"):
        check_columns(recording_from(table(), columns={"Fx": "Fy", "Fy": "Fx"}))
