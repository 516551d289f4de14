"""Dimensions of a tire come from its size or the recordings; what nobody tells is not invented in silence."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

from tirefmu.boundary.errors import FitError, FmuError
from tirefmu.fitting.data.dimensions import dimensions
from tirefmu.fmu.description.interface import interface
from tirefmu.measurements import Recording
from tirefmu.measurements.checks.columns.radii import deflection, tire_size
from tirefmu.tires import Tire
from tirefmu.tires.property_file.names import assumed_lines, not_given


def recording(**about):
    return Recording(
        pd.DataFrame({"Fz": [900.0]}), "iso", "a.mat", {name.replace("_", " "): text for name, text in about.items()}
    )


@pytest.mark.parametrize(
    ("text", "radius", "width", "rim"),
    [
        ("245/45R18", 0.33885, 0.245, 0.2286), ("205/55 ZR16 91V", 0.31595, 0.205, 0.2032),
        ("16x7.5-10", 0.2032, 0.1905, 0.127), ("Hoosier 20.5 x 7.0 - 13", 0.26035, 0.1778, 0.1651),
    ],
)  # fmt: skip
def test_a_size_has_dimensions(text, radius, width, rim):
    size = tire_size(text)
    assert (size.radius, size.width, size.rim_radius) == pytest.approx((radius, width, rim), abs=1e-4)


@pytest.mark.parametrize("text", ["", "run 12", "1x2", "45R18"])
def test_a_text_without_a_size_has_none(text):
    assert tire_size(text) is None
    with pytest.raises(FitError, match="is not like 245/45R18"):
        dimensions([], text)


def test_the_radius_at_zero_load_and_the_stiffness_follow_from_loaded_radii():
    rng = np.random.default_rng(1)
    load = rng.uniform(200.0, 1200.0, 2000)
    radius = 0.23 - load / 1.5e5 + rng.normal(0.0, 5e-4, load.size)
    about = deflection(-load, radius)
    assert float(about["radius at zero load"]) == pytest.approx(0.23, rel=0.01)
    assert float(about["vertical stiffness"]) == pytest.approx(1.5e5, rel=0.05)
    assert deflection(np.full(500, 700.0), radius[:500]) == {}
    assert deflection(load, 0.46 - radius) == {}


@pytest.mark.parametrize(
    ("about", "size", "radius", "source"),
    [
        ({"tireid": "Maker 16x7.5-10"}, None, 0.2032, "size Maker 16x7.5-10"),
        ({"tireid": "Maker 16x7.5-10"}, "18x6-10", 0.2286, "size 18x6-10"),
        ({"radius_at_zero_load": "0.2069", "loaded_radius": "0.198"}, None, 0.207, "radius at zero load of a.mat"),
        ({"wheel_speed": "0.2278", "loaded_radius": "0.2196"}, None, 0.228, "wheel speed of a.mat"),
        ({"loaded_radius": "0.2196"}, None, 0.22, "loaded radius of a.mat"),
    ],
)
def test_the_best_source_is_taken_and_stated(about, size, radius, source):
    values, notes = dimensions([recording(), recording(**about)], size)
    assert values["UNLOADED_RADIUS"] == pytest.approx(radius, abs=1e-4)
    assert any(source in note for note in notes)
    assert ("WIDTH" in values) == ("size" in source)


def test_nothing_is_known_without_a_source():
    assert dimensions([recording()], None) == ({}, [])


@pytest.mark.parametrize("inputs", ["wheel", "hub"])
def test_a_wheel_of_unknown_radius_is_refused(inputs):
    tire = Tire("mf61", {"FNOMIN": 3000.0, "UNLOADED_RADIUS": 0.3})
    unknown = Tire("mf61", dict(tire.values), other_entries=assumed_lines(["UNLOADED_RADIUS"], tire.symbolic_model))
    assert not_given(unknown) == ("UNLOADED_RADIUS",)
    assert interface(tire, inputs=inputs)
    with pytest.raises(FmuError, match="need the radius of the wheel"):
        interface(unknown, inputs=inputs)
