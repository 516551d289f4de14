"""Tire files: a written tire is read back to the last bit; an invalid file is reported in one line."""

from __future__ import annotations

import re
from dataclasses import replace
from decimal import Decimal
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tirefmu.boundary.errors import TireError, TirefmuWarning, TirError
from tirefmu.symbolic.models import MODELS
from tirefmu.tires import Tire, published, read_tir, tire_from, write_tir
from tirefmu.tires.definition import RANGES
from tirefmu.tires.property_file import other_entries, reading
from tirefmu.tires.property_file import text as form
from tirefmu.tires.property_file.names import MAX_SEARCHED, not_given
from tirefmu.tires.property_file.reading import read_tir_with_notes
from tirefmu.tires.property_file.writing import tir_text

BASE = tir_text(published("trento_hoosier"))
finite = st.floats(allow_nan=False, allow_infinity=False)
positive = st.floats(1e-3, 1e6)
words = st.from_regex(r"[a-z][a-z0-9_]{0,8}", fullmatch=True)
texts = st.text(alphabet=st.one_of(st.characters(), st.sampled_from("'\"\\$!=[]\n\r\t \x85\u2028#{}")))


@st.composite
def tires(draw):
    """Any tire: a file does not require that it is plausible."""
    model = MODELS[draw(st.sampled_from(sorted(MODELS)))]
    ends = {key for pair in RANGES.values() for key in pair}  # drawn as ranges, which are never crossed
    values = draw(st.dictionaries(st.sampled_from(sorted(model.coefficients.keys() - ends)), finite))
    values |= {"FNOMIN": draw(positive), "UNLOADED_RADIUS": draw(positive)}
    effects = draw(st.none() | st.sets(st.sampled_from(sorted(model.effects))))
    ranges = {}
    for name in draw(st.sets(st.sampled_from([*RANGES, "V", "T"]))):
        ranges[name] = tuple(sorted((draw(finite), draw(finite))))
    return Tire(
        model.name,
        values,
        effects=effects,
        signs=draw(st.sampled_from(["iso", "adapted-sae"])),
        name=draw(texts),
        about=draw(st.dictionaries(words, texts, max_size=4)),
        ranges=ranges,
        side=draw(st.sampled_from(["left", "right", ""])),
    )


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("tires")


@given(tire=tires())
def test_written_and_read_is_the_same_tire(folder, tire):
    write_tir(tire, folder / "made.tir")
    again, iso = read_tir(folder / "made.tir"), tire.in_signs("iso")
    assert again == iso
    assert not_given(again) == not_given(iso)
    assert {name: value.hex() for name, value in again.values.items()} == {
        name: value.hex() for name, value in iso.values.items()
    }
    assert tir_text(again) == tir_text(tire)
    # Nothing that another reader takes for a comment.
    assert not set("$!") & set(next((line for line in tir_text(tire).splitlines() if line.startswith("NAME = ")), ""))
    assert [path.name for path in folder.iterdir()] == ["made.tir"]


@pytest.mark.parametrize("key", ["name", "effects", "fittyp", "pky1", "length", "fzmin", "tirefmu_model", "core_pky1"])
def test_metadata_is_never_read_as_values(tmp_path, key):
    tire = replace(published("trento_hoosier"), about={key: "7"}, effects=["camber_thrust"])
    tire.save(tmp_path / "written.tir")
    assert read_tir(tmp_path / "written.tir") == tire.in_signs("iso")


def test_numbers_of_numpy_are_written_as_numbers(tmp_path):
    values = {"FNOMIN": np.float64(1000), "UNLOADED_RADIUS": np.float32(0.25), "PKY1": np.int64(-20)}
    tire = Tire("mf96", values, ranges={"Fz": (np.float64(100), np.float64(2000))})
    tire.save(tmp_path / "numpy.tir")
    assert "np." not in (tmp_path / "numpy.tir").read_text(encoding="utf-8")
    assert read_tir(tmp_path / "numpy.tir") == tire


