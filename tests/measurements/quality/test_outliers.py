"""A value far from the running median of its channel is found in any row; a clean signal has no outliers."""

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tirefmu.measurements import Recording, VirtualBench, outliers, small_tire_program, trento_program
from tirefmu.tires import published

#: Larger than any change in the raw run within 0.01 s.
SPIKES = {"alpha": 0.1, "Fz": 1500.0, "p": 30e3, "V": 4.0, "T": 40.0, "Fy": 3000.0, "Mz": 60.0}


@pytest.mark.parametrize("seed", range(3))
def test_a_noisy_bench_has_no_outliers(make_raw, seed):
    assert outliers(make_raw(seed=seed).recording) == []


def test_the_virtual_benches_have_none():
    for tire, program in (("trento_hoosier", trento_program()), ("unicamp_small_tire", small_tire_program())):
        assert outliers(VirtualBench(published(tire), seed=2).run(program)) == []


@settings(max_examples=40)
@given(
    channel=st.sampled_from(list(SPIKES)),
    rows=st.sets(st.integers(0, 1500), min_size=1, max_size=4),
    sign=st.sampled_from([-1.0, 1.0]),
    signs=st.sampled_from(["iso", "sae", "adapted-sae"]),
)
def test_every_spike_is_found_and_only_it(raw, channel, rows, sign, signs):
    # At least ten rows apart: a running median of fifteen rows tolerates seven outliers, not eight.
    at = sorted(row * 10 for row in rows)
    table = raw.recording.table.copy()
    table.loc[at, channel] += sign * SPIKES[channel]
    spoilt = Recording(table, "iso", "a.csv").with_signs(signs)
    found = outliers(spoilt)
    assert [(reading.row, reading.channel) for reading in found] == [(row, channel) for row in at]
    assert [reading.value for reading in found] == spoilt.table[channel].iloc[at].tolist()


def test_missing_values_are_not_outliers_and_hide_none(raw):
    table = raw.recording.table.copy()
    table.loc[::3, "Fy"] = np.nan
    table.loc[700, "Fy"] = 9e3
    assert [(reading.row, reading.channel) for reading in outliers(Recording(table, "iso", "a.csv"))] == [(700, "Fy")]


def test_a_coarse_sensor_has_none(raw):
    speed = 11.2 + 0.003 * (np.random.default_rng(0).random(len(raw.recording)) < 0.1)
    assert outliers(Recording(raw.recording.table.assign(V=speed), "iso", "a.csv")) == []


def test_the_sentence():
    time = np.arange(200) / 100.0
    table = {"t": time, "Fy": np.where(np.arange(200) == 70, 900.0, 100.0)}
    (reading,) = outliers(Recording(pd.DataFrame(table), "iso", "a.csv"))
    assert str(reading) == "row 71: Fy is 900 N, the running median is 100"
