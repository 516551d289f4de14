"""Words that a file cannot use as names, because generated code, other languages, systems or .tir files use them.

A coefficient becomes a variable in C and Python, a variable of an FMU and a key of a .tir file; an effect becomes a
section of a .tir file and the name of a file. Languages are compared without regard to case: some do not distinguish
cases, and a coefficient called ``FOR`` would be misleading.
"""

from __future__ import annotations

import keyword
import re

LONGEST_NAME = 64

#: Words of each language, in lower case.
_WORDS = {
    # C11, section 6.4.1
    "C": "auto break case char const continue default do double else enum extern float for goto if inline int long "
    "register restrict return short signed sizeof static struct switch typedef union unsigned void volatile while",
    "C++": "alignas alignof and asm bitand bitor bool catch class compl concept constexpr decltype delete explicit "
    "export false friend mutable namespace new noexcept not nullptr operator or private protected public requires "
    "template this throw true try typeid typename using virtual xor",
    "Python": " ".join([*keyword.kwlist, *keyword.softkwlist]).lower(),
    "Modelica": "algorithm annotation block connect connector constant constrainedby der discrete each elseif elsewhen "
    "encapsulated end enumeration equation expandable external final flow function initial inner input loop model "
    "outer output package parameter partial pure record redeclare replaceable stream then time type when within",
    "MATLAB": "ans classdef eps function inf nan otherwise parfor persistent global spmd end",
    "Julia": "abstract baremodule begin let local macro module mutable primitive quote type where",
    "Rust": "become box crate dyn fn impl loop match mod move mut priv pub ref self super trait unsafe use where",
    "JavaScript": "arguments await debugger eval export finally function implements instanceof interface let null "
    "super this throw typeof undefined var with yield",
}
_LANGUAGE_OF = {word: language for language, words in reversed(_WORDS.items()) for word in words.split()}
C_KEYWORDS = frozenset(_WORDS["C"].split())

#: Macros of the C library's headers, those of GNU and POSIX included, and names that generated code defines.
_MACROS = re.compile(
    "I|PI|NAN|INFINITY|NULL|EOF|ERROR|TRUE|FALSE|BOOL|VOID|CONST|IN|OUT|FAR|NEAR|MIN|MAX|DOMAIN|SING|OVERFLOW|UNDERFLOW"
    "|[PT]LOSS|MAXFLOAT|HUGE(_.*)?|SNANF?.*|(DBL|FLT|LDBL|DEC|DECIMAL|FP|M|MATH|INT|UINT|INTMAX|UINTMAX|INTPTR|UINTPTR"
    "|PTRDIFF|SIZE|WCHAR|WINT|SIG|CR|LITTLE|BIG|PDP|BYTE)_.*|U?INT([0-9]|_LEAST|_FAST).*|X_TLOSS"
)
_GENERATED = re.compile(
    "(N|TIREFMU|MF[0-9]+)_.*|MF[0-9]+|LANES|LANES_.*|BLOCK|STRIDE|ROUNDING|LARGEST_[A-Z]+|REDUCTION_IS_EXACT|INPUTS|PARAMETERS"
    "|EXPANDED|CALLED|VECTORS|WIDE|(PAIR|NUMBER)(_.*)?|PANEL|STEP|TILE_[A-Z]+"
    "|COEFFICIENTS|OPTIONS|PLAIN_OPTIONS|QUANTITIES|FORCES|REACH|CONSTANTS|OPERATIONS|[A-Z]+_SLOTS"
    "|ROLLING_RADIUS|LOW_SPEED(_DAMPING)?"
)
#: Names of devices in Windows.
_DEVICES = re.compile("con|prn|aux|nul|com[0-9]|lpt[0-9]")
#: Keys and sections of .tir files with another meaning.
_TIR_KEYS = re.compile(
    "LENGTH|FORCE|ANGLE|MASS|TIME|TEMPERATURE|FITTYP|TYRESIDE|USE_MODE|PROPERTY_FILE_FORMAT|FILE_(TYPE|VERSION|FORMAT)"
    "|NAME|EFFECTS"
)
_TIR_SECTIONS = frozenset(["added", "about", "ranges", "assumed", "kept_units", "not_measured"])

