"""The header with which a library reads property files (.tir): keys, units, effects and values of missing keys."""

from __future__ import annotations

import math
import tempfile
from collections.abc import Iterable, Sequence
from pathlib import Path

from tirefmu.symbolic.contract import PropertyFile
from tirefmu.symbolic.escaping import c_string
from tirefmu.symbolic.model import INDISPENSABLE
from tirefmu.symbolic.printers.definitions import comment
from tirefmu.tires import Tire
from tirefmu.tires.definition import RANGES
from tirefmu.tires.property_file.names import IDLE_UNITS, OTHER_KEYS, OWN_SECTIONS, RANGE_SECTIONS, folded, unit_of
from tirefmu.tires.property_file.reading import BODY, STRICT, read_tir
from tirefmu.tires.property_file.units import UNITS, factor_of

from ..description.hub_variables import DEFAULT_BOTTOM, DEFAULT_DAMPING, DEFAULT_DEFLECTION
from ..description.interface import Interface
from ..description.standstill import DEFAULT_LENGTH, LOW_SPEED
from .written_headers import table

#: Values that the wheel and its vertical force need, whether the model has them or not.
WHEEL = (
    "WIDTH", "RIM_RADIUS", "BOTTOM_OFFST", "BOTTOM_RADIUS", "BOTTOM_STIFF", "VERTICAL_DAMPING", "VERTICAL_STIFFNESS",
)  # fmt: skip
_END = -1


def tir_keys(shown: Interface) -> str:
    """Return the header with the tables by which the C code reads the property files of a model.

    Parameters
    ----------
    shown : Interface
        With hub inputs, of a tire without added effects.

    Returns
    -------
    str
        Keys of the file by target: the coefficients, then the values of the wheel and of valid ranges that the model
        does not have.

    Examples
    --------
    >>> from tirefmu.tires import published
    >>> from ..description.interface import interface
    >>> '{"PCY1", "LATERAL_COEFFICIENTS",' in tir_keys(interface(published("trento_hoosier"), inputs="hub"))
    True
    """
    book = shown.tire.book
    targets = list(book.coefficients)
    targets += [name for name in (*WHEEL, *_range_keys(shown)) if name not in targets]
    keys = [*_keys(shown, targets)]
    blank = _blank_tire(shown.tire)
    macros = {
        "MODEL": c_string(book.name), "N_KEYS": len(keys), "TARGETS": len(targets),
        "STANDARD_DAMPING": repr(DEFAULT_DAMPING), "STANDARD_BOTTOM": repr(DEFAULT_BOTTOM),
        "STANDARD_DEFLECTION": repr(DEFAULT_DEFLECTION), "STANDARD_LENGTH": repr(DEFAULT_LENGTH),
        "STANDARD_LOW_SPEED": repr(LOW_SPEED.start), "LEAST_LOW_SPEED": repr(LOW_SPEED.lower),
        **{name: targets.index(name) for name in WHEEL},
        **({"LOW_SPEED": targets.index(book.low_speed)} if book.low_speed else {}),
    }  # fmt: skip
    owned, effects = _effects(shown)
    file = book.property_file
    tables: dict[str, Sequence[str]] = {
        "KEYS": keys,
        "SPELLINGS": [
            f"{{{c_string(spelling.upper())}, {i}, {factor!r}}}"
            for i, known in enumerate(UNITS.values())
            for spelling, factor in known.items()
        ],
        "UNIT_NAMES": [c_string(name) for name in UNITS],
        "IDLE_UNITS": [c_string(name) for name in IDLE_UNITS],
        "SECTIONS": [c_string(title) for title in dict.fromkeys((*STRICT, *(s.title for s in book.sections)))],
        "OWN_SECTIONS": [c_string(title) for title in OWN_SECTIONS],
        "FORMATS": [c_string(folded(name)) for name in file.formats] or ['""'],
        "FITTYPS": [repr(float(number)) for number in file.fittyp] or ["-1.0"],
        "MISSING": [repr(float(value)) for value in blank.parameters()[: len(book.coefficients)]],
        "NEUTRAL": [repr(float(each.neutral or 0.0)) for each in book.coefficients.values()],
        "EFFECT_NAMES": [c_string(name) for name in book.effects],
        "EFFECTS": effects,
        "OWNED": owned,
        "STANDARD": [
            repr(float(value)) for value in Tire(book.name, dict.fromkeys(INDISPENSABLE, 1.0)).values.values()
        ],
        "ASSUMED": [str(int(name not in blank.defaulted)) for name in book.coefficients],
        "NEEDED": [*(str(targets.index(name)) for name in book.own_relaxation), str(_END)],
        "RANGES": [
            f"{{{shown.tire.inputs.index(name)}, {', '.join(str(targets.index(key)) for key in RANGES[name])}}}"
            for name in _ranged(shown)
        ],
    }
    lines = [
        comment("Written by tirefmu for the property files of a model."),
        *(f"#define TIR_{name} {value}" for name, value in macros.items()),
        *(line for name, entries in tables.items() for line in table(f"TIR_{name}", entries)),
    ]
    return "\n".join(lines) + "\n"


