"""Every block of the documentation runs, in a new folder for each page; `page_blocks` explains the comments of pages.

Pages that take more than some seconds run with TIREFMU_DOCS (make docs-commands).
"""

from __future__ import annotations

import os
import re
import shlex
from pathlib import Path

import pytest

from tirefmu.commands.cli import cli, main

from ..rooms import ROOT, TARGETS
from .made_files import MadeFiles
from .page_blocks import REASONS, blocks_of

DOCS = ROOT / "docs"
TEXTS = {path.relative_to(DOCS).as_posix(): path.read_text(encoding="utf-8") for path in sorted(DOCS.rglob("*.md"))}
README = (ROOT / "README.md").read_text(encoding="utf-8")
#: Pages that take longer.
SLOW = {
    "command_line.md", "data_desk.md", "diagnosis.md", "drive.md", "effects.md", "family.md", "gallery.md",
    "many_tires.md", "planning.md", "published_tires.md", "python.md", "quick_start.md", "report_figures.md",
    "temperature.md", "ttc.md", "tutorials/from_a_drive.md", "tutorials/fsae_tire.md", "tutorials/hidden_effect.md",
    "tutorials/small_robot_tire.md", "tutorials/warm_tire.md",
}  # fmt: skip


@pytest.fixture(scope="session")
def made(tmp_path_factory):
    return MadeFiles(tmp_path_factory.mktemp("made"))


def parts(line):
    """Return the words of a command line, the file that gets its output or None, and its comment."""
    command, _, comment = line.partition(" #")
    command, target = re.fullmatch(r"(.*?)(?: > ([^\s\"']+))?", command.strip()).groups()
    return shlex.split(command), target, comment


def run(line, capsys):
    """Run a command line; it succeeds unless a comment states its exit codes. Those of make exist."""
    (program, *arguments), target, comment = parts(line)
    if program == "make":
        assert arguments[0] in TARGETS, line
        return
    assert program == "tirefmu", line
    capsys.readouterr()
    status = main(arguments)
    printed = capsys.readouterr()
    stated = "".join(re.findall(r"\bexit code (\d(?: or \d)*)", comment))
    assert status in ({int(code) for code in re.findall(r"\d", stated)} or {0}), (line, printed)
    if target:
        Path(target).write_text(printed.out, encoding="utf-8")


@pytest.mark.parametrize("page", [page for page, text in TEXTS.items() if "\n```" in text])
def test_the_blocks_of_a_page_run(page, made, tmp_path, monkeypatch, capsys):
    if page in SLOW and "TIREFMU_DOCS" not in os.environ:
        pytest.skip("takes long: make docs-commands")
    blocks, files = blocks_of(TEXTS[page])
    for name in files:
        made.copy(name, tmp_path)
    monkeypatch.chdir(tmp_path)
    names = {"__name__": page}
    if page == "quick_start.md":  # the README continues with its files
        blocks += [block for block in blocks_of(README)[0] if block.language == "python"]
    for block in blocks:
        if block.language == "python":
            exec(compile(block.text, page, "exec"), names)
        elif block.language == "sh" and not block.not_run:
            for line in block.commands:
                run(line, capsys)


def test_commands_that_are_not_run_have_a_reason_and_are_accepted():
    """Those of slow pages, too."""
    reasons = set()
    for page, text in TEXTS.items():
        assert not re.search(r"^ {4}(tirefmu|make) ", text, flags=re.MULTILINE), f"{page}: a command without a fence"
        for block in blocks_of(text)[0]:
            reasons |= {block.not_run} - {""}
            for line in block.commands if block.not_run or (page in SLOW and block.language == "sh") else []:
                program, *arguments = parts(line)[0]
                if program == "tirefmu":
                    cli.commands[arguments[0]].make_context(arguments[0], arguments[1:])
                elif program == "make":
                    assert arguments[0] in TARGETS
    assert reasons == REASONS


def test_the_commands_of_the_readme_are_those_of_pages_that_run():
    run = {
        line for text in TEXTS.values() for block in blocks_of(text)[0] if not block.not_run for line in block.commands
    }
    written = [line for block in blocks_of(README)[0] for line in block.commands if block.language == "sh"]
    commands = [line for line in written if line.startswith("tirefmu ")]
    assert len(commands) > 4
    assert set(commands) <= run


def test_commands_in_the_text_have_only_options_that_exist():
    text = "\n".join([README, *TEXTS.values()])
    inline = re.findall(r"`tirefmu ([a-z][a-z-]*)([^`]*)`", text)
    assert len(inline) > 80
    for name, rest in inline:
        options = {option for parameter in cli.commands[name].params for option in parameter.opts}
        assert set(re.findall(r"(?<=\s)--?[a-z][a-z-]*", rest)) <= options | {"--help"}, (name, rest)
