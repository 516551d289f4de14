"""Preprocessing of a recording: signs, time blocks, the hold-out set, and rejected input."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from tirefmu.boundary.errors import DataError
from tirefmu.diagnosis.probing.effect_probing import _edges
from tirefmu.diagnosis.signals import HOLDOUT_EVERY, signals_of
from tirefmu.tires import convert_signs

OUTPUTS = ["Fx", "Fy", "Mz"]


def edges(signals):
    return _edges(signals.block, np.where(signals.present & ~signals.holdout, 1.0, 0.0))


def test_all_sign_conventions_give_the_same_signals(table, tire):
    expected = signals_of(table, tire, "adapted-sae")
    for signs in ("iso", "sae"):
        found = signals_of(convert_signs(table, "adapted-sae", signs), tire, signs)
        np.testing.assert_allclose(found.measured, expected.measured, rtol=1e-12)
        np.testing.assert_allclose(found.inputs, expected.inputs, rtol=1e-12)


def test_blocks_are_in_order_and_every_nth_is_in_the_hold_out_set(table, tire):
    signals = signals_of(table, tire, "adapted-sae")
    assert set(np.diff(signals.block)) == {0, 1}
    apart = np.unique(signals.block[signals.holdout])
    assert set(np.diff([apart[0] - HOLDOUT_EVERY, *apart])) == {HOLDOUT_EVERY}
    assert apart[0] < HOLDOUT_EVERY
    assert signals.block[-1] - apart[-1] < HOLDOUT_EVERY
    for block in range(signals.block[-1] + 1):
        assert len(set(signals.holdout[signals.block == block])) == 1


def test_channels_and_rows_are_the_same_with_and_without_smoothing(table, tire):
    """Noise of a slip that is 0, or of a load near 0, neither adds a channel nor removes rows."""
    rng = np.random.default_rng(0)
    load = table["Fz"] * np.where(np.arange(len(table)) < 400, 1e-3, 1.0) + rng.normal(0.0, 10.0, len(table))
    noisy = table.assign(kappa=rng.normal(0.0, 0.0013, len(table)), Fz=load)
    smooth, raw = (signals_of(noisy, tire, "adapted-sae", smooth=smooth) for smooth in (True, False))
    assert smooth.channels == raw.channels == ("Fy", "Mz")
    np.testing.assert_array_equal(smooth.rows, raw.rows)


def test_delayed_inputs_are_those_of_an_earlier_time(table, tire):
    signals = signals_of(table, tire, "adapted-sae", smooth=False)
    names, t = list(signals.names), signals.t
    inputs = signals.inputs.copy()
    inputs[names.index("alpha")], inputs[names.index("Fz")] = np.sin(0.8 * t), 3000.0
    delayed = replace(signals, inputs=inputs).delayed(0.007).delayed(0.006)
    inner = slice(5, -5)
    np.testing.assert_allclose(delayed.inputs[names.index("alpha")][inner], np.sin(0.8 * (t[inner] - 0.013)), atol=1e-4)
    assert (delayed.inputs[names.index("Fz")] == 3000.0).all()
    assert delayed.skew == pytest.approx(0.013)


def test_a_gap_in_time_does_not_make_a_block_longer(table, tire):
    paused = table.assign(t=table["t"] + np.where(np.arange(len(table)) < 1000, 0.0, 500.0))
    expected = signals_of(table, tire, "adapted-sae").block
    assert np.max(np.abs(signals_of(paused, tire, "adapted-sae").block - expected)) <= 1


@pytest.mark.parametrize(("rows", "step"), [(200, 0.02), (240, 2.0), (900, 0.5), (2400, 0.02), (3000, 0.001)])
def test_every_accepted_recording_has_blocks_for_cross_validation(table, tire, rows, step):
    """At any sampling rate: a block is an interval of time, not a number of rows."""
    slow = pd.concat([table, table], ignore_index=True)[:rows].assign(t=step * np.arange(rows))
    signals = signals_of(slow, tire, "adapted-sae")
    found = edges(signals)
    assert len(found) - 1 == len(set(signals.block[~signals.holdout])) >= 8
    assert found[0] == 0
    assert found[-1] == len(signals.rows)
    assert (np.diff(found) > 0).all()


def test_a_block_with_few_rows_joins_its_neighbour(table, tire):
    signals = signals_of(table, tire, "adapted-sae")
    whole = edges(signals)
    present = signals.present.copy()
    rest = np.flatnonzero(signals.block == 3)
    present[:, rest[5:]] = False
    remaining = _edges(signals.block, np.where(present & ~signals.holdout, 1.0, 0.0))
    assert set(whole) - set(remaining) == {rest[0]}


def test_outputs_measured_in_few_blocks_are_rejected(table, tire):
    brief = table.copy()
    brief.loc[400:, OUTPUTS] = np.nan
    with pytest.raises(DataError, match=r"Fx, Fy, Mz: measured in 4 of 19 equal parts of the recording: .* at least 8"):
        signals_of(brief, tire, "adapted-sae")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda table: table[:199], "199 rows"),
        (lambda table: table.drop(columns="Fz"), "no column 'Fz'"),
        (lambda table: table.drop(columns=OUTPUTS), "no measured output"),
        (lambda table: table.assign(Fz=0.0), "0 rows under load"),
        (lambda table: table.assign(alpha=np.nan), "row 1: alpha is not a finite number"),
    ],
)
def test_unusable_tables_raise_a_clear_error(table, tire, change, message):
    with pytest.raises(DataError, match=message):
        signals_of(change(table), tire, "adapted-sae")


def test_without_longitudinal_slip_fx_is_excluded(table, tire):
    signals = signals_of(table.assign(kappa=0.0), tire, "adapted-sae")
    assert signals.channels == ("Fy", "Mz")
    assert list(signals.excluded_channels) == ["Fx"]
