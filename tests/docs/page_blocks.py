"""The code blocks of a page of the documentation, with what HTML comments state about them.

``<!-- files: my.tir run.csv -->`` names files that a page needs and a test makes. ``<!-- not run: REASON -->`` is
directly before a block that a test parses but does not run.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

#: Why a block is not run.
REASONS = {
    "installs packages", "opens a window", "needs a server", "needs a compiler for other platforms",
    "needs measured data", "needs a vehicle", "takes minutes",
}  # fmt: skip
_PART = re.compile(
    r"^<!-- (files|not run): (.*?) -->\n|^```(\w+)\n(.*?)^```$", flags=re.MULTILINE | re.DOTALL
)  # fmt: skip


@dataclass(frozen=True)
class Block:
    """A fenced block: language, text, and why it is not run (empty: it is)."""

    language: str
    text: str
    not_run: str = ""

    @property
    def commands(self) -> list[str]:
        """The command lines of a block of the shell; a backslash continues a line."""
        lines = re.sub(r"\\\n\s*", "", self.text).splitlines()
        return [line for line in lines if line.strip() and not line.startswith("#")]


def blocks_of(text: str) -> tuple[list[Block], list[str]]:
    """Return the blocks of a page in their order, and the names of the files that it needs."""
    blocks, files, reason = [], [], ""
    for comment, content, language, code in _PART.findall(text):
        if comment == "files":
            files += content.split()
        elif comment:
            reason = content
        else:
            blocks.append(Block(language, code, reason))
            reason = ""
    return blocks, files
