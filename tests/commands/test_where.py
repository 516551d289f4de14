"""``--where`` selects the same rows in every command that reads tables."""

from __future__ import annotations

import pandas as pd
import pytest

WHERE = "Fz in 700 +- 100 N and gamma in 0 +- 0.5 deg"
#: By command: what precedes the table, and what follows it.
COMMANDS = {
    "evaluate": (["trento.tir"], ["-o", "out.csv"]),
    "check": (["trento.fmu"], []),
    "inspect": ([], ["--table", "out.csv"]),
    "fit": ([], ["--model", "mf96", "--effects", "none", "--rows", "equal", "-o", "new.tir"]),
    "explore": (["trento.tir"], ["-o", "page.html"]),
}


@pytest.mark.parametrize("name", COMMANDS)
def test_the_rows_are_those_of_the_expression(
    name, command, bench_csv, published_tir, published_fmu, tmp_path, monkeypatch
):
    table = pd.read_csv(bench_csv)
    selected = (table["Fz"] - 700.0).abs().le(100.0) & table["gamma"].abs().le(0.0087266)
    monkeypatch.chdir(tmp_path)
    paths = {"trento.tir": published_tir, "trento.fmu": published_fmu}
    (tmp_path / "crop.where").write_text(WHERE, encoding="utf-8")
    before, after = COMMANDS[name]
    where = "crop.where" if name == "fit" else WHERE
    outcome = command(name, *(paths[part] for part in before), bench_csv, *after, "--where", where)
    assert outcome.status in (0, 1), outcome.err
    assert f"{selected.sum()} of " in outcome.out
    if "out.csv" in after:
        assert len(pd.read_csv("out.csv")) == selected.sum()
