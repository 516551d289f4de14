"""A recording preserves its rows, converts its signs, and finds its segments."""

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tirefmu.boundary.errors import DataError, UnknownName
from tirefmu.measurements import CHANNELS, Recording, recording_from
from tirefmu.tires import SIGNS
from tirefmu.tires.signs import REVERSED


def table_of_ones() -> pd.DataFrame:
    return pd.DataFrame({name: [1.0, 2.0] for name in CHANNELS} | {"remark": ["a", "b"]})


@pytest.mark.parametrize("start", SIGNS)
@pytest.mark.parametrize("target", SIGNS)
def test_signs_turned_and_back(start, target):
    recording = Recording(table_of_ones(), start, "a.csv", {"tireid": "x"})
    turned = recording.with_signs(target)
    assert turned.signs == target
    assert turned.about == {"tireid": "x"}
    flipped = {name for name in CHANNELS if (turned.table[name] < 0).all()}
    assert flipped == REVERSED[start] ^ REVERSED[target]
    pd.testing.assert_frame_equal(turned.with_signs(start).table, recording.table)


def test_unknown_signs_are_refused():
    with pytest.raises(UnknownName, match="sign convention"):
        Recording(table_of_ones(), "din", "a.csv")


@given(st.lists(st.integers(4, 40), min_size=1, max_size=8), st.sampled_from([0.01, 0.02]))
def test_segments_are_the_logged_stretches(lengths, dt):
    clocks = [start * 100.0 + dt * np.arange(rows) for start, rows in enumerate(lengths)]
    recording = Recording(pd.DataFrame({"t": np.concatenate(clocks)}), "iso", "a.csv")
    segments = recording.segments()
    rows = np.arange(len(recording))
    assert np.array_equal(np.concatenate([rows[segment] for segment in segments]), rows)
    assert [segment.stop - segment.start for segment in segments] == lengths


@pytest.mark.parametrize(
    ("columns", "segments"),
    [
        ({"t": [0.0, 0.01, 0.02, 0.03, 0.0, 0.01, 0.02]}, [slice(0, 4), slice(4, 7)]),  # the clock was restarted
        ({"t": [0.0, 0.01, 0.01, 0.02, 0.05, 0.06, 0.07]}, [slice(0, 7)]),  # repeated and lost samples
        ({"Fz": [1.0, 2.0]}, [slice(0, 2)]),
        ({"t": []}, []),
    ],
)
def test_segments_of_unusual_clocks(columns, segments):
    assert Recording(pd.DataFrame(columns), "iso", "a.csv").segments() == segments


def test_measured_outputs():
    table = pd.DataFrame({"Fz": [1.0], "Fx": [np.nan], "Mz": [0.0]})
    assert Recording(table, "iso", "a.csv").measured() == ("Mz",)
    with pytest.raises(DataError, match=r"a.csv: column 'FY' is not a channel: did you mean Fy\? "):
        Recording(pd.DataFrame({"FY": [1.0], "Fx": [np.nan]}), "iso", "a.csv").measured()


def test_a_table_without_an_output_names_the_columns_that_may_be_one(tmp_path):
    file = tmp_path / "a.csv"
    file.write_text("alpha,Fz,Zijkracht\n0.1,900,-700\n")
    with pytest.raises(DataError, match=r"no measured output .*not read: .*Zijkracht \(--columns Fy=NAME"):
        recording_from(file).measured()
    assert recording_from(file, columns={"Fy": "Zijkracht"}).measured() == ("Fy",)
    with pytest.raises(DataError, match="Fy has no value"):
        Recording(pd.DataFrame({"Fz": [900.0], "Fy": [np.nan]}), "iso", "a.csv").measured()


def test_the_row_of_a_bad_number_is_counted_from_one():
    for value, words in ((np.nan, "NaN"), (np.inf, "infinite")):
        table = pd.DataFrame({"alpha": [0.0, 0.1, value], "Fz": 500.0, "Fy": [0.0, 1.0, 2.0]})
        for source in (table, Recording(table, "iso", "made")):  # read as a file is, and checked as it is
            with pytest.raises(DataError, match=f"row 3: alpha is {words}"):
                recording_from(source)
