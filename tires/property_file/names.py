"""The names of .tir files: numbers of models, keys of coefficients, and other keys in use.

Sources: files of Delft-Tyre's MF-Tool, Goodyear, Adams/Tire (PAC2002) and OptimumT that are public; the readers of
MFeval 4.3 and Project Chrono; the Adams/Tire and MF-Tyre/MF-Swift manuals.
"""

from __future__ import annotations

import difflib
import re
from collections.abc import Collection, Iterable

from ...symbolic.model import Model
from ...symbolic.models import MODELS
from ..definition import TireDefinition
from .text import unquoted

#: Keys in use that no model here reads and that have no unit.
_PLAIN_KEYS = (
    "FILE_VERSION", "PROPERTY_FILE_FORMAT", "TYRESIDE", "TYPE", "FUNCTION_NAME", "CONTACT_MODEL", "FE_METHOD",
    "VENDER_TIRE_TYPE", "FITTYP", "USE_MODE", "USER_SUB_ID", "N_TIRE_STATES", "ROAD_DIRECTION", "MFSAFE1", "MFSAFE2",
    "MFSAFE3", "Q_CAM", "MC_CONTOUR_A", "MC_CONTOUR_B", "DAMP_LONG", "DAMP_LAT", "DAMP_YAW", "DAMP_WINDUP",
    "DAMP_RESIDUAL", "DAMP_VLOW", "Q_BVX", "Q_BVT", "PCMZ1", "ELLIPS_SHIFT", "ELLIPS_LENGTH", "ELLIPS_HEIGHT",
    "ELLIPS_ORDER", "ELLIPS_NWIDTH", "ELLIPS_NLENGTH", "ENV_C1", "ENV_C2", "Q_CFG1", "LGAX", "LGAY", "LGAZ", "LGYR",
    "LCZ", "LIP", "QTZ1", "QFZ1", "QFZ2", "QFZ3", "QPFZ1", "QREO", "QV1", "QV2", "QFCX1", "QFCY1", "QFCG1",
)  # fmt: skip
#: Keys in use that no model here reads, with their SI unit: retained, and converted with the file's units.
OTHER_KEYS: dict[str, str] = {
    **dict.fromkeys(("IXX", "IYY", "BELT_IXX", "BELT_IYY"), "kg m^2"),
    **dict.fromkeys(("MASS", "BELT_MASS", "TIRE_MASS", "MBELT"), "kg"),
    **dict.fromkeys(("RIM_WIDTH", "ROAD_INCREMENT", "ELLIPS_MAX_STEP", "BOTTOMING_RADIUS"), "m"),
    **dict.fromkeys(("HMAX_LOCAL", "TIME_SWITCH_INTEG"), "s"),
    **dict.fromkeys(("FREQ_LONG", "FREQ_LAT", "FREQ_YAW", "FREQ_WINDUP"), "1/s"),
    "GRAVITY": "m/s^2",
    "VERTICAL_DAMPING": "N s/m",
    "BOTTOM_STIFF": "N/m",
    "YAW_STIFFNESS": "N m/rad",
    **dict.fromkeys(_PLAIN_KEYS, "1"),
}
#: Keys of [UNITS] that apply to no entry of a tire file.
IDLE_UNITS = ("TEMPERATURE", "CURRENT", "VOLTAGE")
#: Header of every written file; entries of the file that was read replace them.
HEADER = {"FILE_TYPE": "'tir'", "FILE_VERSION": "3.0", "FILE_FORMAT": "'ASCII'"}

#: Section and unit of an input's range.
RANGE_SECTIONS = {
    "kappa": ("LONG_SLIP_RANGE", "1"),
    "alpha": ("SLIP_ANGLE_RANGE", "rad"),
    "gamma": ("INCLINATION_ANGLE_RANGE", "rad"),
    "Fz": ("VERTICAL_FORCE_RANGE", "N"),
    "p": ("INFLATION_PRESSURE_RANGE", "Pa"),
}

#: The inputs whose range is in no common section, by their key in [TIREFMU_RANGES].
OWN_RANGES = {"V": "V", "phit": "PHIT", "T": "TEMPERATURE", "t": "TIME"}
#: Unknown keys for which a similar coefficient is looked for.
MAX_SEARCHED = 500
#: The section that names the coefficients that were not given.
ASSUMED = "TIREFMU_ASSUMED"
#: The section that names the units of retained entries without a known unit.
KEPT_UNITS = "TIREFMU_KEPT_UNITS"
#: The section with the files of added effects that are not in the library.
ADDED = "TIREFMU_ADDED"
#: The section with what the data of a fit did not show: sentences by key, and a list of coefficients.
NOT_MEASURED, COEFFICIENTS = "TIREFMU_NOT_MEASURED", "COEFFICIENTS"
#: Sections of tirefmu without coefficients.
OWN_SECTIONS = ("TIREFMU", ADDED, "TIREFMU_ABOUT", "TIREFMU_RANGES", ASSUMED, KEPT_UNITS, NOT_MEASURED)

OtherEntry = tuple[str, str, str]


