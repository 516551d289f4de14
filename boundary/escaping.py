"""One escaping function per target for text that comes from files: comments in code, XML, TOML, file names, terminals.

A description in a tire file, a column of a table or the name of a recording is arbitrary text. Wherever such text is
written, it passes the function of its target, which returns ordinary text unchanged and makes everything else visible
and harmless. HTML pages that are not written by Jinja with autoescape take `html_text`.
"""

from __future__ import annotations

import html
import re
import shlex
import unicodedata

#: What XML 1.0 cannot contain, not even escaped (Extensible Markup Language 1.0, section 2.2).
_NOT_XML = re.compile("[^\t\n\r\u0020-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
_SURROGATES = re.compile("[\ud800-\udfff]")
#: What no file name contains on at least one of the three systems, and what a shell or a path takes for its own.
_NOT_IN_FILE_NAMES = re.compile(r"[^\w.+=@,-]", re.UNICODE)
#: File names that Windows reserves for devices, whatever the extension.
_DEVICES = re.compile(r"(?:con|prn|aux|nul|com\d|lpt\d)(?:\.|$)", re.IGNORECASE)
#: The longest text from a file that a message contains, and the longest one in quotes, in characters.
LONGEST_EXCERPT, LONGEST_QUOTED = 300, 80
#: The longest file name that is made of a text, in bytes; file systems allow 255.
LONGEST_FILE_NAME = 120
#: The longest text from a file in a figure, in characters: more does not fit.
LONGEST_IN_FIGURE = 60


def visible(text: str) -> str:
    r"""Return a text on one line, with every character that is not printable as an escape sequence.

    Control characters, terminal escape sequences, line and paragraph separators (U+2028, U+2029), marks that reverse
    the direction of writing and lone surrogates become ``\x1b``, ``\u2028``, ...

    >>> print(visible("a\x1b[2Jb\u2028c °C"))
    a\x1b[2Jb\u2028c °C
    """
    if text.isprintable():  # at once, because pages contain images as text of megabytes
        return text
    return "".join(character if character.isprintable() else _escape(character) for character in text)


def shortened(text: str, most: int) -> str:
    """Return a text limited to a number of characters; both ends of a longer one, as either may be informative.

    `most`: at least 6.

    >>> shortened("run 3.mat", 20), shortened("9" * 1000, 11)
    ('run 3.mat', '9999...9999')
    """
    if len(text) <= most:
        return text
    tail = (most - 3) // 2
    return f"{text[: most - 3 - tail]}...{text[-tail:]}"


def figure_text(text: str) -> str:
    r"""Return a text for a figure: one bounded line.

    >>> print(figure_text("run\n3"), len(figure_text("9" * 1000)))
    run\x0a3 60
    """
    return excerpt(text, LONGEST_IN_FIGURE)


def excerpt(text: object, most: int = LONGEST_EXCERPT) -> str:
    r"""Return a text as a message shows it without quotes: on one line, shortened where it is long.

    >>> print(excerpt("1\n2"), len(excerpt("9" * 1_000_000)))
    1\x0a2 300
    """
    return shortened(visible(shortened(str(text), most)), most)


def quoted(text: object) -> str:
    r"""Return a text in quotes as a message shows it: on one line, shortened where it is long.

    >>> print(quoted("4 kN"), quoted("'4' kN"), quoted("a\nb"))
    '4 kN' "'4' kN" 'a\x0ab'
    """
    inner = excerpt(text, LONGEST_QUOTED)
    mark = '"' if "'" in inner and '"' not in inner else "'"
    return f"{mark}{inner}{mark}"


def ascii_text(text: str) -> str:
    r"""Return a text on one line in printable ASCII; other characters as escape sequences.

    >>> print(ascii_text("30 °C\n"))
    30 \xb0C\x0a
    """
    return "".join(character if " " <= character <= "~" else _escape(character) for character in text)


def c_comment(text: str) -> str:
    r"""Return a text for the inside of a C comment: it cannot end the comment or start another one.

    Trigraphs (``??/`` is a backslash) are broken up as well, and a backslash becomes a slash, so that neither splices
    lines in a ``//`` comment.

    Returns: printable ASCII on one line, to be put between ``/* `` and `` */`` with those blanks.

    Source: ISO/IEC 9899:1999, sections 5.1.1.2, 5.2.1.1 and 6.4.9.

    >>> c_comment("friction */ system(); /* per K")
    'friction * / system(); / * per K'
    >>> c_comment("*/*/ ??/ \\")
    '* / * / ? ?/ /'
    """
    plain = ascii_text(text).replace("\\", "/")
    return re.sub(r"(?<=\*)(?=/)|(?<=/)(?=\*)|(?<=\?)(?=\?)|(?<=/)(?=/)", " ", plain)


def line_comment(text: str) -> str:
    r"""Return a text for a comment up to the end of the line, after a sign and a blank: MATLAB, Julia, LaTeX.

    >>> line_comment("friction\nsystem('x') \\ %{")
    "friction/x0asystem('x') / %{"
    """
    return ascii_text(text).replace("\\", "/")


def latex_text(text: str) -> str:
    r"""Return a text for the body of a LaTeX document: no commands, no mathematics, printable ASCII.

    >>> print(latex_text("50% of $x_1$ \\input{f}"))
    50\% of \$x\_1\$ /input\{f\}
    """
    words = {"~": "\\textasciitilde{}", "^": "\\textasciicircum{}", "<": "\\textless{}", ">": "\\textgreater{}",
             '"': "''", "`": "'"}  # fmt: skip
    return "".join(
        words.get(character, f"\\{character}" if character in "#$%&_{}" else character)
        for character in ascii_text(text).replace("\\", "/")
    )


def c_string(text: str) -> str:
    r"""Return a C string literal with its quotes.

    `text`: written in UTF-8, as FMI has its strings. Returns: bytes that are not printable ASCII, quotes, backslashes,
    question marks (trigraphs) and percent signs (the text may become a format) as three octal digits.

    >>> print(c_string('say "é" 5%'))
    "say \042\303\251\042 5\045"
    """
    plain = set(range(0x20, 0x7F)) - set(b'"\\?%')
    return '"' + "".join(chr(byte) if byte in plain else f"\\{byte:03o}" for byte in _utf8(text)) + '"'


def python_comment(text: str) -> str:
    r"""Return a text for the inside of a Python comment or docstring: it cannot end either.

    >>> python_comment('friction\"\"\"\nimport os')
    "friction'''/x0aimport os"
    """
    return ascii_text(text).replace("\\", "/").replace('"', "'")


def xml_text(text: str) -> str:
    r"""Return a text without what XML 1.0 cannot contain; the writer of the XML escapes markup and quotes.

    >>> xml_text("a\x00b")
    'a\ufffdb'
    """
    return _NOT_XML.sub("\ufffd", text)


def html_text(text: str) -> str:
    r"""Return a text for the inside of an HTML element or attribute: no markup, every character visible.

    >>> html_text("<b>&\x00")
    '&lt;b&gt;&amp;\\x00'
    """
    return html.escape(visible(text))


def command_text(command: str, *arguments: object) -> str:
    """Return a command line of tirefmu as a shell takes it.

    `*arguments`: operands, options and their values. None is omitted.

    >>> command_text("run", "my tires/tirefmu.toml")
    "tirefmu run 'my tires/tirefmu.toml'"
    """
    return shlex.join(["tirefmu", command, *(str(each) for each in arguments if each is not None)])


def script_text(code: str) -> str:
    r"""Return JavaScript for the inside of an HTML script element: it cannot end the element or start a comment.

    `code`: without comments and texts: there, every sign < is a comparison or a shift.

    Source: HTML Living Standard, section "Restrictions for contents of script elements".

    >>> script_text("a<b && c</d/.x")
    'a< b && c< /d/.x'
    """
    return re.sub("<(?=[A-Za-z/!?])", "< ", code)


def script_json(text: str) -> str:
    r"""Return JSON for the inside of an HTML script element: it cannot end the element or start a comment.

    >>> print(script_json('["</script>"]'))
    ["\u003c/script>"]
    """
    return text.replace("<", "\\u003c")


def toml_string(text: str) -> str:
    r"""Return a basic string of TOML with its quotes.

    Source: TOML 1.0.0, section "String".

    >>> print(toml_string('a "b"\n\x7f'))
    "a \"b\"\n\u007f"
    """
    named = {"\\": "\\\\", '"': '\\"', "\n": "\\n", "\r": "\\r", "\t": "\\t"}
    plain = (named.get(c) or (c if c.isprintable() else _toml_escape(c)) for c in _SURROGATES.sub("\ufffd", text))
    return '"' + "".join(plain) + '"'


def file_name(text: str, otherwise: str = "unnamed") -> str:
    """Return a file name made of a text: one part of a path, on Linux, macOS and Windows.

    `otherwise`: the name of a text of which nothing remains. Returns: letters, digits and ``_ . + = @ , -``; never
    hidden, never a device, at most `LONGEST_FILE_NAME` bytes.

    >>> file_name("../../etc/passwd"), file_name("run 3: 40 °C.mat"), file_name("con.txt"), file_name("..")
    ('etc_passwd', 'run_3_40_C.mat', '_con.txt', 'unnamed')
    """
    words = _NOT_IN_FILE_NAMES.sub("_", unicodedata.normalize("NFC", text))
    name = re.sub("_+", "_", words.encode(errors="ignore").decode()).strip("._-")
    name = name.encode()[:LONGEST_FILE_NAME].decode(errors="ignore").rstrip(".")
    return f"_{name}" if _DEVICES.match(name) else name or otherwise


def _escape(character: str) -> str:
    code = ord(character)
    return f"\\x{code:02x}" if code < 0x100 else f"\\u{code:04x}" if code < 0x10000 else f"\\U{code:08x}"


def _utf8(text: str) -> bytes:
    return text.encode("utf-8", errors="replace")


def _toml_escape(character: str) -> str:
    code = ord(character)
    return f"\\u{code:04x}" if code < 0x10000 else f"\\U{code:08x}"
