"""The terms of names in other languages, and the words of a name in English."""

from __future__ import annotations

import re
import unicodedata
from functools import lru_cache

#: By English term, what tables in German, French, Italian and Spanish call it.
TERMS: dict[str, tuple[str, ...]] = {
    "time": ("Zeit", "temps", "tempo", "tiempo"),
    "speed": ("Geschwindigkeit", "Fahrgeschwindigkeit", "Fahrzeuggeschwindigkeit", "vitesse", "velocità", "velocidad"),
    "slip": ("Schlupf", "glissement", "scorrimento", "deslizamiento"),
    "longitudinal slip": ("Längsschlupf", "Umfangsschlupf", "glissement longitudinal", "taux de glissement",
                          "scorrimento longitudinale", "deslizamiento longitudinal"),
    "slip angle": ("Schräglaufwinkel", "angle de dérive", "angolo di deriva", "ángulo de deriva"),
    "camber": ("Sturz", "carrossage", "campanatura"),
    "camber angle": ("Sturzwinkel", "angle de carrossage", "angolo di camber", "angolo di campanatura",
                     "ángulo de caída"),
    "wheel load": ("Radlast", "charge à la roue", "carico sulla ruota", "carga de la rueda"),
    "vertical load": ("Vertikallast", "charge verticale", "carico verticale", "carga vertical"),
    "vertical force": ("Vertikalkraft", "Aufstandskraft", "force verticale", "effort vertical", "forza verticale",
                       "fuerza vertical"),
    "pressure": ("Druck", "pression", "pressione", "presión"),
    "inflation pressure": ("Fülldruck", "pression de gonflage", "pressione di gonfiaggio", "presión de inflado"),
    "tire pressure": ("Reifendruck", "Reifenfülldruck", "Reifeninnendruck", "pression du pneu",
                      "pressione del pneumatico", "presión del neumático"),
    "temperature": ("Temperatur", "temperatura"),
    "tire temperature": ("Reifentemperatur", "température du pneu", "temperatura del pneumatico",
                         "temperatura del neumático"),
    "tread temperature": ("Laufflächentemperatur", "température de la bande de roulement",
                          "temperatura del battistrada", "temperatura de la banda de rodadura"),
    "ambient temperature": ("Umgebungstemperatur", "température ambiante", "temperatura ambiente"),
    "air temperature": ("Lufttemperatur", "Außentemperatur", "température de l'air", "temperatura dell'aria",
                        "temperatura del aire"),
    "road temperature": ("Fahrbahntemperatur", "Straßentemperatur", "température de la route",
                         "temperatura dell'asfalto", "temperatura de la calzada"),
    "track temperature": ("Streckentemperatur", "température de la piste", "temperatura della pista"),
    "longitudinal force": ("Längskraft", "Umfangskraft", "force longitudinale", "effort longitudinal",
                           "forza longitudinale", "fuerza longitudinal"),
    "lateral force": ("Seitenkraft", "Querkraft", "force latérale", "effort latéral", "effort transversal",
                      "forza laterale", "fuerza lateral"),
    "aligning moment": ("Rückstellmoment", "moment d'auto-alignement", "couple d'auto-alignement",
                        "momento di autoallineamento", "coppia di autoallineamento", "momento autoalineante",
                        "momento de autoalineación"),
    "overturning moment": ("Kippmoment", "moment de renversement", "momento di ribaltamento", "momento de vuelco"),
    "rolling resistance": ("Rollwiderstand", "Rollwiderstandsmoment", "résistance au roulement",
                           "moment de résistance au roulement", "resistenza al rotolamento",
                           "resistencia a la rodadura"),
    "steering angle": ("Lenkwinkel", "angle de braquage", "angolo di sterzo", "ángulo de dirección"),
    "steering wheel angle": ("Lenkradwinkel", "angle du volant", "angolo del volante", "ángulo del volante"),
    "yaw rate": ("Gierrate", "Giergeschwindigkeit", "Gierwinkelgeschwindigkeit", "vitesse de lacet",
                 "velocità di imbardata", "velocidad de guiñada"),
    "yaw angle": ("Gierwinkel", "angle de lacet", "angolo di imbardata", "ángulo de guiñada"),
    "sideslip": ("Schwimmwinkel", "angolo di assetto"),
    "longitudinal acceleration": ("Längsbeschleunigung", "accélération longitudinale", "accelerazione longitudinale",
                                  "aceleración longitudinal"),
    "lateral acceleration": ("Querbeschleunigung", "accélération latérale", "accélération transversale",
                             "accelerazione laterale", "aceleración lateral"),
    "vertical acceleration": ("Vertikalbeschleunigung", "accélération verticale", "accelerazione verticale",
                              "aceleración vertical"),
    "wheel speed": ("Raddrehzahl", "Radgeschwindigkeit", "vitesse de roue", "velocità della ruota",
                    "velocidad de la rueda"),
    "front": ("vorne", "avant", "anteriore", "delantera"),
    "rear": ("hinten", "arrière", "posteriore", "trasera"),
    "left": ("links", "gauche", "sinistra", "izquierda"),
    "right": ("rechts", "droite", "destra", "derecha"),
}  # fmt: skip
#: Words that a name may have or lack within a term.
_CONNECTING = frozenset(
    ("a", "al", "au", "d", "de", "dei", "del", "dell", "della", "des", "di", "du", "el", "l", "la", "le", "sulla",
     "sur")
)  # fmt: skip
_WORD = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|\d+")
_UMLAUTS = str.maketrans({"ä": "ae", "ö": "oe", "ü": "ue", "Ä": "Ae", "Ö": "Oe", "Ü": "Ue"})