#: The form of names; other names of this form are reserved.
COEFFICIENT_NAME = re.compile("[A-Z][A-Z0-9]*(_[A-Z0-9]+)*")
EFFECT_NAME = re.compile("[A-Za-z][A-Za-z0-9]*(_[A-Za-z0-9]+)*")
STATE_NAME = re.compile("([A-Z]_)?[a-z][a-z0-9]*(_[a-z0-9]+)*")
#: The same in words.
COEFFICIENT_FORM = "a word of capital letters A-Z, digits and single _"
EFFECT_FORM = "a word of letters A-Z, digits and single _"
STATE_FORM = "a word of small letters a-z, digits and single _, such as T_gas"
#: Names in generated code that a state would hide: functions of C and NumPy in lower case, arguments, results.
_HIDDEN = re.compile(
    "(a|f|l|ll)?(abs|sin|cos|tan|exp|log|sqrt|pow)[0-9a-z]*|(sin|cos|tan)h|j[01n]|y[01n]|(l|t)?gamma|erfc?|hypot|cbrt"
    "|fm(a|ax|in|od)|fdim|floor|ceil|round|trunc|r?int|div|index|signgam|nan|inf|inputs|parameters|results|function"
    "|memset|memcpy|time|square|cubed?(_.*)?|cube|fourth|sgn1?|absolute|(fast|called|pair|number|lanes)(_.*)?|ca|np|xp|i|n|model|rows"
)
#: Columns of tables, variables of FMUs and lines that a state would hide.
_PROGRAM = re.compile("t|(kappa|alpha|tan_alpha)_lagged|twist|friction_use|sliding_power")


def no_coefficient(name: str) -> str:
    """Return why a coefficient cannot have a name, or an empty text if it can.

    Returns: the end of a sentence that begins with the name.

    >>> no_coefficient("TMU1"), no_coefficient("NAN"), no_coefficient("WHILE")
    ('', 'is a macro of C', 'is a word of C')
    >>> no_coefficient("tmu")
    'is not a word of capital letters A-Z, digits and single _'
    """
    if not COEFFICIENT_NAME.fullmatch(name):
        return f"is not {COEFFICIENT_FORM}"
    if _MACROS.fullmatch(name):
        return "is a macro of C"
    if _GENERATED.fullmatch(name):
        return "is a name of the generated code"
    return "is a key of .tir files" if _TIR_KEYS.fullmatch(name) else _in_general(name)


def no_effect(name: str) -> str:
    """Return why an effect cannot have a name, or an empty text if it can.

    >>> no_effect("wet_grip"), no_effect("nul"), no_effect("about"), no_effect("größe")
    ('', 'is a device of Windows', 'is a section of .tir files', 'is not a word of letters A-Z, digits and single _')
    """
    if not EFFECT_NAME.fullmatch(name):
        return f"is not {EFFECT_FORM}"
    return "is a section of .tir files" if name.lower() in _TIR_SECTIONS else _in_general(name)


def no_state(name: str) -> str:
    """Return why a state cannot have a name, or an empty text if it can.

    >>> no_state("tread_heat"), no_state("exp"), no_state("Heat")
    ('', 'is a name of the generated code', 'is not a word of small letters a-z, digits and single _, such as T_gas')
    """
    if not STATE_NAME.fullmatch(name):
        return f"is not {STATE_FORM}"
    if _PROGRAM.fullmatch(name):
        return "is a name of the program"
    return "is a name of the generated code" if _HIDDEN.fullmatch(name) else _in_general(name)


def _in_general(name: str) -> str:
    if len(name) > LONGEST_NAME:
        return f"has more than {LONGEST_NAME} characters"
    word = name.lower()
    if word in _LANGUAGE_OF:
        return f"is a word of {_LANGUAGE_OF[word]}"
    return "is a device of Windows" if _DEVICES.fullmatch(word) else ""
