"""Radii that a bench file shows, and nominal values that contradict them."""

import numpy as np
import pandas as pd
import pytest

from tirefmu.boundary.errors import FitError
from tirefmu.measurements import Recording, check_nominal, check_radius, read_recording
from tirefmu.measurements.checks.columns.radii import radii
from tirefmu.symbolic.models import model_named


@pytest.mark.parametrize(
    ("title", "radius"),
    [("Hoosier 43075 16x7.5-10 LCO, 7 inch rim", 0.2032), ("18.0x6.0-10", 0.2286), ("205/55R16", 0.316), ("R7", None)],
)
def test_the_size_of_a_tire_gives_its_radius(title, radius):
    found = radii(Recording(pd.DataFrame(), "iso", "a", {"tireid": title}))
    assert found == ({} if radius is None else {"size of its tire": pytest.approx(radius, abs=1e-4)})


@pytest.mark.parametrize(("wheel", "loaded", "expected"), [
    (468.5, 21.96, {"loaded radius": 0.2196, "wheel speed": 0.2265}), (0.03, 64178.97, {}), (0.0, np.nan, {})
])  # fmt: skip
def test_unusable_channels_of_a_bench_give_no_radius(tmp_path, wheel, loaded, expected):
    rows = pd.DataFrame({"ET": np.arange(9) / 100.0, "SA": 1.0, "IA": 0.0, "FZ": -900.0, "FY": 1.0, "V": 40.0})
    rows.assign(N=wheel, RL=loaded).to_csv(tmp_path / "a.csv", index=False)
    assert radii(read_recording(tmp_path / "a.csv")) == pytest.approx(expected, abs=1e-4)


def test_nominal_values_that_contradict_the_recordings_are_refused():
    bench = Recording(pd.DataFrame({"Fz": [190.0, 700.0, 1168.0]}), "iso", "a", {"loaded radius": "0.22"})
    check_radius({"R0": 0.23}, [bench])
    check_radius({}, [bench])
    with pytest.raises(FitError, match=r"R0 = 0.46 m contradicts a: 0.22 m by the loaded radius"):
        check_radius({"R0": 0.46}, [bench])
    sized = Recording(bench.table, "iso", "b", {"tireid": "Maker 16x7.5-10"})
    for value, noted in ((0.2, False), (0.203, False), (0.23, True), (0.17, True)):
        assert bool(check_radius({"R0": value}, [bench, sized])) == noted
    model = model_named("mf96")
    check_nominal({"Fz0": 220.0, "R0": 0.23}, model, [bench.table])
    with pytest.raises(FitError, match=r"Fz0 = 3600 N is far outside the tested loads, 200.2 to 1159 N"):
        check_nominal({"Fz0": 3600.0, "R0": 0.23}, model, [bench.table])