def unit_of(key: str) -> str | None:
    """Return the SI unit of a key in use, or None if it is unknown.

    >>> unit_of("WIDTH"), unit_of("BELT_IYY"), unit_of("PRICE")
    ('m', 'kg m^2', None)
    """
    for model in MODELS.values():
        for section in model.sections:
            if key in section.coefficients:
                return section.coefficients[key].unit
    return OTHER_KEYS.get(key)


def near_miss(key: str, names: Iterable[str]) -> str | None:
    """Return the name that a key resembles, or None; I and 1, and O and 0, count as the same.

    >>> near_miss("PDYI", ["PDY3", "PDY1"]), near_miss("PRICE", ["PDY3", "PDY1"])
    ('PDY1', None)
    """
    digits = str.maketrans("IO", "10")
    matcher = difflib.SequenceMatcher(b=key.translate(digits), autojunk=False)
    best, score = None, 0.7
    for name in names:
        matcher.set_seq1(name.translate(digits))
        # Upper bounds first, the cheapest first of all.
        if matcher.real_quick_ratio() > score and matcher.quick_ratio() > score and matcher.ratio() > score:
            best, score = name, matcher.ratio()
    return best


def aliases() -> frozenset[str]:
    """Return the spellings in use for a coefficient of some model.

    >>> "IP_NOM" in aliases()
    True
    """
    return frozenset(alias for model in MODELS.values() for alias in model.property_file.aliases)


def folded(format_: str) -> str:
    """Return a PROPERTY_FILE_FORMAT without the characters in which spellings differ.

    >>> folded("MF-Tyre"), folded("MF_05")
    ('MFTYRE', 'MF05')
    """
    return "".join(letter for letter in format_.upper() if letter not in "-_ .")


def model_by_coefficients(format_: str, keys: Collection[str]) -> str | None:
    """Return the model of a shared format if a file has coefficients that the other models lack, or None.

    `format_`: PROPERTY_FILE_FORMAT. `keys`: the keys of the file. Of several models it is the one with the highest
    FITTYP, as later models have the coefficients of earlier ones.

    >>> model_by_coefficients("USER", {"PKY6", "Q_CAM3"}), model_by_coefficients("USER", {"PCX1"})
    ('mf62', None)
    """
    sharing = [model for model in MODELS.values() if folded(format_) in map(folded, model.property_file.shared_formats)]
    for model in sorted(sharing, key=lambda model: -max(model.property_file.fittyp, default=0)):
        other = model.property_file.differs_from
        other_names = MODELS[other].coefficients.keys() if other else set()
        if (model.coefficients.keys() - other_names) & set(keys):
            return model.name
    return None


def model_lines(model: Model) -> dict[str, str]:
    """Return the entries of [MODEL] in every written file, by key; those of the file that was read replace them.

    >>> model_lines(MODELS["mf61"])
    {'FITTYP': '61', 'PROPERTY_FILE_FORMAT': "'USER'"}
    """
    file = model.property_file
    number = {"FITTYP": str(file.fittyp[0])} if file.fittyp else {}
    return {**number, "PROPERTY_FILE_FORMAT": f"'{file.written_format}'", **file.header}


def written_sections(model: Model) -> tuple[str, ...]:
    """Return the titles of the sections that are written for any tire of a model, in their order.

    >>> written_sections(MODELS["mf96"])[:4]
    ('MDI_HEADER', 'UNITS', 'MODEL', 'DIMENSION')
    """
    ranges = (title for title, _ in RANGE_SECTIONS.values())
    titles = ["MDI_HEADER", "UNITS", "MODEL", *(section.title for section in model.sections), *ranges]
    return tuple(dict.fromkeys(titles))


def not_given(tire: TireDefinition) -> tuple[str, ...]:
    """Return the coefficients that were not given: at their default, or as other programs assume them.

    `tire`: read from a file, or made from values. The result is in the model's order.

    >>> from tirefmu.tires import Tire
    >>> not_given(Tire("mf96", {name: 1.0 for name in MODELS["mf96"].coefficients if name != "PKY2"}))
    ('PKY2',)
    """
    assumed = {name for section, _, text in tire.other_entries if section == ASSUMED for name in listed(text)}
    missing = [name for name in tire.symbolic_model.coefficients if name in assumed or name in tire.defaulted]
    return tuple(name for name in missing if name not in silent_coefficients(tire))


def silent_coefficients(tire: TireDefinition) -> frozenset[str]:
    """Return the coefficients of added effects that a tire does not have: its file does not contain them."""
    beyond = {effect.name for effect in tire.symbolic_model.added} - tire.has
    return tire.symbolic_model.owned(*sorted(beyond)) if beyond else frozenset()


def assumed_lines(names: Collection[str], model: Model) -> tuple[OtherEntry, ...]:
    """Return the lines of [TIREFMU_ASSUMED] that name coefficients, one for each section.

    >>> assumed_lines({"PKY2", "PKY1"}, MODELS["mf96"])
    (('TIREFMU_ASSUMED', 'LATERAL_COEFFICIENTS', "'PKY1,PKY2'"),)
    """
    by_section = {section.title: [name for name in section.coefficients if name in names] for section in model.sections}
    return tuple((ASSUMED, title, f"'{','.join(those)}'") for title, those in by_section.items() if those)