def test_a_core_tire_is_written_for_readers_without_switches(tmp_path):
    """PKY2 = 1e6 and PKY1 scaled: without the section of tirefmu the file is the same tire with all effects on."""
    core = replace(published("trento_hoosier"), effects=[])
    text = tir_text(core)
    (tmp_path / "others.tir").write_text(text[: text.index("[TIREFMU]")], encoding="utf-8")
    others = read_tir(tmp_path / "others.tir")
    assert others.values["PKY2"] == 1e6
    assert others.values["PKY1"] == -core.values["PKY1"] * 5e5
    assert others.has == set(core.symbolic_model.effects)
    inputs = {"kappa": 0.05, "alpha": np.linspace(-0.2, 0.2, 9), "gamma": 0.03, "Fz": 900.0}
    ours, theirs = core.in_signs("iso").forces(**inputs), others.forces(**inputs)
    for name in ("Fx", "Fy", "Mz"):
        np.testing.assert_allclose(ours[name], theirs[name], rtol=1e-9)


@pytest.mark.parametrize(
    ("replaced", "by", "expected"),
    [
        ("PCY1 = 1", "PCY1 1", "'PCY1 1.1348519668471597' in [LATERAL_COEFFICIENTS] is not 'KEY = value'"),
        ("[VERTICAL]", "[VERTICAL", "section '[VERTICAL' is not closed by ']'"),
        ("FNOMIN = 220.0", "FNOMIN = heavy", "FNOMIN = 'heavy' is not a number"),
        ("FNOMIN = 220.0", "FNOMIN = $", "FNOMIN has no value: a tire needs it"),
        ("FORCE = 'newton'", "FORCE =", "FORCE in [UNITS] has no value"),
        ("FNOMIN = 220.0", "FNOMIN = 0.22 kN", "FNOMIN = '0.22 kN': units are declared in [UNITS] only"),
        ("[VERTICAL]", "[VERTICAL] FNOMIN = 3", "text behind section [VERTICAL]: 'FNOMIN = 3'"),
        ("KPUMIN = -0.3", "KPUMIN = 0.4", "KPUMIN = 0.4 lies above KPUMAX = 0.3"),
        ("FZMAX = 1220.0", "FZMAX = inf", "FZMAX = 'inf' is not a number"),
        ("FITTYP = 96", "FITTYP = 96\nTIREFMU", "'TIREFMU' in [MODEL] is not 'KEY = value'; a comment begins with $"),
        ("TIREFMU_MODEL = 'mf96'", "TIREFMU_MODEL = 'mf69'", "unknown model 'mf69': did you mean mf96?"),
        ("NAME = 'Hoosier", 'NAME = "Hoosier', 'NAME is not a quoted text: "Hoosier'),
        ("NAME = ", "EFFECTS = 'camber_trust' $", "effect of mf96 'camber_trust': did you mean camber_thrust?"),
        ("NAME = ", "EFFECTS = ''\nCORE_PKYI = 1 $", "unknown key CORE_PKYI of mf96: did you mean CORE_PKY"),
    ],
)
def test_a_broken_line_is_named(tmp_path, replaced, by, expected):
    before, middle, after = BASE.partition(replaced)
    assert middle
    line = (before + by).count("\n") + 1
    path = tmp_path / "broken.tir"
    path.write_text(before + by + after, encoding="utf-8")
    with pytest.raises(TirError) as caught:
        read_tir(path)
    message = str(caught.value)
    assert message.startswith(f"{path}:{line}: ")
    assert expected in message
    assert "\n" not in message


