"""Common parts of generated C files: includes, comments, definitions.

Each file gets the definitions that it uses, directly or indirectly. A file with more would not compile without
warnings: clang reports unused static functions. Definitions are in headers in this folder, one per paragraph, in an
order in which each uses only earlier ones.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import lru_cache
from importlib.resources import files

from ...boundary.escaping import c_comment

#: What refuses a compiler that takes NaN for a number: comparisons would turn a load of NaN into no force.
IEEE_ONLY = """\
#if defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__) || defined(_M_FP_FAST)
#error "NaN has to stay NaN: compile without -ffast-math, -Ofast, -ffinite-math-only and /fp:fast"
#endif"""
INCLUDES = f"{IEEE_ONLY}\n\n#include <float.h>\n#include <math.h>\n#include <stdint.h>\n#include <string.h>"
#: The headers, in the order in which they are printed.
PLAIN = ("vectors.h", "arithmetic.h", "elementary.h")
KERNEL = (*PLAIN, "lanes.h", "blocks.h", "normal_equations.h")

_COMMENT = re.compile(r"/\*.*?\*/", re.DOTALL)
_DEFINED = re.compile(r"^#define (\w+)|^typedef \w+ (\w+)|^static [^([]*?(\w+)[(\[]", re.MULTILINE)
_CALL_OF_FAST = re.compile(r"\bfast_(sin|cos|tan|atan|exp|pow)\(")


@dataclass(frozen=True)
class Definition:
    """A paragraph of a header.

    - `names`: the names that it defines; none if it is a remark on all following paragraphs.
    - `uses`: the identifiers in it.
    """

    text: str
    names: frozenset[str]
    uses: frozenset[str]


def comment(*lines: str) -> str:
    """Return a comment of one or more lines. All text in generated C is written by this function.

    >>> comment("grip */ int x; /*")
    '/* grip * / int x; / * */'
    """
    inner = "\n   ".join(map(c_comment, lines))
    return f"/* {inner} */"


def definitions(code: str, headers: tuple[str, ...] = PLAIN) -> str:
    r"""Return the definitions that some code uses, and those that they use.

    `code`: C. `headers`: `PLAIN` or `KERNEL`. Returns: empty if it uses none.

    >>> print(definitions("double f(double x) { return cubed_sqrt(x) + PI; }"))
    #define PI 3.14159265358979323846
    <BLANKLINE>
    static inline double cubed_sqrt(double x) { return x*sqrt(x); }
    """
    used, parts = set(_identifiers(code)), []
    for header in reversed(headers):
        chosen: list[str] = []
        for definition in reversed(_paragraphs(header)):
            if definition.names & used or (chosen and not definition.names):
                used |= definition.uses
                chosen.append(definition.text)
        parts += chosen
    return "\n\n".join(reversed(parts))


def calling_math(code: str) -> str:
    """Return code that calls the functions of math.h instead of the fast ones: slower, smaller, with other roundings.

    >>> calling_math("y = fast_atan(fast_sin(x));")
    'y = atan(sin(x));'
    """
    return _CALL_OF_FAST.sub(r"\1(", code)


def calling_functions(code: str) -> str:
    """Return code that calls the fast functions, which compilers would expand at each call: the same digits.

    >>> calling_functions("y = fast_atan(fast_sin(x));")
    'y = called_atan(called_sin(x));'
    """
    return _CALL_OF_FAST.sub(r"called_\1(", code)


@lru_cache(maxsize=8)
def _paragraphs(header: str) -> tuple[Definition, ...]:
    text = (files(__package__) / header).read_text(encoding="ascii").strip()
    return tuple(map(_definition, text.split("\n\n")))


def _definition(text: str) -> Definition:
    names = {name for groups in _DEFINED.findall(_COMMENT.sub("", text)) for name in groups if name}
    return Definition(text, frozenset(names), frozenset(_identifiers(text)))


def _identifiers(code: str) -> list[str]:
    return re.findall(r"[A-Za-z_]\w*", _COMMENT.sub("", code))
