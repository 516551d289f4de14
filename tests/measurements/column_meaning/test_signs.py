"""Signs and exchanged columns of a recording are determined from its own slopes, and a contradiction is refused."""

from itertools import permutations

import numpy as np
import pandas as pd
import pytest

from tirefmu.boundary.errors import DataError
from tirefmu.measurements import Recording, check_columns, column_notes
from tirefmu.tires import SIGNS


def recording(signs="iso", **columns) -> Recording:
    return Recording(pd.DataFrame(columns), signs, "a.csv")


def bench(signs="iso", *, spikes=0.0) -> Recording:
    """Return an alpha sweep and a kappa sweep at several loads in a convention."""
    rng = np.random.default_rng(2)
    ramp = np.tile(np.linspace(-0.2, 0.2, 200), 6)
    lateral = np.arange(len(ramp)) < len(ramp) // 2
    load = np.repeat([300.0, 800.0, 1600.0, 300.0, 800.0, 1600.0], 200)
    alpha, kappa = np.where(lateral, ramp, -0.02), np.where(lateral, 0.0, ramp)
    table = pd.DataFrame(
        {
            "alpha": alpha,
            "kappa": kappa,
            "Fz": load,
            "Fx": 1.4 * load * np.tanh(12.0 * kappa) + rng.normal(0.0, 20.0, len(ramp)),
            "Fy": -1.5 * load * np.tanh(14.0 * alpha) + 0.05 * load,
            "Mz": 0.04 * load * np.sin(14.0 * alpha) * np.exp(-20.0 * np.abs(alpha)) + rng.normal(0.0, 1.0, len(ramp)),
        }
    )
    spiked = rng.uniform(size=len(table)) < spikes
    table.loc[spiked, ["Fx", "Fy", "Mz"]] = rng.normal(0.0, 1e5, (int(spiked.sum()), 3))
    return Recording(table, "iso", "bench.csv").with_signs(signs)


def misread(signs, as_signs, **options) -> Recording:
    """Return a recording in one convention that is declared to be in another."""
    return Recording(bench(signs, **options).table, as_signs, "bench.csv")


@pytest.mark.parametrize("signs", SIGNS)
def test_data_in_the_stated_convention_are_accepted(signs):
    check_columns(bench(signs))
    assert column_notes(bench(signs)) == []


@pytest.mark.parametrize(("signs", "as_signs"), list(permutations(SIGNS, 2)))
@pytest.mark.parametrize("spikes", [0.0, 0.01])
def test_a_contradiction_names_the_convention_that_fits(signs, as_signs, spikes):
    """Without camber a reversed column gives the same table: both are named, and what decides."""
    with pytest.raises(DataError) as caught:
        check_columns(misread(signs, as_signs, spikes=spikes))
    message = str(caught.value)
    assert message.startswith("bench.csv: ")
    assert f"in {as_signs} it" in message
    assert f"the data fit {signs} (--signs {signs})" in message
    if "iso" in (signs, as_signs):
        assert "has the other sign (--columns " in message
        assert message.endswith("a sweep at camber decides (the side force points to the lean)")
    assert "\n" not in message


@pytest.mark.parametrize(
    ("channel", "expected"),
    [
        ("Fy", "Fy rises with alpha, in iso it falls: Fy has the other sign (--columns Fy=-Fy)"),
        ("Mz", "Mz falls with alpha at small angles, in iso it rises: Mz has the other sign (--columns Mz=-Mz)"),
        ("Fx", "Fx falls with kappa, in iso it rises: kappa has the other sign (--columns kappa=-kappa), or Fx has"),
    ],
)
def test_a_single_reversed_channel_is_named(channel, expected):
    table = bench().table
    with pytest.raises(DataError) as caught:
        check_columns(recording(**table.assign(**{channel: -table[channel]})))
    assert expected in str(caught.value)


def cambered(*, signs="iso", **changes) -> Recording:
    """Return the alpha sweeps at three cambers in a convention, with changed columns."""
    table = bench().table.iloc[:600]
    parts = [table.assign(gamma=gamma, Fy=table["Fy"] - 1.3 * gamma * table["Fz"]) for gamma in (0.0, 0.035, 0.07)]
    made = Recording(pd.concat(parts, ignore_index=True), "iso", "a.csv").with_signs(signs)
    return Recording(
        made.table.assign(**{name: change(made.table) for name, change in changes.items()}), "iso", "a.csv"
    )


