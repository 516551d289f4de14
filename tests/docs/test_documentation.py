"""The documentation: generated pages are complete, names exist, the site is offline (test_commands.py: blocks run)."""

from __future__ import annotations

import importlib
import os
import re
import runpy
import shlex
import subprocess
import sys
import tomllib

import pytest

import tirefmu
from tirefmu.applications.project import SECTIONS
from tirefmu.boundary.errors import LISTED_BY
from tirefmu.commands.cli import cli
from tirefmu.commands.schemas import KINDS
from tirefmu.measurements import UNITS
from tirefmu.symbolic.models import MODELS

from ..rooms import MAKEFILE, ROOT, RULES, STUDIES, TARGETS
from .page_blocks import blocks_of

DOCS = ROOT / "docs"
#: Pages that are also notebooks.
TUTORIALS = sorted(f"tutorials/{path.name}" for path in (DOCS / "tutorials").glob("*.md"))
GENERATED = runpy.run_path(str(DOCS / "reference_pages.py"))
GALLERY = runpy.run_path(str(DOCS / "gallery.py"))
README = (ROOT / "README.md").read_text(encoding="utf-8")
CONTRIBUTING = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")


def notebook(page):
    """Return the notebook of a page."""
    return GENERATED["notebook"]((DOCS / page).read_text(encoding="utf-8"))


def test_a_notebook_has_the_text_and_the_blocks_of_its_page():
    format_of_notebooks = pytest.importorskip("nbformat")
    for page in TUTORIALS:
        text, made = (DOCS / page).read_text(encoding="utf-8"), notebook(page)
        format_of_notebooks.validate(made)
        sources = ["\n".join(line.removeprefix("!") for line in cell["source"].splitlines()) for cell in made["cells"]]
        assert all(source in text for source in sources)
        blocks, _ = blocks_of(text)
        assert {block.language for block in blocks} <= {"python", "sh"}
        assert sum(cell["cell_type"] == "code" for cell in made["cells"]) == len(blocks)


def test_the_readme_names_commands_targets_and_files_that_exist():
    assert set(re.findall(r"\bmake ([a-z-]+)", README)) <= TARGETS
    assert set(re.findall(r"`tirefmu ([a-z-]+)", README)) <= set(cli.commands)
    files = re.findall(r"`((?:docs/)?\w+\.(?:md|cff))`", README) + re.findall(r"\]\(([\w/.]+)\)", README)
    assert len(files) > 8
    assert [name for name in files if not (ROOT / name).is_file()] == []


def test_every_target_of_make_has_a_rule_and_is_explained():
    assert set(re.search(r"^\.PHONY: (.*)$", MAKEFILE, flags=re.MULTILINE)[1].split()) == RULES
    assert set(re.findall(r"^\| `make ([a-z-]+)`", CONTRIBUTING, flags=re.MULTILINE)) == RULES
    assert not RULES & set(STUDIES)


def test_the_files_and_extras_of_studies_exist():
    extras = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["optional-dependencies"]
    for study in STUDIES.values():
        assert set(study.get("extras", ())) <= set(extras)
        named = [word for line in study["run"] for word in line.split() if word.startswith(("benchmarks/", "tests/"))]
        assert all((ROOT / word).exists() for word in named), named


def test_figures_of_the_performance_page_are_figures_of_the_benchmarks(monkeypatch):
    """A benchmark that names a figure otherwise would drop it from the page in silence."""
    monkeypatch.syspath_prepend(ROOT / "benchmarks")
    performance, startup = importlib.import_module("performance"), importlib.import_module("startup_times")
    evaluation = (ROOT / "benchmarks" / "evaluation_times.py").read_text("utf-8")
    assert set(performance.STARTUP) == {*startup.COMMANDS, *startup.REPEATED}
    assert [name for name, _ in performance.EVALUATION if f'"{name}"' not in evaluation] == []
    for short in performance.SHORT:
        assert any(name.startswith(short) for name in performance.STARTUP)
    times = {points: dict.fromkeys([performance.CASADI, *(name for name, _ in performance.EVALUATION)], 100.0)
             for points in (100, performance.MANY)}  # fmt: skip
    text = performance.evaluation_text(times)
    assert text.count("| 1.00 | ") == len(performance.EVALUATION)
    assert text.count("| reached |") == sum(line.target >= 1.0 for line in performance.EVALUATION.values())


