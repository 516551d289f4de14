"""The book of equations: what it contains, and that LaTeX accepts it."""

from __future__ import annotations

import subprocess

from tirefmu.hosts.printout import printed
from tirefmu.symbolic.models import MODELS

from .conftest import tool


def test_every_line_has_its_number_and_every_coefficient_its_row():
    text = printed("mf96", "latex", rows=1)["mf96.tex"]
    lines = MODELS["mf96"].lines()
    assert text.count("\\tag{") == len(lines)
    assert text.count("\\begin{equation}") == len(lines)
    for name in MODELS["mf96"].coefficients:
        assert f"$\\mathrm{{{name}}}$".replace("_", "\\_") in text
    for effect in MODELS["mf96"].effects:
        assert effect.replace("_", "\\_") in text


def test_latex_compiles_the_book_with_hostile_texts(wet, tmp_path):
    latex = tool("pdflatex")
    (tmp_path / "book.tex").write_text(printed(wet, "latex", rows=1, values="struct")["mf96.tex"])
    command = [latex, "-interaction=nonstopmode", "-halt-on-error", "-no-shell-escape", "book.tex"]
    run = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, errors="replace", check=False)
    assert run.returncode == 0, run.stdout[-2000:]
    assert (tmp_path / "book.pdf").stat().st_size > 50_000
