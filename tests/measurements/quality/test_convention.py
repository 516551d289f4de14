"""The sign convention of a recording is determined from its own slopes, and a contradiction is refused."""

from itertools import permutations

import numpy as np
import pandas as pd
import pytest

from tirefmu.boundary.errors import DataError
from tirefmu.measurements import Recording, check_convention, convention_notes, fitting_conventions
from tirefmu.tires.signs import SIGNS


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
    assert fitting_conventions(bench(signs)) == (signs,)
    check_convention(bench(signs))
    assert convention_notes(bench(signs)) == []


@pytest.mark.parametrize(("signs", "as_signs"), list(permutations(SIGNS, 2)))
@pytest.mark.parametrize("spikes", [0.0, 0.01])
def test_a_contradiction_names_the_convention_that_fits(signs, as_signs, spikes):
    with pytest.raises(DataError) as caught:
        check_convention(misread(signs, as_signs, spikes=spikes))
    message = str(caught.value)
    assert message.startswith("bench.csv: ")
    assert f"in {as_signs}" in message
    assert message.endswith(f"the data fit {signs} (--signs {signs})")
    assert "\n" not in message


def test_a_single_reversed_channel_is_named():
    """No convention reverses a single force."""
    facts = {"Fy": "Fy rises with alpha", "Mz": "Mz falls with alpha at small angles", "Fx": "Fx falls with kappa"}
    for channel, expected in facts.items():
        table = bench().table
        with pytest.raises(DataError, match=expected) as caught:
            check_convention(recording(**table.assign(**{channel: -table[channel]})))
        assert str(caught.value).endswith(f"no convention fits: multiply {channel} in the file by -1")


@pytest.mark.parametrize("part", ["both sweeps", "alpha", "kappa"])
def test_exchanged_forces_are_named(part):
    table = bench().table
    rows = {"both sweeps": slice(None), "alpha": slice(0, 600), "kappa": slice(600, None)}[part]
    exchanged = table.rename(columns={"Fx": "Fy", "Fy": "Fx"}).iloc[rows].reset_index(drop=True)
    assert convention_notes(recording(**table.iloc[rows])) == []
    with pytest.raises(DataError, match="the columns Fx and Fy are exchanged"):
        check_convention(recording(**exchanged))


def test_a_force_that_follows_both_slips_is_not_exchanged():
    """Under combined slip Fx may change with alpha where kappa does: what matters is that no force follows its own."""
    kappa = np.linspace(-0.15, 0.15, 400)
    check_convention(
        recording(
            kappa=kappa, alpha=0.3 * kappa, Fz=np.full(400, 900.0),
            Fx=900.0 * np.tanh(12.0 * kappa), Fy=-600.0 * np.tanh(4.0 * kappa),
        )
    )  # fmt: skip


def test_nothing_is_concluded_from_noise():
    rng = np.random.default_rng(1)
    held = rng.normal(0.0, 3e-4, 500)
    noise = recording(alpha=held, Fy=1e4 * held)
    assert fitting_conventions(noise) == SIGNS
    check_convention(noise)
    swept = np.linspace(-0.2, 0.2, 500)
    check_convention(recording(alpha=swept, kappa=swept, Fx=rng.normal(size=500), Fy=rng.normal(size=500)))