def test_camber_decides_between_a_mirrored_slip_angle_and_adapted_sae():
    (mirrored,) = column_notes(cambered(alpha=lambda table: -table["alpha"]))
    (adapted,) = column_notes(cambered(signs="adapted-sae"))
    assert ": alpha has the other sign (--columns alpha=-alpha), camber thrust -72.8 N at 4.01 deg" in mirrored
    assert "; that the data fit adapted-sae (--signs adapted-sae) is less probable, camber thrust +72.8 N" in mirrored
    assert ": the data fit adapted-sae (--signs adapted-sae), camber thrust -72.8 N" in adapted
    assert "that alpha has the other sign (--columns alpha=-alpha) is less probable" in adapted
    (reversed_camber,) = column_notes(cambered(gamma=lambda table: -table["gamma"]))
    assert "the camber thrust points away from the lean: gamma has the other sign" in reversed_camber
    assert column_notes(cambered()) == []


@pytest.mark.parametrize("part", ["both sweeps", "alpha", "kappa"])
def test_exchanged_forces_are_named(part):
    table = bench().table
    rows = {"both sweeps": slice(None), "alpha": slice(0, 600), "kappa": slice(600, None)}[part]
    exchanged = table.rename(columns={"Fx": "Fy", "Fy": "Fx"}).iloc[rows].reset_index(drop=True)
    assert column_notes(recording(**table.iloc[rows])) == []
    with pytest.raises(DataError, match=r"the columns Fx and Fy are exchanged \(--columns Fx=Fy,Fy=Fx\)"):
        check_columns(recording(**exchanged))


def test_exchanged_slips_are_distinguished_from_exchanged_forces():
    """The aligning moment follows the slip angle, whatever its column is called."""
    exchanged = bench().table.rename(columns={"alpha": "kappa", "kappa": "alpha"})
    with pytest.raises(DataError, match=r"alpha and kappa are exchanged \(--columns alpha=kappa,kappa=alpha\)$"):
        check_columns(recording(**exchanged))


def test_a_force_that_follows_both_slips_is_not_exchanged():
    """Under combined slip Fx may change with alpha where kappa does: what matters is that no force follows its own."""
    kappa = np.linspace(-0.15, 0.15, 400)
    check_columns(
        recording(
            kappa=kappa, alpha=0.3 * kappa, Fz=np.full(400, 900.0),
            Fx=900.0 * np.tanh(12.0 * kappa), Fy=-600.0 * np.tanh(4.0 * kappa),
        )
    )  # fmt: skip


def test_nothing_is_concluded_from_noise():
    rng = np.random.default_rng(1)
    held = rng.normal(0.0, 3e-4, 500)
    check_columns(recording(alpha=held, Fy=1e4 * held))
    swept = np.linspace(-0.2, 0.2, 500)
    check_columns(recording(alpha=swept, kappa=swept, Fx=rng.normal(size=500), Fy=rng.normal(size=500)))


@pytest.mark.parametrize("signs", SIGNS)
@pytest.mark.parametrize(("column", "fact"), [
    ("Fy", "Fy has the same sign at both ends of alpha"), ("Fx", "Fx has the same sign at both ends of kappa"),
    ("alpha", "Fy has both signs at the same end of alpha"), ("kappa", "Fx has both signs at the same end of kappa"),
])  # fmt: skip
def test_a_column_without_its_sign_is_named(signs, column, fact):
    table = bench(signs).table.assign(**{column: lambda rows: rows[column].abs()})
    (note,) = column_notes(Recording(table, signs, "bench.csv"))
    assert note.startswith(f"bench.csv: {fact}")
    assert f"--columns {column}=NAME" in note


def test_a_sweep_of_one_side_has_its_sign():
    table = bench().table
    assert column_notes(Recording(table[table["alpha"] > -0.03], "iso", "half.csv")) == []


@pytest.mark.parametrize("slip", ["alpha", "kappa"])
def test_a_slip_exchanged_with_camber_is_named(slip):
    table = bench().table.assign(gamma=lambda rows: np.where(rows["Fz"] > 500.0, 0.05, 0.0))
    swapped = table.rename(columns={slip: "gamma", "gamma": slip})
    (note,) = column_notes(Recording(swapped, "iso", "bench.csv"))
    assert f"--columns {slip}=gamma,gamma={slip}" in note
