"""The report is one file with all results of the fit."""

from __future__ import annotations

import re
from dataclasses import replace
from html.parser import HTMLParser

import pytest

from tirefmu.boundary.errors import FitError
from tirefmu.boundary.escaping import figure_text, visible
from tirefmu.drawing.figure import Figure, Panel
from tirefmu.fitting import Findings, HeldOut
from tirefmu.fitting.checks import Disagreement, SlipStiffness
from tirefmu.fitting.checks.undetermined import Undetermined
from tirefmu.fitting.constraints import Margin
from tirefmu.fitting.data import ExcludedRows
from tirefmu.fitting.reporting import report_page, write_report
from tirefmu.measurements.provenance import provenance, table_digest

from ..hostile import EACH_PAGE, Skeleton, is_plain

VOID = {"meta", "img", "br", "hr", "link", "input", "col"}


class Page(HTMLParser):
    """The text and the attributes of a page; fails if a tag is not closed."""

    def __init__(self, text):
        super().__init__()
        self.open, self.words, self.attributes = [], [], []
        self.feed(text)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag, attrs):
        self.attributes += [(tag, name, value) for name, value in attrs]
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if not set(self.open) & {"style", "script"}:
            self.words.append(data)

    @property
    def text(self):
        return " ".join(" ".join(self.words).split())


def test_the_page_contains_the_result(side_fit):
    result, recording = side_fit
    text = Page(report_page(result, [])).text
    assert result.status in text
    assert recording.source in text
    for coefficient in result.coefficients:
        assert re.search(rf"\b{coefficient.name}\b", text), coefficient.name
        if coefficient.determined:
            assert f"{coefficient.value:.5g}" in text, coefficient.name
    for stage in result.stages:
        assert stage.name in text
    for margin in result.margins:
        assert margin.constraint in text
    for note in result.notes:
        assert " ".join(note.split()) in text


def test_the_provenance_identifies_the_data(side_fit):
    """The digest is that of the values: a changed value has another one."""
    _, recording = side_fit
    text = Page(report_page(side_fit[0], [], provenance([recording], "tirefmu fit run.csv"))).text
    assert "tirefmu fit run.csv" in text
    assert table_digest(recording.table) in text
    changed = recording.table.copy()
    changed.iloc[0, 0] += 1e-9
    assert table_digest(changed) not in text


def test_a_violated_constraint_is_on_the_page(side_fit):
    result, _ = side_fit
    violated = replace(result, margins=(Margin("E_y <= 1", 1.25, -0.25, {"Fz": 1120.0}),))
    assert "constraint E_y <= 1 violated by 0.25" in Page(report_page(violated, [])).text


def with_text(result, text):
    """Return the result with all texts from files or users replaced by this one."""

    def other(value, *names):
        return replace(value, **dict.fromkeys(names, text))

    def each(values, *names):
        return tuple(other(value, *names) for value in values)

    found = result.findings
    tire = replace(result.tire, name=text, about={"maker": text})
    run = replace(result.run, recipe=text, interrupted=text, stages=each(result.stages, "name", "reason"))
    changed = replace(
        result, tire=tire, run=run, notes=(text,),
        channels=each(result.channels, "recording"),
        held_out=(HeldOut(text, "Fy", "N", 3, 1.0, 2.0),),
        excluded_rows=(ExcludedRows(text, "outlier", text, 1, 9, (text,)),),
    )  # fmt: skip
    findings = Findings(
        conditions=each(found.conditions, "recording"),
        stiffnesses=(SlipStiffness(text, "Fy", "alpha", "N/rad", 900.0, 1.0, 1.1),),
        undetermined=(Undetermined((text,), text),),
        files=(Disagreement("Fy", "N", text, text, 1.0, 1.0, 9.0, 9, {"Fz": 900.0}, 2.0),),
        ripples=each(found.ripples, "recording"),
    )
    vars(changed)["findings"] = findings
    return changed


def page_with(result, text):
    name = figure_text(text)
    shown = Figure("any", name, ((Panel(name, name),),), name)
    return report_page(with_text(result, text), [shown], [("command", text)])


@pytest.fixture(scope="module")
def plain_page(side_fit):
    return page_with(side_fit[0], "plain")


@pytest.mark.parametrize("text", EACH_PAGE)
def test_no_text_changes_the_page(side_fit, plain_page, text):
    page = page_with(side_fit[0], text)
    # The only code is the same in both pages: it draws charts.
    contents, codes = zip(*(text.rsplit("<script>", 1) for text in (plain_page, page)), strict=True)
    assert codes[0] == codes[1]
    page.encode("utf-8")
    assert is_plain(contents[1])
    plain, shown = map(Skeleton, contents)
    assert shown.parts == plain.parts
    assert not {"iframe", "object", "link"} & {part[0] for part in shown.parts}
    assert set(re.findall(r"<a [^>]*>", contents[1])) == set(re.findall(r'<a href="#\w+">', contents[1]))
    assert shown.text.count(visible(text)) >= 13  # all of it can be read


def test_the_file_of_a_result_is_self_contained(side_fit, tmp_path):
    result, recording = side_fit
    path = tmp_path / "report.html"
    result.report(path, recording)
    with pytest.raises(FitError):
        result.report(tmp_path / "none.html", [])
    assert [file.name for file in tmp_path.iterdir()] == ["report.html"]
    page = Page(path.read_text(encoding="utf-8"))
    images = [value for tag, name, value in page.attributes if (tag, name) == ("img", "src")]
    assert len(images) == 1
    for _, name, value in page.attributes:
        if name in ("src", "href"):
            assert value.startswith(("data:image/png;base64,", "#")), value[:60]


def test_curves_of_moments_are_behind_a_tab(side_fit):
    result, _ = side_fit
    panel = Panel("alpha (deg)", "Fy (N)", ())
    curves = [Figure(name, name, ((panel,),)) for name in ("pure_Fx", "pure_Fy", "pure_Mz", "pure_Mx")]
    page = Page(report_page(result, curves))
    inputs = [value for tag, name, value in page.attributes if (tag, name) == ("input", "id")]
    labels = [value for tag, name, value in page.attributes if (tag, name) == ("label", "for")]
    assert inputs == labels == ["overview-1", "overview-2"]
    pictures = [value for tag, name, value in page.attributes if (tag, name) == ("img", "alt")]
    assert pictures == ["Forces at all measured loads"]
    alone = Page(report_page(result, curves[:2]))
    assert not [each for each in alone.attributes if each[0] == "input"]


def test_a_report_that_cannot_be_written(side_fit, tmp_path):
    result, recording = side_fit
    with pytest.raises(FitError, match=r"no/report\.html: cannot be written"):
        write_report(result, [recording], tmp_path / "no" / "report.html", figures=[])
    taken = tmp_path / "taken.html"
    taken.mkdir()
    with pytest.raises(FitError, match="cannot be written"):
        write_report(result, [recording], taken, figures=[])
    assert [file.name for file in tmp_path.iterdir()] == ["taken.html"]
