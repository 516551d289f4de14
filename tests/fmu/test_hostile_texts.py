"""Texts of a tire in the files of an FMU: XML, a page, tables in C; none changes the structure of a file."""

from __future__ import annotations

import html.parser
import re
import xml.etree.ElementTree as ET
from dataclasses import replace

import pytest
from hypothesis import example, given, settings

from tirefmu.boundary.errors import FmuError
from tirefmu.boundary.escaping import toml_string
from tirefmu.fmu.description.documentation import index_html
from tirefmu.fmu.description.interface import interface
from tirefmu.fmu.description.model_description import Header, model_description
from tirefmu.fmu.description.terminals_and_icons import terminals
from tirefmu.fmu.packaging.written_headers import model_config
from tirefmu.symbolic.added import read_effect
from tirefmu.tires import published, read_tir, write_tir

from ..boundary.hostile import NASTY, hostile_texts

WORDS = "plain"


EFFECT = """
name = "own"
physics = {physics}
source = {source}
[coefficients]
OWN1 = {{description = {description}, unit = {unit}, lower = -1.0, upper = 1.0}}
[[acts]]
on = "mu_y"
factor = "1 + OWN1*(Fz - FNOMIN)/FNOMIN"
"""


def tire_with(text, unit="1"):
    """Return a tire of which every text is the given one, including those of a user-defined effect."""
    texts = {"physics": f"x{text}", "source": f"x{text}", "description": text, "unit": unit}
    effect = read_effect(EFFECT.format(**{key: toml_string(value) for key, value in texts.items()}), "own.toml")
    first = published("trento_hoosier")
    return replace(first, effects=[*first.effects, "own"], name=text, about={"about": text}, added=(effect,))


def files_of(tire):
    shown = interface(tire, inputs="slip", axes="iso", quantities=False)
    header = Header(tire.name, "tire", tire.name, ("a.c",))
    described = [model_description(version, header, shown.variables, "{1}") for version in (2, 3)]
    page = index_html(tire, header, shown.variables).decode()
    return [*described, terminals(shown.variables)], page, model_config(shown)


def structure(xml):
    """Return the elements of an XML file and the names of their attributes."""
    return [(element.tag, sorted(element.attrib)) for element in ET.fromstring(xml).iter()]


def elements(page):
    """Return the elements of a page with their attributes."""
    listed = []

    class Parser(html.parser.HTMLParser):
        def handle_starttag(self, tag, attributes):
            listed.append((tag, attributes))

    parser = Parser()
    parser.feed(page)
    return listed


@pytest.fixture(scope="module")
def plain(tmp_path_factory):
    """Return the structure of the files of a tire with plain words, and the lines of its .tir file."""
    path = tmp_path_factory.mktemp("plain") / "plain.tir"
    write_tir(tire_with(WORDS), path)
    described, page, config = files_of(tire_with(WORDS))
    lines = path.read_text(encoding="utf-8").splitlines()
    return [structure(xml) for xml in described], elements(page), config, len(lines)


@settings(max_examples=6)
@example("\n".join(NASTY).replace("\ud800", ""))
@given(hostile_texts().map(lambda text: re.sub("[\ud800-\udfff]", "", text)))
def test_text_changes_no_structure(tmp_path_factory, plain, text):
    described, page, config = files_of(tire_with(text))
    path = tmp_path_factory.mktemp("tires") / "hostile.tir"
    write_tir(tire_with(text), path)
    lines = path.read_text(encoding="utf-8").splitlines()
    assert ([structure(xml) for xml in described], elements(page), config, len(lines)) == plain
    assert read_tir(path) == tire_with(text).in_signs("iso")


def test_code_is_rejected_as_a_unit():
    with pytest.raises(FmuError, match="unknown factor") as caught:
        files_of(tire_with(WORDS, unit="*/ int x; /*\n"))
    assert str(caught.value).isprintable()