def test_a_missing_radius_may_be_given(tmp_path):
    whole = published("trento_hoosier")
    path = tmp_path / "light.tir"
    path.write_text(re.sub(r"UNLOADED_RADIUS = .*\n", "", tir_text(whole)), encoding="utf-8")
    with pytest.raises(TirError, match=r"needs UNLOADED_RADIUS .*--nominal R0=\.\.\., in Python with radius="):
        read_tir(path)
    radius = whole.values["UNLOADED_RADIUS"]
    assert read_tir(path, radius).values == whole.in_signs("iso").values
    assert "UNLOADED_RADIUS is not in the file: 0.5 m was given" in read_tir_with_notes(path, 0.5).notes
    with pytest.raises(TirError, match="radius R0 = 0 m is not a positive number"):
        read_tir(path, 0.0)
    complete = tmp_path / "complete.tir"
    whole.save(complete)
    with pytest.raises(TirError, match="the file states UNLOADED_RADIUS"):
        read_tir(complete, 0.5)
    with pytest.raises(TireError, match="has a radius"):
        tire_from("trento_hoosier", radius=0.5)


SMALL = "[MODEL]\nOTHER = 1\n{}\n[VERTICAL]\nFNOMIN = 1000\n"
NO_TIRE = "no line 'KEY = value' found: not a .tir file"


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (SMALL.format("FITTYP = 97"), "FITTYP 97 is not a model of this version: known are 5 6 21 51 52 (mf52), 60 61"),
        (SMALL.format(""), "no FITTYP in [MODEL]: which model is it?"),
        (SMALL.format("FITTYP = 'PAC'"), "FITTYP = \"'PAC'\" is not a number"),
        (BASE.replace("FNOMIN = 220.0", ""), "light.tir: a tire needs FNOMIN (nominal load F_z0, N)"),
        *((text, f"light.tir: {NO_TIRE}") for text in ("", "\n\n", "a letter to a customer\n", "[MODEL]\n")),
    ],
)
def test_a_file_that_is_not_a_whole_tire(tmp_path, content, message):
    path = tmp_path / "light.tir"
    path.write_text(content, encoding="utf-8")
    with pytest.raises(TirError) as caught:
        read_tir(path)
    assert message in str(caught.value)


def test_a_failed_write_creates_no_file(tmp_path):
    tire = published("trento_hoosier")
    (tmp_path / "a_folder.tir").mkdir()
    with pytest.raises(TirError, match=r"a_folder\.tir: cannot be written"):
        tire.save(tmp_path / "a_folder.tir")
    with pytest.raises(TirError, match="cannot be written"):
        tire.save(tmp_path / "no_such_folder" / "tire.tir")
    assert [path.name for path in tmp_path.rglob("*")] == ["a_folder.tir"]


def test_a_failed_write_preserves_the_old_file(tmp_path, monkeypatch):
    path = tmp_path / "tire.tir"
    path.write_text("the old one", encoding="utf-8")

    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(Path, "replace", full)
    with pytest.raises(TirError, match=r"tire\.tir: cannot be written \(No space left on device\)"):
        published("trento_hoosier").save(path)
    assert path.read_text(encoding="utf-8") == "the old one"
    assert list(tmp_path.iterdir()) == [path]


# ------------------------------------------------------------------ large files


def refused(folder, text, message):
    path = folder / "large.tir"
    path.write_text(text, encoding="ascii")
    with pytest.raises(TirError, match=message) as caught:
        read_tir(path)
    assert len(str(caught.value)) < 1000


def test_a_file_of_any_size_is_one_line(tmp_path):
    refused(tmp_path, BASE + "X = 1\n" * form.MAX_LINES, r"large\.tir: more than 50000 lines")
    refused(tmp_path, BASE + "[X]\nX = " + "9" * form.LONGEST_LINE, r"large\.tir:\d+: longer than 200000")
    refused(tmp_path, BASE + " " * form.MAX_BYTES, r"cannot be read \(larger than 10 MB\)")


@pytest.mark.parametrize("value", ["9" * 100_000, "9" * 100_000 + "x", "1e" + "9" * 100_000, "." + "9" * 100_000])
def test_a_number_with_too_many_digits_is_rejected(tmp_path, value):
    text = BASE + f"[LATERAL_COEFFICIENTS]\nPKY1 = {value}\n"
    refused(tmp_path, text, r"PKY1 = '[1.9][9e]+\.\.\.9+x?' is not a number")


