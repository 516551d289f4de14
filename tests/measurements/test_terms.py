"""Names in other languages mean what their English term means, in every spelling, for tables and logs."""

from __future__ import annotations

import unicodedata

import numpy as np
import pandas as pd
import pytest

from tirefmu.applications.driving.inputs.nearest_channel import nearest_channel
from tirefmu.boundary.errors import DataError
from tirefmu.measurements import TERMS, read_recording, words_of
from tirefmu.measurements.column_names import intended_channel
from tirefmu.measurements.files.columns.content import Column

SPELLED = {
    "as declared": str,
    "upper": str.upper,
    "snake": lambda name: name.replace(" ", "_").replace("'", "_"),
    "camel": lambda name: "".join(word[:1].upper() + word[1:] for word in name.replace("'", " ").split()),
    "without accents": lambda name: "".join(
        mark for mark in unicodedata.normalize("NFKD", name) if not unicodedata.combining(mark)
    ),
    "decomposed": lambda name: unicodedata.normalize("NFD", name),
    "umlauts as two letters": lambda name: (
        name.replace("ä", "ae").replace("ö", "oe").replace("ü", "ue").replace("ß", "ss")
    ),
    "without connecting words": lambda name: " ".join(
        word for word in name.split() if word not in ("de", "di", "du", "del", "della", "la")
    ),
}


@pytest.mark.parametrize("spelling", SPELLED)
def test_a_translation_has_the_words_of_its_term(spelling):
    for term, translations in TERMS.items():
        for name in translations:
            assert words_of(SPELLED[spelling](name)) == tuple(term.split()), name


def test_no_name_is_that_of_two_terms():
    names = [name for translations in TERMS.values() for name in translations]
    assert len(names) == len(set(names))


@pytest.mark.parametrize(
    "name", ["Fy_L", "alpha_d", "d", "la", "Slip_a", "temperature", "SlipAngle", "camber_angle", "front_left", "De"]
)
def test_an_english_name_keeps_its_words(name):
    assert "".join(words_of(name)) == name.replace("_", "").casefold()


#: Of each channel that benches and drives have: a name in every language.
BENCH = {
    "kappa": ("Längsschlupf", "taux de glissement", "scorrimento longitudinale", "deslizamiento longitudinal"),
    "alpha": ("Schräglaufwinkel", "angle de dérive", "angolo di deriva", "ángulo de deriva"),
    "gamma": ("Sturz", "carrossage", "campanatura", "ángulo de caída"),
    "Fz": ("Radlast", "charge verticale", "carico verticale", "carga vertical"),
    "p": ("Reifendruck", "pression de gonflage", "pressione di gonfiaggio", "presión de inflado"),
    "V": ("Geschwindigkeit", "vitesse", "velocità", "velocidad"),
    "Fx": ("Längskraft", "effort longitudinal", "forza longitudinale", "fuerza longitudinal"),
    "Fy": ("Seitenkraft", "effort latéral", "forza laterale", "fuerza lateral"),
    "Mz": ("Rückstellmoment", "moment d'auto-alignement", "momento di autoallineamento", "momento autoalineante"),
}
DRIVE = {
    "t": ("Zeit", "temps", "tempo", "tiempo"),
    "steer": ("Lenkradwinkel", "angle volant", "angolo volante", "ángulo del volante"),
    "speed": ("Fahrgeschwindigkeit", "vitesse", "velocità", "velocidad"),
    "yaw_rate": ("Gierrate", "vitesse de lacet", "velocità di imbardata", "velocidad de guiñada"),
    "ax": ("Längsbeschleunigung", "accélération longitudinale", "accelerazione longitudinale",
           "aceleración longitudinal"),
    "ay": ("Querbeschleunigung", "accélération latérale", "accelerazione laterale", "aceleración lateral"),
    "omega_fl": ("Raddrehzahl vorne links", "vitesse roue avant gauche", "velocità ruota anteriore sinistra",
                 "velocidad rueda delantera izquierda"),
}  # fmt: skip
UNITS = {"kappa": ("%", 100.0), "alpha": ("°", np.degrees(1.0)), "gamma": ("deg", np.degrees(1.0)), "Fz": ("kN", 1e-3),
         "p": ("bar", 1e-5), "V": ("km/h", 3.6), "Fx": ("N", 1.0), "Fy": ("kN", 1e-3), "Mz": ("Nm", 1.0)}  # fmt: skip


def bench_table() -> pd.DataFrame:
    """Return sweeps of both slips at three loads, in the signs of iso."""
    sweep = np.sin(np.linspace(0.0, 6.0 * np.pi, 600))
    held = np.repeat([400.0, 800.0, 1200.0], 400)
    alpha, kappa = np.r_[0.2 * sweep, 0.0 * sweep], np.r_[0.0 * sweep, 0.2 * sweep]
    Fy, Fx = -1.3 * held * np.tanh(9.0 * alpha), 1.3 * held * np.tanh(12.0 * kappa)
    return pd.DataFrame({"kappa": kappa, "alpha": alpha, "gamma": 0.0, "Fz": held, "p": 83e3, "V": 11.2, "Fx": Fx,
                         "Fy": Fy, "Mz": -0.02 * Fy})  # fmt: skip


def test_channels_of_drives():
    for channel, names in DRIVE.items():
        assert [nearest_channel(Column(name, [])) for name in names] == [channel] * 4


@pytest.mark.parametrize("language", range(4))
@pytest.mark.parametrize("comma", [False, True])
def test_the_suggested_option_reads_the_whole_table(tmp_path, language, comma):
    table = bench_table()
    written = pd.DataFrame(
        {f"{BENCH[name][language]} [{unit}]": table[name] * factor for name, (unit, factor) in UNITS.items()}
    )
    path = tmp_path / "a.csv"
    written.to_csv(path, index=False, sep=";" if comma else ",", decimal="," if comma else ".", encoding="utf-8")
    assert [intended_channel(header) for header in written] == list(UNITS)
    with pytest.raises(DataError, match="All such columns: --columns ") as refusal:
        read_recording(path)
    option = str(refusal.value).partition("--columns ")[2].strip("'").replace("'\"'\"'", "'")
    read = read_recording(path, columns=dict(text.split("=") for text in option.split(","))).table
    for name in UNITS:
        np.testing.assert_allclose(read[name], table[name], rtol=1e-12, atol=1e-15)


@pytest.mark.parametrize(
    "spelled", ["{0}_{1}_raw", "{0}_{1}", "{0}_FL_{1}", "{0}_{1}_filtered.avg", "{0}_{1}_rr", "{0} {1} Mean"]
)
def test_the_suggested_option_has_the_units_of_names_without_brackets(tmp_path, spelled):
    """Also before a wheel, and before words of a sensor or of a filter."""
    table = bench_table().drop(columns="gamma")
    units = {name: (unit, factor) for name, (unit, factor) in UNITS.items() if name in table}
    written = {
        spelled.format(name, unit.replace(" ", "")): table[name] * factor for name, (unit, factor) in units.items()
    }
    pd.DataFrame(written).to_csv(tmp_path / "a.csv", index=False)
    with pytest.raises(DataError, match="All such columns: --columns ") as refusal:
        read_recording(tmp_path / "a.csv")
    option = str(refusal.value).partition("--columns ")[2].strip("'")
    read = read_recording(tmp_path / "a.csv", columns=dict(text.split("=") for text in option.split(","))).table
    for name in units:
        np.testing.assert_allclose(read[name], table[name], rtol=1e-12, atol=1e-15)