def _split(name: str) -> list[str]:
    """Return the words of a name in lower case and without accents."""
    marks = unicodedata.normalize("NFKD", name.replace("ß", "ss"))
    return [word.casefold() for word in _WORD.findall("".join(m for m in marks if not unicodedata.combining(m)))]


def _joined(words: list[str]) -> str:
    return "".join(word for word in words if word not in _CONNECTING)


#: By term without blanks, accents and connecting words: its words in English.
_ENGLISH = {
    _joined(_split(spelling)): term.split()
    for term, translations in TERMS.items()
    for name in translations
    for spelling in (name, name.translate(_UMLAUTS))
}
#: Words of a name that name the car, a sensor in it or a filter, and do not change its meaning; those behind a unit.
OWNERS = frozenset((
    "car", "vehicle", "veh", "vhcl", "ego", "cg", "cog", "chassis", "body", "imu", "ins", "gnss", "can", "ecu",
    "sensor", "raw", "filtered", "filt", "measured", "meas", "corrected", "corr",
))  # fmt: skip
BEHIND_UNITS = OWNERS | {"gps", "obd", "true", "truth", "est", "estimated", "mean", "avg", "average", "smoothed"}
_BEHIND = re.compile(
    rf"(?:(?:[\s_.]+|(?-i:(?<=[a-z0-9])(?=[A-Z])))(?:{'|'.join(sorted(BEHIND_UNITS))}))+$", re.IGNORECASE
)
#: Words of the longest term, with connecting ones.
_LONGEST = 6


def without_qualifiers(name: str) -> str:
    """Return a name without words of the car, a sensor or a filter behind it.

    >>> without_qualifiers("ay_g_filtered"), without_qualifiers("SpeedKmhRaw"), without_qualifiers("raw")
    ('ay_g', 'SpeedKmh', 'raw')
    """
    return _BEHIND.sub("", name)


@lru_cache(maxsize=8192)
def words_of(name: str) -> tuple[str, ...]:
    """Return the words of a name in lower case, with the terms of other languages in English.

    >>> words_of("Schräglaufwinkel"), words_of("ANGLE_DE_DERIVE"), words_of("SlipAngle2")
    (('slip', 'angle'), ('slip', 'angle'), ('slip', 'angle', '2'))
    """
    written, words, at = _split(name), list[str](), 0
    while at < len(written):
        ends = range(min(len(written), at + _LONGEST), at, -1)
        end = next((end for end in ends if _joined(written[at:end]) in _ENGLISH), None)
        words += written[at : at + 1] if end is None else _ENGLISH[_joined(written[at:end])]
        at = at + 1 if end is None else end
    return tuple(words)