def test_a_number_may_have_all_digits_of_a_double(tmp_path):
    exact = format(Decimal.from_float(5e-324), "f")
    assert len(exact) > 1000
    (tmp_path / "exact.tir").write_text(BASE + f"[LATERAL_COEFFICIENTS]\nPKY1 = {exact}\n", encoding="ascii")
    with pytest.warns(TirefmuWarning, match="given again"):
        assert read_tir(tmp_path / "exact.tir").values["PKY1"] == 5e-324


def test_each_key_is_read_once(tmp_path, monkeypatch):
    """Twice the keys take twice the steps: the search for a coefficient does not visit all keys."""
    steps = []

    class Counted(dict):
        def __iter__(self):
            for key in super().__iter__():
                steps.append(key)
                yield key

    def steps_of(n):
        steps.clear()
        text = BASE + "[OTHER]\n" + "".join(f"OTHER_{i} = {i}\n" for i in range(n))
        (tmp_path / "many.tir").write_text(text, encoding="ascii")
        reader = reading._Reader(tmp_path / "many.tir")
        reader.unread = Counted(reader.unread)
        assert reader.reading().tire.values == published("trento_hoosier").in_signs("iso").values
        return len(steps)

    few, many = steps_of(500), steps_of(1000)
    assert many - few <= 10 * 500


def test_the_search_for_similar_names_is_bounded(tmp_path, monkeypatch):
    searched = []
    monkeypatch.setattr(other_entries, "near_miss", lambda key, names: searched.append(key))
    text = BASE + "[LATERAL_COEFFICIENTS]\n" + "".join(f"OTHER_{i} = {i}\n" for i in range(2 * MAX_SEARCHED))
    (tmp_path / "many.tir").write_text(text, encoding="ascii")
    result = read_tir_with_notes(tmp_path / "many.tir")
    assert len(searched) == MAX_SEARCHED
    assert sum("no similar coefficients are looked for" in note for note in result.notes) == 1


@pytest.mark.parametrize("model", ["mf52", "mf61", "mf62"])
@pytest.mark.parametrize(("load", "pressure"), [(9.0, 2.2e5), (90.0, 5e5), (4000.0, 2.2e5), (1.2e5, 1.4e6)])
def test_an_assumed_range_contains_the_nominal_input(tmp_path, model, load, pressure):
    """Of the tire of a model car, of a bicycle, a car and an aircraft: the limits of a car would take their forces."""
    tire = Tire(model, {"FNOMIN": load, "UNLOADED_RADIUS": 0.3, "INFLPRES": pressure, "NOMPRES": pressure})
    assert tire.values["FZMIN"] < load < tire.values["FZMAX"]
    assert tire.values["PRESMIN"] < pressure < tire.values["PRESMAX"]
    assert tire.ranges == {}
    inputs = pd.DataFrame({"alpha": [0.05], "Fz": [1.2 * load], "p": [pressure]})
    np.testing.assert_allclose(tire.evaluate(inputs, limits=True)["Fy"], tire.evaluate(inputs)["Fy"], rtol=1e-12)
    tire.save(tmp_path / "a.tir")
    again = read_tir(tmp_path / "a.tir")
    assert again.values == tire.values
    assert again.ranges == {}
    again.save(tmp_path / "b.tir")
    assert (tmp_path / "b.tir").read_text(encoding="utf-8") == (tmp_path / "a.tir").read_text(encoding="utf-8")


def test_a_given_end_of_a_range_stays():
    tire = Tire("mf61", {"FNOMIN": 1e5, "UNLOADED_RADIUS": 0.5, "FZMAX": 8e4, "PRESMIN": 3e5})
    assert (tire.values["FZMAX"], tire.values["PRESMIN"]) == (8e4, 3e5)
