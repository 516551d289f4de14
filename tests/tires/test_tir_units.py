"""[UNITS] of .tir files: a file in any units is the same tire."""

from __future__ import annotations

import re
from math import pi

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tirefmu.boundary.errors import TirError
from tirefmu.tires import read_tir, write_tir
from tirefmu.tires.property_file.reading import read_tir_with_notes
from tirefmu.tires.property_file.units import UNITS

pytestmark = pytest.mark.filterwarnings("ignore:.*is the file complete:tirefmu.boundary.errors.TirefmuWarning")

#: Factors to SI, independent of the tested code.
SI = {
    "LENGTH": {"meter": 1.0, "mm": 1e-3, "cm": 1e-2, "inch": 0.0254, "foot": 0.3048, "km": 1e3, "mile": 1609.344},
    "FORCE": {"newton": 1.0, "kN": 1e3, "pound_force": 4.4482216152605, "kgf": 9.80665, "KG_FORCE": 9.80665},
    "ANGLE": {"radians": 1.0, "deg": pi / 180, "Degrees": pi / 180},
    "MASS": {"kg": 1.0, "gram": 1e-3, "pound_mass": 0.45359237, "slug": 14.593902937206364},
    "TIME": {"second": 1.0, "milli": 1e-3, "min": 60.0, "hour": 3600.0},
    "PRESSURE": {"pascal": 1.0, "bar": 1e5, "kPa": 1e3, "psi": 6894.757293168361},
}
#: The dimension of each kind of value: unit key and power.
DIMENSIONS = {
    "UNLOADED_RADIUS": {"LENGTH": 1},
    "WIDTH": {"LENGTH": 1},
    "RIM_WIDTH": {"LENGTH": 1},
    "LONGVL": {"LENGTH": 1, "TIME": -1},
    "FNOMIN": {"FORCE": 1},
    "VERTICAL_STIFFNESS": {"FORCE": 1, "LENGTH": -1},
    "VERTICAL_DAMPING": {"FORCE": 1, "TIME": 1, "LENGTH": -1},
    "INFLPRES": {"PRESSURE": 1},
    "ALPMIN": {"ANGLE": 1},
    "ALPMAX": {"ANGLE": 1},
    "CAMMAX": {"ANGLE": 1},
    "FZMIN": {"FORCE": 1},
    "FZMAX": {"FORCE": 1},
    "MASS": {"MASS": 1},
    "IXX": {"MASS": 1, "LENGTH": 2},
    "KPUMAX": {},
    "ASPECT_RATIO": {},
    "PHY1": {},
    "PKY1": {},
    "PVY3": {},
    "Q_FYS1": {"FORCE": 1},
}
NUMBERS = [0.31, 0.2, 0.18, 16.7, 4000.0, 2e5, 300.0, 2.2e5, -0.3, 0.3, 0.1, 90.0, 9e3, 9.0, 0.4, 0.5, 0.6, 0.01, -21.3,
           -0.4, -2e4]  # fmt: skip
VALUES = dict(zip(DIMENSIONS, NUMBERS, strict=True))
HOME = {
    "UNLOADED_RADIUS": "DIMENSION", "WIDTH": "DIMENSION", "RIM_WIDTH": "DIMENSION", "ASPECT_RATIO": "DIMENSION",
    "LONGVL": "MODEL", "INFLPRES": "OPERATING_CONDITIONS", "MASS": "INERTIA", "IXX": "INERTIA",
    "KPUMAX": "LONG_SLIP_RANGE",
    "ALPMIN": "SLIP_ANGLE_RANGE", "ALPMAX": "SLIP_ANGLE_RANGE", "CAMMAX": "INCLINATION_ANGLE_RANGE",
    "FZMIN": "VERTICAL_FORCE_RANGE", "FZMAX": "VERTICAL_FORCE_RANGE", "PHY1": "LATERAL_COEFFICIENTS",
    "PKY1": "LATERAL_COEFFICIENTS", "PVY3": "LATERAL_COEFFICIENTS",
}  # fmt: skip


def text_in(units, section="UNITS", values=VALUES):
    """Return a file with the values written in some units."""
    lines = ["[MODEL]", "FITTYP = 62", f"[{section}]", *(f"{key} = '{unit}'" for key, unit in units.items())]
    for name, value in values.items():
        for key, power in DIMENSIONS[name].items():
            value /= SI[key][units[key]] ** power if key in units else 1.0
        lines += [f"[{HOME.get(name, 'VERTICAL')}]", f"{name} = {value!r}"]
    return "\n".join(lines)


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    return tmp_path_factory.mktemp("units") / "tire.tir"


def read(path, text):
    path.write_text(text, encoding="utf-8")
    return read_tir(path)


def numbers(tire):
    converted = {
        key: float(value)
        for section, key, value in tire.other_entries
        if section in ("INERTIA", "DIMENSION", "VERTICAL")
    }
    return {**tire.values, **converted}


@given(units=st.fixed_dictionaries({key: st.sampled_from(sorted(SI[key])) for key in SI}))
def test_any_units_are_the_same_tire(path, units):
    plain, other = read(path, text_in({})), read(path, text_in(units))
    assert numbers(other) == pytest.approx(numbers(plain), rel=1e-12)
    assert other.ranges["alpha"] == pytest.approx((-0.3, 0.3), rel=1e-12)
    # The coefficients of the Magic Formula are not converted, whatever the unit of angles.
    assert all(other.values[name] == VALUES[name] for name in ("PHY1", "PKY1", "PVY3", "KPUMAX"))
    # A rewritten file is in SI, to the last bit.
    write_tir(other, path)
    assert read_tir(path) == other
    assert "LENGTH = 'meter'" in path.read_text(encoding="utf-8")


