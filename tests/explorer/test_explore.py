"""The text of the page: self-contained, harmless whatever texts it shows, and refusals of the command."""

from __future__ import annotations

import json
import re
from base64 import b64encode
from dataclasses import replace
from hashlib import sha256

import pytest

from tests.hostile import EACH_PAGE, HOSTILE, Skeleton
from tirefmu.applications.explorer.explore import fit_intervals, page_text
from tirefmu.boundary.errors import TirefmuError, UnknownName
from tirefmu.commands.cli import main
from tirefmu.symbolic.added import AddedEffect
from tirefmu.symbolic.added.effect import Act
from tirefmu.symbolic.declarations import Coefficient
from tirefmu.tires import published, read_tir

#: Upper limit of the texts of an effect, in characters.
LONGEST = 600


def hostile_tire(text):
    """Return a tire with a user-defined effect; all its texts are a given one."""
    coefficient = Coefficient(text, "1", -1.0, 1.0)
    coefficient.name = "GRIPT"
    wet = AddedEffect("wet_grip", text, text, (coefficient,), (Act("friction_y", "factor", "1 + GRIPT*sin(gamma)"),))
    tire = published("trento_hoosier")
    values = {**tire.values, "GRIPT": 0.01}
    return replace(
        tire, values=values, effects={*tire.has, "wet_grip"}, name=text, about={"source": text}, added=(wet,)
    )


def scripts_of(page):
    return re.findall(r"<script>(.*?)</script>", page, flags=re.DOTALL)


def test_the_page_is_self_contained_and_its_scripts_are_those_that_its_policy_names():
    page = page_text("trento_hoosier", intervals={})
    assert not re.search(r"""(src|href|@import|url\()\s*=?\s*["']?(https?:)?//""", page)
    policy = re.search(r'Content-Security-Policy" content="([^"]*)"', page)[1]
    assert policy.startswith("default-src 'none'")
    named = re.findall(r"'sha256-([^']*)'", policy)
    assert named == [b64encode(sha256(script.encode()).digest()).decode() for script in scripts_of(page)]
    assert "https://github.com/leeoniya/uPlot" in scripts_of(page)[-1]  # with its copyright


def test_sliders_have_the_ranges_of_the_tire_file():
    tire = replace(published("trento_hoosier"), ranges={"Fz": (333.0, 777.0), "alpha": (-0.11, 0.12)})
    data = json.loads(re.search(r'id="data">(.*?)</script>', page_text(tire, intervals={}), flags=re.DOTALL)[1])
    inputs = {entry["name"]: entry for entry in data["tires"][0]["inputs"]}
    assert (inputs["alpha"]["low"], inputs["alpha"]["high"]) == (-0.11, 0.12)
    assert inputs["Fz"]["high"] == 777.0


def test_a_missing_chart_library_is_an_error(monkeypatch):
    monkeypatch.setattr("tirefmu.drawing.chart_library.LIBRARY", "no_such_package")
    with pytest.raises(TirefmuError, match="pip install uplot-python"):
        page_text("trento_hoosier", intervals={})


@pytest.mark.parametrize("text", EACH_PAGE)
def test_texts_of_files_do_not_change_the_page(text):
    """Elements and attributes are those of the same page with a harmless text; so is the code."""
    plain, hostile = (page_text(hostile_tire(name), intervals={}) for name in ("plain", text[:LONGEST]))
    assert Skeleton(hostile).parts == Skeleton(plain).parts
    assert scripts_of(hostile) == scripts_of(plain)


def test_hostile_texts_in_chromium(opened, bench, tmp_path):
    """No script runs, and a saved file has the texts."""
    text = "".join(HOSTILE[4:9])
    tire = hostile_tire(text)
    page = opened(tire, tables=[replace(bench, source=text)], compare=tire)
    assert page.evaluate("document.querySelectorAll('img, script[src], b').length") == 0
    (tmp_path / "x.tir").write_text(page.evaluate("propertyFile(now)"), encoding="utf-8")
    saved = read_tir(tmp_path / "x.tir")
    assert saved.about["source"] == tire.about["source"]
    assert saved.added[0].physics == text


def test_intervals_of_a_fit_are_in_iso(tmp_path):
    path = tmp_path / "fit.json"
    fitted = [{"name": "PKY1", "value": 30.0, "interval": 1.0}, {"name": "PDY1", "value": 2.0, "interval": None}]
    for signs, expected in (("iso", (29.0, 31.0)), ("adapted-sae", (-31.0, -29.0))):
        path.write_text(json.dumps({"signs": signs, "coefficients": fitted}))
        assert fit_intervals(path, "trento_hoosier") == {"PKY1": expected}
    page = page_text("trento_hoosier", intervals={"PKY1": (-31.0, -29.0)})
    data = json.loads(re.search(r'id="data">(.*?)</script>', page, flags=re.DOTALL)[1])
    found = {coefficient["name"]: coefficient for coefficient in data["tires"][0]["coefficients"]}
    assert found["PKY1"]["interval"] == [-31.0, -29.0]
    assert found["PKY1"]["lower"] <= -31.0
    with pytest.raises(UnknownName, match="PDYI"):
        page_text("trento_hoosier", intervals={"PDYI": (0.0, 1.0)})


@pytest.mark.parametrize(
    "content",
    ["", "[]", "{}", '{"signs": "iso", "coefficients": [3]}',
     '{"signs": "iso", "coefficients": [{"name": "X", "value": 1, "interval": 1}]}'],
)  # fmt: skip
def test_other_files_are_no_result_of_a_fit(tmp_path, content):
    path = tmp_path / "fit.json"
    path.write_text(content)
    with pytest.raises(TirefmuError, match=r"fit\.json: "):
        fit_intervals(path, "trento_hoosier")


def test_the_command_writes_the_page(tmp_path, capsys):
    page = tmp_path / "page.html"
    assert main(["explore", "trento_hoosier", "--compare", "unicamp_small_tire", "-o", str(page), "--json", "-"]) == 0
    assert json.loads(capsys.readouterr().out)["bytes"] == page.stat().st_size