def test_generated_pages_have_every_effect_model_and_command():
    pages = GENERATED["pages"]()
    effects = {name for model in MODELS.values() for name in model.effects}
    assert effects <= set(re.findall(r"^## (\w+)$", pages["reference/effects.md"], flags=re.MULTILINE))
    assert set(re.findall(r"^\| `(\w+)`", pages["reference/models.md"], flags=re.MULTILINE)) >= set(MODELS)
    for name, model in MODELS.items():  # every equation, typeset
        page = pages[f"reference/equations/{name}.md"]
        shown = [line for line in model.equations if not line.variant]
        assert page.count("<math") == len(shown)
        assert {line.chapter for line in shown} == set(re.findall(r"^## (.*)$", page, flags=re.MULTILINE))
    assert set(re.findall(r"^## (\w+)$", pages["reference/python.md"], flags=re.MULTILINE)) == set(tirefmu.__all__)
    headings = re.findall(r"^## ([\w-]+)$", pages["reference/cli.md"], flags=re.MULTILINE)
    assert headings == sorted(cli.commands)
    for name, command in cli.commands.items():
        section = pages["reference/cli.md"].split(f"\n## {name}\n")[1].split("\n## ")[0]
        for parameter in command.params:
            assert all(option in section for option in parameter.opts if option.startswith("--"))


def test_the_page_of_the_command_line_has_every_command_and_every_key_of_a_project():
    text = (DOCS / "command_line.md").read_text(encoding="utf-8")
    assert set(cli.commands) <= set(re.findall(r"tirefmu ([a-z-]+)", text))
    for section, keys in SECTIONS.items():
        row = re.search(rf"^\| `\[{section}\]` \| (.*) \|$", text, flags=re.MULTILINE)[1]
        assert re.findall(r"`(\w+)`", row) == list(keys)


def test_the_gallery_has_twenty_pictures_each_below_the_command_that_draws_it():
    """`make docs` runs the commands; the site lacks no picture (test_the_site_builds...)."""
    text = (DOCS / "gallery.md").read_text(encoding="utf-8")
    pictures, lines = GALLERY["pictures"](text), GALLERY["commands"](text)
    assert len(set(pictures)) == len(pictures) == 20
    for picture in pictures:
        above = GALLERY["commands"](text.split(f"(gallery/{picture})")[0])[-1]
        words = shlex.split(above)
        written = {words[i + 1] for i, word in enumerate(words) if word in ("-o", "--figures")}
        assert written & {picture.split("/")[0], picture.removesuffix(".png")}, (picture, above)
    for line in lines:
        program, name, *arguments = shlex.split(line.partition(" > ")[0])
        assert program == "tirefmu"
        cli.commands[name].make_context(name, arguments)


def test_every_page_is_in_the_navigation():
    listed = re.findall(r"^ +- ([\w/]+\.md)$", (ROOT / "mkdocs.yml").read_text(encoding="utf-8"), flags=re.MULTILINE)
    made = GENERATED["pages"]()
    written = {path.relative_to(DOCS).as_posix() for path in DOCS.rglob("*.md")}
    assert sorted(listed) == sorted(written | set(made))


def test_the_site_builds_without_warnings_and_loads_nothing_from_outside(tmp_path):
    pytest.importorskip("mkdocs", reason="mkdocs is not installed: make docs")
    command = [sys.executable, "-m", "mkdocs", "build", "--quiet", "--site-dir", str(tmp_path)]
    environment = {**os.environ, "NO_MKDOCS_2_WARNING": "1"}
    built = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, check=False)
    assert (built.returncode, built.stdout + built.stderr) == (0, "")
    pages = list(tmp_path.rglob("*.html"))
    assert len(pages) > 15
    assert len(list((tmp_path / "gallery").rglob("*.png"))) == 20
    assert {path.stem for path in (tmp_path / "schemas").iterdir()} == set(KINDS)
    for page in pages:
        loaded = re.findall(r"<(?:script|link|img|iframe)\b[^>]*>", page.read_text(encoding="utf-8"))
        assert not [tag for tag in loaded if re.search(r"""(src|href)=["']?(https?:)?//""", tag)], page


def test_the_page_that_lists_the_units_of_headers_has_all():
    """A message on an unknown unit names this page."""
    page = LISTED_BY["unit"]
    table = (ROOT / page).read_text(encoding="utf-8").split("| quantity | units, in any case |")[1].split("\n\n")[0]
    listed = {row.split("|")[1].strip(): set(re.findall(r"`([^`]+)`", row)) for row in table.splitlines()[2:]}
    known: dict[str, set[str]] = {}
    for spelling, unit in UNITS.items():
        known.setdefault(unit.quantity, set()).add(spelling)
    assert listed == {quantity: spellings - {""} for quantity, spellings in known.items()}


def test_every_command_that_a_message_names_exists():
    for text in LISTED_BY.values():
        assert text.startswith("docs/") or text.split()[1] in cli.commands
