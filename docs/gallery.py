"""The pictures of gallery.md: MkDocs calls `on_files`, which runs the commands of the page and adds what they draw.

The pictures are in build/gallery, not in the repository. Nothing in them is measured.
"""

from __future__ import annotations

import base64
import re
import shlex
import subprocess
import sys
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from mkdocs.config.defaults import MkDocsConfig
    from mkdocs.structure.files import Files

PAGE = Path(__file__).with_name("gallery.md")
FOLDER = PAGE.parents[1] / "build" / "gallery"
#: Ending of the name of a picture that is the first one inside a page.
IN_PAGE = ".html.png"


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the pictures to the files of the site; draw them if one is missing."""
    from mkdocs.structure.files import File

    names = pictures(PAGE.read_text(encoding="utf-8"))
    if not all((FOLDER / name).is_file() for name in names):
        draw()
    for name in names:
        files.append(File.generated(config, f"gallery/{name}", abs_src_path=str(FOLDER / name)))
    return files


def pictures(text: str) -> list[str]:
    """Return the pictures of the page, below `FOLDER`."""
    return re.findall(r"^!\[.+\]\(gallery/(.+)\)$", text, flags=re.MULTILINE)


def commands(text: str) -> list[str]:
    """Return the command lines of the page in their order."""
    blocks = re.findall(r"^```sh\n(.*?)^```$", text, flags=re.MULTILINE | re.DOTALL)
    return [line for block in blocks for line in block.splitlines()]


def draw() -> None:
    """Run the commands of the page, and take pictures out of pages.

    Raises `RuntimeError` with its messages if a command fails.
    """
    text = PAGE.read_text(encoding="utf-8")
    FOLDER.mkdir(parents=True, exist_ok=True)
    for line in commands(text):
        command, _, file = line.partition(" > ")
        run = [sys.executable, "-m", *shlex.split(command)]
        done = subprocess.run(run, cwd=FOLDER, capture_output=True, text=True, check=False)
        if done.returncode:
            raise RuntimeError(f"{line}: {done.stderr}")
        if file:
            (FOLDER / file).write_text(done.stdout, encoding="utf-8")
    for name in pictures(text):
        if name.endswith(IN_PAGE):
            page = (FOLDER / name.removesuffix(".png")).read_text(encoding="utf-8")
            (FOLDER / name).write_bytes(base64.b64decode(page.split("data:image/png;base64,")[1].split('"')[0]))