#: What the coverage of a fit calls a role.
CHARACTERISTICS = {"friction": "peak friction", "stiffness": "slip stiffness", "weighting": "combined slip"}


def not_measured_lines(sentences: Collection[str], coefficients: Iterable[str]) -> tuple[OtherEntry, ...]:
    """Return the lines of [TIREFMU_NOT_MEASURED].

    >>> not_measured_lines(["Fx is not determined: not measured"], ["PCX1"])[1]
    ('TIREFMU_NOT_MEASURED', 'FX', "'Fx is not determined: not measured'")
    """
    names = ",".join(coefficients)
    lines = [(NOT_MEASURED, COEFFICIENTS, f"'{names}'")] if names else []
    keys = [re.sub(r"\W+", "_", _subject(sentence)).upper() for sentence in sentences]
    return (*lines, *((NOT_MEASURED, key, f"'{text}'") for key, text in zip(keys, sentences, strict=True)))


def not_measured(tire: TireDefinition) -> dict[str, str]:
    """Return what the data of the fit of a tire did not show: a sentence for each characteristic.

    >>> from dataclasses import replace
    >>> from tirefmu.tires import published
    >>> tire = published("trento_hoosier")
    >>> not_measured(replace(tire, other_entries=not_measured_lines(["the trail of Mz is not determined: none"], [])))
    {'trail of Mz': 'the trail of Mz is not determined: none'}
    """
    entries = (entry for entry in tire.other_entries if entry[0] == NOT_MEASURED and entry[1] != COEFFICIENTS)
    return {_subject(text): text for text in (unquoted(value) for _, _, value in entries)}


def unmeasured_outputs(tire: TireDefinition) -> frozenset[str]:
    """Return the outputs that the data of the fit of a tire did not show at all.

    >>> from dataclasses import replace
    >>> from tirefmu.tires import published
    >>> tire, sentence = published("trento_hoosier"), "Fx, Mz are not determined: not measured"
    >>> sorted(unmeasured_outputs(replace(tire, other_entries=not_measured_lines([sentence], []))))
    ['Fx', 'Mz']
    """
    subjects = [frozenset(subject.split(", ")) for subject in not_measured(tire)]
    return frozenset[str]().union(*(outputs for outputs in subjects if outputs <= frozenset(tire.outputs)))


def is_measured(tire: TireDefinition, role: str) -> bool:
    """Return whether the data of the fit of a tire determined a friction, a slip stiffness or a weighting of a force.

    A quantity may be known although the data do not separate its coefficients.

    >>> from dataclasses import replace
    >>> from tirefmu.tires import published
    >>> lines = not_measured_lines(["the peak friction of Fx, Fy is not determined: none"], ["PDX1", "PKY1"])
    >>> tire = replace(published("trento_hoosier"), other_entries=lines)
    >>> is_measured(tire, "friction_x"), is_measured(tire, "stiffness_y")
    (False, True)
    """
    kind, _, axis = role.partition("_")
    force, what = f"F{axis}", CHARACTERISTICS[kind]
    unknown = any(
        subject.startswith(f"{what} of ") and force in subject and "not determined" in sentence
        for subject, sentence in not_measured(tire).items()
    )
    return not unknown and force not in unmeasured_outputs(tire)


def unmeasured_coefficients(tire: TireDefinition) -> frozenset[str]:
    """Return the coefficients that the data of the fit of a tire did not determine."""
    texts = [text for section, key, text in tire.other_entries if (section, key) == (NOT_MEASURED, COEFFICIENTS)]
    return frozenset(name for text in texts for name in listed(text)) & tire.symbolic_model.coefficients.keys()


def _subject(sentence: str) -> str:
    return re.split(" is | are ", sentence)[0].removeprefix("the ")


def listed(text: str) -> tuple[str, ...]:
    """Return the names of a list in a file of tirefmu.

    >>> listed("'PKY1, PKY2'")
    ('PKY1', 'PKY2')
    """
    return tuple(name for name in (part.strip() for part in unquoted(text).split(",")) if name)


def in_written_order(entries: Iterable[OtherEntry], model: Model) -> tuple[OtherEntry, ...]:
    """Return retained entries in the order of a written file: by section, in the order of the section.

    >>> entries = [("SHAPE", "", "1 0"), ("MODEL", "USE_MODE", "14"), ("SHAPE", "", "1 1")]
    >>> in_written_order(entries, MODELS["mf96"])
    (('MODEL', 'USE_MODE', '14'), ('SHAPE', '', '1 0'), ('SHAPE', '', '1 1'))
    """
    entries = list(entries)
    order = dict.fromkeys(["", *written_sections(model), *(section for section, _, _ in entries)])
    position = {title: i for i, title in enumerate(order)}
    return tuple(sorted(entries, key=lambda line: position[line[0]]))
