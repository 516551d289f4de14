"""A column is named by its header, with or without the unit, and keeps the unit."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from tirefmu.measurements import recording_from


@pytest.mark.parametrize("whole", [False, True])
def test_a_header_that_is_named_whole_keeps_its_unit(tmp_path, whole):
    angle = np.linspace(-10.0, 10.0, 50)
    table = pd.DataFrame({"slip angle [deg]": angle, "load [kN]": 2.0, "side": -1000.0 * angle})
    table.to_csv(tmp_path / "a.csv", index=False)
    headers = {name: header if whole else header.partition(" [")[0] for name, header in
               {"alpha": "-slip angle [deg]", "Fz": "load [kN]", "Fy": "side"}.items()}  # fmt: skip
    read = recording_from(tmp_path / "a.csv", columns=headers).table
    np.testing.assert_allclose(read["alpha"], -np.radians(angle))
    np.testing.assert_allclose(read["Fz"], 2000.0)