@pytest.mark.parametrize("key", SI)
def test_a_unit_changes_its_own_values_only(path, key):
    """No unit is ignored, and none affects other values."""
    spelling, factor = sorted(SI[key].items(), key=lambda unit: unit[1])[-1]
    if key == "ANGLE":
        spelling, factor = "deg", pi / 180
    plain, other = numbers(read(path, text_in({}))), numbers(read(path, text_in({}) + f"\n[UNITS]\n{key} = {spelling}"))
    for name, powers in DIMENSIONS.items():
        assert other[name] == pytest.approx(plain[name] * factor ** powers.get(key, 0), rel=1e-12), name


@pytest.mark.parametrize(
    ("key", "spelling", "factor"), [(k, s, f) for k, table in SI.items() for s, f in table.items()]
)
def test_spellings(key, spelling, factor, path):
    for written in (spelling, spelling.upper(), f"'{spelling.lower()}'", f'"{spelling}"  $ comment'):
        tire = read(path, text_in({}) + f"\n[units]\n{key.lower()}={written}")
        for name, powers in DIMENSIONS.items():
            if powers == {key: 1} and name in tire.values:
                assert tire.values[name] == pytest.approx(VALUES[name] * factor, rel=1e-12)


def test_no_spelling_has_two_meanings():
    for key, table in UNITS.items():
        assert all(factor > 0 for factor in table.values())
        assert 1.0 in table.values(), key


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("LENGTH = 'parsec'", "LENGTH in 'parsec'"),
        ("LENGTH = 'millimetr'", "LENGTH in 'millimetr': did you mean millimetre?"),
        ("LENGTH = 'mm'cm'", "LENGTH in \"'mm'cm'\""),
        ("FORCE = 'mm'", "FORCE in 'mm'"),
        ("LENGTH = 1", "LENGTH in '1'"),
        ("LENGTH = 'mm' 'cm'", "LENGTH in \"'mm' 'cm'\""),
        ("LENGHT = 'mm'", "unknown key LENGHT in [UNITS]: did you mean LENGTH?"),
        ("LENGTH 'mm'", "\"LENGTH 'mm'\" in [UNITS] is not 'KEY = value'"),
        ("LENGTH = ", "LENGTH in [UNITS] has no value"),
    ],
)
def test_an_unknown_unit_is_an_error_with_its_line(line, message, path):
    path.write_text(f"[UNITS]\n{line}\n{text_in({})}", encoding="utf-8")
    with pytest.raises(TirError) as caught:
        read_tir(path)
    assert str(caught.value).startswith(f"{path}:2: {message}")


def test_units_in_a_header_count(path):
    """Some files have no [UNITS] but the same keys in [HEADER]; [UNITS] takes precedence."""
    assert read(path, text_in({"LENGTH": "mm", "FORCE": "kN"}, "HEADER")).values["UNLOADED_RADIUS"] == 0.31
    both = text_in({"LENGTH": "mm"}) + "\n[HEADER]\nLENGTH = 'inch'"
    assert read(path, both).values["UNLOADED_RADIUS"] == 0.31


def test_the_value_of_a_mass_is_not_a_unit(path):
    tire = read(path, "[UNITS]\nMASS = 'gram'\n" + text_in({"LENGTH": "mm"}))
    assert ("INERTIA", "MASS", repr(9.0 * 1e-3)) in tire.other_entries


def test_a_unit_after_a_value_must_agree_with_the_declared_one(path):
    text = re.sub(r"(UNLOADED_RADIUS = \S+)", r"\1 mm free radius", text_in({"LENGTH": "mm"}))
    assert read(path, text).values["UNLOADED_RADIUS"] == 0.31
    with pytest.raises(
        TirError, match=r"UNLOADED_RADIUS = '310.0 mm free radius': units are declared in \[UNITS\] only"
    ):
        read(path, text.replace("LENGTH = 'mm'", "LENGTH = 'cm'"))


def test_a_value_of_unknown_unit_is_reported(path):
    text = text_in({"LENGTH": "mm"}) + "\n[BOTTOMING_CURVE]\n{pen fz}\n0 0\n[SHOP]\nPRICE = 3\n[SHAPE]\n1 0"
    path.write_text(text, encoding="utf-8")
    reading = read_tir_with_notes(path)
    assert ("SHOP", "PRICE", "3") in reading.tire.other_entries
    assert ("TIREFMU_KEPT_UNITS", "LENGTH", "'mm'") in reading.tire.other_entries
    assert "other entries and tables without a known unit stay in the file's units" in reading.notes
    assert "LENGTH is in mm: converted to SI" in reading.notes
    path.write_text(text_in({"LENGTH": "mm"}) + "\n[SHAPE]\n1 0", encoding="utf-8")
    assert not any(section == "TIREFMU_KEPT_UNITS" for section, _, _ in read_tir(path).other_entries)
    path.write_text(text_in({}), encoding="utf-8")
    assert "the file declares no units: SI is taken" in read_tir_with_notes(path).notes
