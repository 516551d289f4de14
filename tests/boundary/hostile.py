"""Texts that could be interpreted as code or markup, for every target."""

from __future__ import annotations

from hypothesis import strategies as st

NASTY = (
    "",
    '*/ __attribute__((constructor)) static void f(void) { system("touch ran"); } /*',
    "*/*/ /* // ??/",
    "*??/\n/ int x; /*",
    "*\\\n/ int x; //\\",
    '"""\nimport os\nos.system("touch ran")\n"""',
    "\\",
    '\\"""',
    "a\r\nb\rc\nd\x0be\x0cf\x85g\u2028h\u2029i",
    "\x00\x1b[2J\x1b]0;title\x07\x9b\x7f",
    "\u202eesrever\u200b\ufeff\ud800",
    "\"><script>alert(1)</script><p a='&amp;&#0;",
    "]]> <!-- --> <?xml ?> <![CDATA[",
    '"\n[coefficients]\nA = {}',
    "'$!#%n%s{}\\u0022",
    "..\\../../etc/passwd",
    "CON.txt",
    "é ° 摩 \U0001f600",
)
#: Pieces with a meaning in some target.
_PIECES = [
    "*", "/", "\\", "?", "*/", "/*", "//", "??/", "??=", '"', "'", '"""', "'''", "\n", "\r", "\t", "\x00", "\x0b",
    "\x1b", "\x7f", "\x85", "\u2028", "\u2029", "\u202e", "\ud83d", "#", "$", "!", "%", "<", ">", "&", "{", "}",
    "[", "]", "=", "int x;", "import os", "é", "a", " ",
]  # fmt: skip


def hostile_texts(longest: int = 40) -> st.SearchStrategy[str]:
    """Return texts made of pieces with a meaning, or of any characters, lone surrogates among them."""
    pieces = st.lists(st.sampled_from(_PIECES), max_size=longest // 3).map("".join)
    return st.one_of(pieces, st.text(max_size=longest))