def nominal_inputs(shown: Interface) -> list[str]:
    """Return the inputs whose start value is a coefficient, such as the pressure, and its index; -1 is the end."""
    names, coefficients = [v.name for v in shown.contact_inputs], list(shown.tire.book.coefficients)
    found = [(q.name, q.nominal) for q in shown.tire.book.inputs if isinstance(q.nominal, str)]
    pairs = [
        (names.index(name), coefficients.index(key)) for name, key in found if {name} <= set(names) and name != "Fz"
    ]
    return [f"{{{i}, {k}}}" for i, k in [*pairs, (_END, 0)]]


def _keys(shown: Interface, targets: Sequence[str]) -> Iterable[str]:
    """Yield the entries of the table of keys."""
    book = shown.tire.book
    file = book.property_file
    sections = {key: section for name, (section, _) in RANGE_SECTIONS.items() for key in RANGES[name]}
    units = {key: unit for name, (_, unit) in RANGE_SECTIONS.items() for key in RANGES[name]}
    spellings = {known: alias for alias, known in file.aliases.items() if alias not in book.coefficients}
    for target, name in enumerate(targets):
        declared = book.coefficients.get(name)
        if declared is None:
            unit = units.get(name) or unit_of(name) or OTHER_KEYS.get(name, "1")
            section, zero = sections.get(name, ""), False
        else:
            unit, section, zero = declared.unit, declared.section, name in BODY and declared.assumed is not None
        for spelling in filter(None, (name, spellings.get(name) if declared else None)):
            powers = _powers(unit, section, spelling, file)
            flags = f"{target}, {int(spelling != name)}, {int(zero)}"
            yield f"{{{c_string(spelling)}, {c_string(section)}, {{{', '.join(map(str, powers))}}}, {flags}}}"


def _powers(unit: str, section: str, key: str, file: PropertyFile) -> list[int]:
    """Return the powers of a file's units in the unit of a value."""
    if key in file.in_si or section.endswith("_COEFFICIENTS") or section.startswith("TIREFMU"):
        return [0] * len(UNITS)
    return [round(math.log2(factor_of(unit, {name: 2.0}, per_angle=file.per_angle))) for name in UNITS]


def _effects(shown: Interface) -> tuple[list[str], list[str]]:
    """Return the tables of the coefficients that effects own, and of effects."""
    owned: list[str] = []
    effects: list[str] = []
    book = shown.tire.book
    coefficients, on_demand = list(book.coefficients), {effect for effect, _ in book.on_demand}
    for name in book.effects:
        demanded = (1 if name in shown.tire.has else -1) if name in on_demand else 0
        flags = [name in book.default_effects, name in book.relaxing_effects, demanded, len(owned)]
        effects.append(f"{{{', '.join(str(int(flag)) for flag in flags)}}}")
        owned += [*(str(i) for i, key in enumerate(coefficients) if key in book.owned(name)), str(_END)]
    return owned, effects


def _ranged(shown: Interface) -> list[str]:
    """Return the inputs whose valid range files have."""
    return [name for name in RANGES if name in shown.tire.inputs]


def _range_keys(shown: Interface) -> list[str]:
    return [key for name in _ranged(shown) for key in RANGES[name]]


def _blank_tire(tire: Tire) -> Tire:
    """Return what a file means that states the model, a radius and a load only."""
    file = tire.book.property_file
    stated = f"FITTYP = {file.fittyp[0]}" if file.fittyp else f"PROPERTY_FILE_FORMAT = '{file.formats[0]}'"
    with tempfile.TemporaryDirectory(prefix="tirefmu-") as folder:
        path = Path(folder) / "blank.tir"
        path.write_text(f"[MODEL]\n{stated}\nUNLOADED_RADIUS = 1\nFNOMIN = 1\n", encoding="ascii")
        return read_tir(path)
