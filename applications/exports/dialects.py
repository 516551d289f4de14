"""Which property files (.tir) other programs accept: declared per host, from public documentation.

Sources: the Adams/Tire help ("Defining and Reading Tire Property Files"); the Altair MotionView/MotionSolve help
("Reduced Tire Input Properties", quoting the MF-Tyre/MF-Swift manual); the source of Project Chrono (ChPac02Tire.cpp,
commit 7689fbc); the behaviour of MFeval 4.3; the CarMaker FAQ of IPG. What none of them states is a note of the host.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

#: Effects over time: hosts have coefficients, but use their own models.
TRANSIENT = ("relax_lat", "relax_lon", "relax_load")
PRESSURE = ("pressure_stiffness", "pressure_friction", "pressure_trail", "pressure_moment")


#: Coefficients of tirefmu's MF5.2 that came with MF6.1: MFeval reads them in files of MF5.2, other programs do not.
#: Checked with the formulas of Chrono (ChPac02Tire.cpp) and OpenTire (PAC2002_Core.py).
SINCE_MF61 = (
    "RBX3", "PEY5", "PKY4", "PKY5", "RBY4", "QBZ6", "QDZ10", "QDZ11", "QSX12", "QSX13", "QSX14",
)  # fmt: skip


@dataclass(frozen=True)
class Dialect:
    """How a host expects the file of one model.

    - `entries`: what conversion writes into [MODEL], by key.
    - `formats`: accepted values of PROPERTY_FILE_FORMAT; empty: the host ignores it.
    - `fittyp`: accepted values of FITTYP; empty: the host ignores it.
    - `use_modes`: accepted values of USE_MODE; empty: any.
    - `fe_methods`: accepted values of FE_METHOD; empty: the host ignores it.
    - `required`: keys that the host requires.
    - `lacking`: published coefficients of tirefmu's model that the host's does not have: they must be neutral, as those
      that the published model does not have (`lacking.lacked`).
    """

    entries: Mapping[str, str]
    formats: tuple[str, ...] = ()
    fittyp: tuple[int, ...] = ()
    use_modes: tuple[int, ...] = ()
    fe_methods: tuple[str, ...] = ()
    required: tuple[str, ...] = ()
    lacking: tuple[str, ...] = ()


@dataclass(frozen=True)
class Host:
    """A program that reads property files.

    - `dialects`: by model; the first is that of a conversion for which no model is requested.
    - `units`: accepted units by key of [UNITS].
    - `ignored`: effects of the models that the host does not evaluate.
    - `longest_line`: longest line in characters; 0: no limit known.
    - `expects_crlf`: its own tools write lines with CRLF.
    - `cuts_lines`: its reader takes the last two characters of every line for CRLF.
    - `tables`: the sections in which it reads rows without a key; empty: any.
    - `notes`: what is known to differ, or is not known.
    """

    title: str
    source: str
    dialects: Mapping[str, Dialect]
    units: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    ignored: tuple[str, ...] = ()
    longest_line: int = 0
    expects_crlf: bool = True
    cuts_lines: bool = False
    tables: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()


#: Keys that MF-Tyre/MF-Swift requires.
_MF_TYRE = ("FITTYP", "UNLOADED_RADIUS", "WIDTH", "FNOMIN")
_PAC2002 = Dialect(
    {"PROPERTY_FILE_FORMAT": "'PAC2002'", "FITTYP": "6", "USE_MODE": "14"},
    ("PAC2002",), use_modes=(0, 1, 2, 3, 4, 10, 11, 12, 13, 14),
    required=("UNLOADED_RADIUS", "FNOMIN", "VERTICAL_STIFFNESS"), lacking=SINCE_MF61,
)  # fmt: skip
_FIALA = Dialect(
    {"PROPERTY_FILE_FORMAT": "'FIALA'", "USE_MODE": "2"},
    ("FIALA",), required=("UNLOADED_RADIUS", "WIDTH", "VERTICAL_STIFFNESS", "CSLIP", "CALPHA", "UMIN", "UMAX"),
)  # fmt: skip


def _mf_tyre(fittyp: int, *also: int) -> Dialect:
    entries = {"PROPERTY_FILE_FORMAT": "'USER'", "FITTYP": str(fittyp), "USE_MODE": "124"}
    lacking = SINCE_MF61 if fittyp == 6 else ()
    return Dialect(entries, ("USER", "MF-TYRE", "MF-SWIFT"), (fittyp, *also), required=_MF_TYRE, lacking=lacking)


_ALL_MF = {"mf61": _mf_tyre(61, 60), "mf62": _mf_tyre(62), "mf52": _mf_tyre(6, 21)}
_ANY_TRANSIENT = "transient slip is computed by the host's own model, from the same coefficients"

HOSTS: dict[str, Host] = {
    "adams": Host(
        "Adams/Tire (PAC2002, Fiala)",
        "Adams/Tire help, Defining and Reading Tire Property Files",
        {"mf52": _PAC2002, "fiala": _FIALA},
        ignored=("turn_slip",),
        notes=(_ANY_TRANSIENT, "MF6.1 and MF6.2 need the separate MF-Tyre/MF-Swift library: use --for simcenter"),
    ),
    "motionsolve": Host(
        "Altair MotionSolve (MF-Tyre/MF-Swift, PAC2002, Fiala)",
        "Altair help, Reduced Tire Input Properties",
        {**_ALL_MF, "fiala": _FIALA},
        notes=(_ANY_TRANSIENT,),
    ),
    "simcenter": Host(
        "Simcenter Tire (MF-Tyre/MF-Swift)",
        "MF-Tyre/MF-Swift manual, as quoted by the Altair help",
        _ALL_MF,
        notes=(_ANY_TRANSIENT,),
    ),
    "carmaker": Host(
        "IPG CarMaker (MF5.2, MF6.1)",
        "CarMaker FAQ; CarMaker imports a .tir with its Tire Editor or an InfoFile",
        {"mf61": _mf_tyre(61, 60), "mf52": _mf_tyre(6, 21)},
        notes=(
            _ANY_TRANSIENT,
            "the rules of the import are not public; a user of CarMaker 12 reports that it refuses FITTYP 6",
        ),
    ),
    "carsim": Host(
        "CarSim (imported .tir)",
        "no public description of the import; the keys are those of MF-Tyre/MF-Swift",
        {"mf61": _mf_tyre(61, 60), "mf52": _mf_tyre(6, 21)},
        notes=(_ANY_TRANSIENT, "the rules of the import are not public: this file is not verified with CarSim"),
    ),
    "chrono": Host(
        "Project Chrono (ChPac02Tire, ChFialaTire)",
        "Project Chrono, ChPac02Tire.cpp, commit 7689fbc",
        {
            "mf52": Dialect(
                {
                    "PROPERTY_FILE_FORMAT": "'PAC2002'", "FITTYP": "6", "USE_MODE": "4", "FE_METHOD": "'NO'",
                },
                ("PAC2002", "MF_05"), use_modes=(3, 4),
                # Without it Chrono takes a friction ellipse for combined slip.
                fe_methods=("NO",),
                required=(
                    "USE_MODE", "FE_METHOD", "UNLOADED_RADIUS", "WIDTH", "FNOMIN", "VERTICAL_STIFFNESS", "VXLOW",
                    "LONGVL",
                ),
                lacking=SINCE_MF61,
            ),
        },
        units={"LENGTH": ("METER",), "FORCE": ("NEWTON",), "ANGLE": ("RAD", "RADIAN", "RADIANS", "DEG"),
               "MASS": ("KG",), "TIME": ("SECOND",)},
        ignored=("turn_slip", *TRANSIENT, *PRESSURE),
        longest_line=200,
        expects_crlf=False,
        notes=(
            "Chrono evaluates with the opposite sign of the slip angle: terms of plysteer and conicity are mirrored",
            "QSY1, QSY2 and QSY8 are zero in every file, so that the tire has no constant rolling resistance, and so is"
            " every coefficient of pressure",
            "inclination has no effect on a vehicle: the angle that the forces read is never set",
            "alpha is the angle, not its tangent; slip is limited to -1..1; LMUY also scales the cornering stiffness",
            "B times slip is limited to 1.56: forces beyond differ (two tested tires: by up to 11 %); at kappa = 0,"
            " USE_MODE 4 computes Mz with the trail at zero slip angle",
        ),
    ),
    "mfeval": Host(
        "MFeval (MATLAB, Simulink)",
        "MFeval 4.3: FITTYP 6 and 21 are MF5.2, 62 is MF6.2, every other value MF6.1",
        {
            "mf61": Dialect({"PROPERTY_FILE_FORMAT": "'USER'", "FITTYP": "61"}, fittyp=(60, 61), required=("FITTYP",)),
            "mf62": Dialect({"PROPERTY_FILE_FORMAT": "'USER'", "FITTYP": "62"}, fittyp=(62,), required=("FITTYP",)),
            "mf52": Dialect({"PROPERTY_FILE_FORMAT": "'USER'", "FITTYP": "6"}, fittyp=(6, 21), required=("FITTYP",)),
        },
        ignored=TRANSIENT,
        cuts_lines=True,
        tables=("SHAPE",),
    ),
}  # fmt: skip
