"""One escaping function per target: any text is read back as the same text."""

from __future__ import annotations

import ast
import html.parser
import re
import tokenize
import tomllib
import xml.etree.ElementTree as ET
from io import StringIO

import pytest
from hypothesis import example, given, settings

from tirefmu.boundary import escaping

from .hostile import NASTY, hostile_texts

cheap = settings(max_examples=150, deadline=None)


def of_all(test):
    """Test every known hostile text and random ones."""
    test = cheap(given(hostile_texts())(test))
    for text in NASTY:
        test = example(text)(test)
    return test


@of_all
def test_a_c_comment_ends_where_it_is_written_to_end(text):
    inner = escaping.c_comment(text)
    assert all(" " <= character <= "~" for character in inner)
    for written in (f"/* {inner} */", f"/*{inner} */"):
        assert re.match(r"/\*.*?\*/", written)[0] == written
        assert written.count("/*") == 1
    assert not set(re.findall(r"\?\?.", inner))
    assert "\\" not in inner


@of_all
def test_a_c_string_has_the_bytes_of_the_text(text):
    literal = escaping.c_string(text)
    assert re.fullmatch(r'"(?:[^"\\?%\n]|\\[0-7]{3})*"', literal)
    assert literal.isascii()
    octal = re.sub(rb"\\([0-7]{3})", lambda match: bytes([int(match[1], 8)]), literal[1:-1].encode())
    assert octal == text.encode(errors="replace")


@of_all
def test_a_python_comment_or_docstring_is_no_code(text):
    inner = escaping.python_comment(text)
    code = f'"""{inner}"""\nx = 1  # {inner}\n# {inner}\ny = 2\n'
    assert ast.dump(ast.parse(code)) == ast.dump(ast.parse(f"{inner!r}\nx = 1\ny = 2\n"))
    kinds = [token.type for token in tokenize.generate_tokens(StringIO(code).readline)]
    assert kinds.count(tokenize.COMMENT) == 2


@of_all
def test_xml_holds_the_text_but_for_what_xml_cannot(text):
    root = ET.Element("a", {"b": escaping.xml_text(text)})
    again = ET.fromstring(ET.tostring(root, encoding="utf-8")).attrib["b"]
    assert again == escaping.xml_text(text)
    assert len(again) == len(text)
    assert all(a == b or a == "\ufffd" for a, b in zip(again, text, strict=True))


@of_all
def test_toml_reads_the_same_text(text):
    written = escaping.toml_string(text)
    assert written.isprintable()
    assert tomllib.loads(f"a = {written}\nb = 1\n") == {"a": re.sub("[\0\ud800-\udfff]", "\ufffd", text), "b": 1}


@of_all
def test_html_has_one_text_and_no_element(text):
    seen = []

    class Parser(html.parser.HTMLParser):
        def handle_starttag(self, tag, attributes):
            seen.append((tag, attributes))

        def handle_data(self, data):
            seen.append(data)

    inner = escaping.html_text(text)
    parser = Parser()
    parser.feed(f'<p title="{inner}">{inner}</p>')
    parser.close()
    shown = [escaping.visible(text)] if text else []
    assert seen == [("p", [("title", escaping.visible(text))]), *shown]


@of_all
def test_displayed_text_is_one_printable_line(text):
    assert escaping.visible(text).isprintable()
    assert escaping.quoted(text).isprintable()
    assert len(escaping.quoted("\U0001f600" * 1000)) < 100
    assert escaping.ascii_text(text).isascii()


@of_all
def test_a_file_name_is_one_part_of_a_path(text):
    name = escaping.file_name(text)
    assert name
    assert not set(name) & set("/\\:*?\"<>|\0\n\r %$&;'`")
    assert not name.startswith((".", "-"))
    assert not name.endswith((".", " "))
    assert len(name.encode()) <= escaping.LONGEST_FILE_NAME + 1
    assert not re.match(r"(?i)(con|prn|aux|nul|com\d|lpt\d)(\.|$)", name)


@pytest.mark.parametrize("text", ["friction, change per K", "D_t0 [4.E42] 1/(1 + x^2) at 5 m/s: 'yes' (no)"])
def test_ordinary_text_stays_as_it_is(text):
    same = (escaping.visible, escaping.ascii_text, escaping.c_comment, escaping.python_comment, escaping.xml_text)
    assert [escape(text) for escape in same] == [text] * 5
    assert escaping.c_string(text) == escaping.toml_string(text) == f'"{text}"'
