"""``tirefmu inspect``: what it prints, its JSON, its page, its exit codes."""

from __future__ import annotations

import json
import re

import numpy as np
import pandas as pd
import pytest

from tirefmu.drawing.chart_library import allowed
from tirefmu.measurements import read_recording, table_digest


@pytest.fixture(scope="module")
def inspected(command, bench_csv, tmp_path_factory):
    folder = tmp_path_factory.mktemp("inspect")
    outcome = command("inspect", bench_csv, "-o", folder / "page.html", "--json", folder / "page.json")
    page = (folder / "page.html").read_text(encoding="utf-8")
    return outcome, json.loads((folder / "page.json").read_text(encoding="utf-8")), page


def test_a_good_recording(inspected):
    outcome, content, page = inspected
    assert (outcome.status, content["ok"]) == (0, True)
    assert outcome.out.startswith("verdict: ready for a fit\n")
    assert re.fullmatch(r"inspecting: \d+\.\d s\n", outcome.err)
    (recording,) = content["recordings"]
    assert recording["rows"] >= sum(condition["rows"] for condition in recording["conditions"])
    by_name = {channel["name"]: channel for channel in recording["channels"]}
    assert by_name["Fz"]["levels"] == pytest.approx([220.0, 700.0, 1120.0], rel=0.03)
    assert (by_name["alpha"]["unit"], by_name["p"]["unit"]) == ("rad", "Pa")
    for text in ("Channels", "Operating conditions", "Sweeps"):
        assert text in outcome.out
        assert text in page


def test_rows_in_another_order_have_no_duration(command, bench_csv, tmp_path):
    pd.read_csv(bench_csv).sample(frac=1.0, random_state=1).to_csv(tmp_path / "a.csv", index=False)
    printed = command("inspect", tmp_path / "a.csv").out
    assert printed.startswith("verdict: ready for a fit, with 1 note\n")
    assert re.search(r"a.csv \d+ rows, iso signs, not in the order of time\n", printed)


def test_the_page_is_one_file_whose_only_script_makes_charts(inspected):
    page = inspected[2]
    (script,) = re.findall(r"<script>(.*?)</script>", page, flags=re.DOTALL)
    assert f"default-src 'none'; img-src data:; style-src 'unsafe-inline'; script-src {allowed(script)}" in page
    assert page.count("<script") - 1 == page.count('<script type="application/json" class="panels">') == 3
    assert not re.findall(r'(?:src|href)="(?!data:)', page)
    assert page.count("data:image/png;base64,") == 1  # for print, and without scripts
    assert "&lt;" not in page.replace("Fy &lt; 0", "")  # no markup of the page itself was escaped
    assert page.count("<table>") - 1 == page.count("<h3>") - 3 >= 3  # the last table is the provenance


def test_the_page_ends_with_its_provenance(inspected, bench_csv):
    provenance = inspected[2].split("<h2>Provenance</h2>")[1]
    assert f"tirefmu inspect {bench_csv}" in provenance
    assert table_digest(read_recording(bench_csv).table) in provenance


def test_rows_are_selected_and_written(command, bench_csv, tmp_path):
    outcome = command("inspect", bench_csv, "--where", "Fz in 700 +- 100 N", "--table", tmp_path / "rows.csv")
    assert outcome.status == 0
    rows = pd.read_csv(tmp_path / "rows.csv")
    assert rows["Fz"].between(600.0, 800.0).all()
    assert f"{len(rows)} of " in outcome.out


def test_a_channel_without_a_number_is_null_in_the_json(command, bench_csv, tmp_path):
    pd.read_csv(bench_csv).assign(Mx=np.nan).to_csv(tmp_path / "a.csv", index=False)
    outcome = command("inspect", tmp_path / "a.csv", "--json", tmp_path / "a.json", "--quiet")
    assert outcome.status == 0, outcome.err
    (recording,) = json.loads((tmp_path / "a.json").read_text(encoding="utf-8"))["recordings"]
    (channel,) = [shown for shown in recording["channels"] if shown["name"] == "Mx"]
    assert (channel["rows"], channel["lowest"], channel["highest"]) == (0, None, None)


def test_a_serious_finding_gives_exit_code_1_and_comes_first(command, tmp_path):
    table = pd.DataFrame({"kappa": np.linspace(-0.2, 0.2, 90), "Fz": 900.0})
    table.assign(Fx=3e3 * table["kappa"], Fy=0.0, remark="x").to_csv(tmp_path / "a.csv", index=False)
    outcome = command("inspect", tmp_path / "a.csv", "-o", tmp_path / "page.html")
    assert outcome.status == 1
    verdict, _, rest = outcome.out.partition("\n")
    assert verdict == "verdict: a fit of these data would be misleading"
    assert rest.startswith("warning: a.csv: NO COLUMN alpha (slip angle): Fy cannot be fitted")
    page = (tmp_path / "page.html").read_text(encoding="utf-8")
    assert page.index("NO COLUMN alpha") < page.index("columns that are no channels are not fitted: remark")


def test_texts_of_a_file_do_not_reach_the_page_as_markup(command, tmp_path):
    name = tmp_path / "<img src=x>.csv"
    pd.DataFrame({"alpha": [0.0, 0.1], "Fz": 900.0, "Fy": 1.0, "<b>lap": 1}).to_csv(name, index=False)
    command("inspect", name, "-o", tmp_path / "page.html")
    page = (tmp_path / "page.html").read_text(encoding="utf-8")
    assert "<img src=x>" not in page
    assert "<b>lap" not in page
