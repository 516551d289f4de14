"""A missing slip is a serious finding and a column that is not read is named."""

import pandas as pd

from tirefmu.measurements import Recording, data_findings

SWEEP = {"kappa": [0.0, 0.1] * 40, "alpha": [-0.1, 0.1] * 40, "Fz": [500.0, 900.0] * 40, "Fy": [9.0, -9.0] * 40}


def findings(**columns):
    return data_findings([Recording(pd.DataFrame(columns), "iso", "a.csv")])


def test_a_missing_slip_comes_first_and_is_serious():
    first, *others = findings(**{name: values for name, values in SWEEP.items() if name != "alpha"})
    assert first.kind == "missing slip"
    assert first.serious
    assert first.text.startswith("a.csv: NO COLUMN alpha (slip angle): Fy cannot be fitted, and every row counts as")
    assert not any(finding.kind == "missing slip" for finding in others)


def test_a_slip_without_influence_on_what_was_measured_may_be_missing():
    assert findings(**{name: values for name, values in SWEEP.items() if name != "kappa"}) == []


def test_columns_that_are_not_read_are_named_and_counted():
    (few,) = findings(**SWEEP, lap=1)
    assert (few.kind, few.serious) == ("unread columns", False)
    assert few.text == "a.csv: columns that are no channels are not fitted: lap"
    (many,) = findings(**SWEEP, **{f"c{number}": 1 for number in range(11)})
    assert many.text.endswith(": c0, c1, c2, c3, c4, c5, c6, c7 and 3 more")
