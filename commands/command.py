"""A command: its section in the help, its place there, and its examples are declared where it is defined."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import click

#: Headings of the help, in the order of the work.
SECTIONS = (
    "From a recording to a tire", "All steps, many tires", "Work with a tire", "Other programs", "What there is",
    "To try it",
)  # fmt: skip


class Command(click.Command):
    """A command with its section in the help, its place there, and command lines without the name of the program."""

    def __init__(self, *arguments: Any, section: str, place: int, examples: tuple[str, ...], **attributes: Any) -> None:
        super().__init__(*arguments, **attributes)
        self.epilog = "\b\nExamples:\n" + "\n".join(f"  tirefmu {line}" for line in examples)
        self.section, self.place, self.examples = section, place, examples


def command(
    name: str | None = None, *, section: str, place: int, examples: tuple[str, ...]
) -> Callable[[Callable[..., Any]], Command]:
    """Declare a command.

    `name`: that of the function by default. `section`: one of `SECTIONS`. `place`: a number by which the help orders
    the commands of a section. `examples`: command lines without the name of the program.
    """
    return click.command(name, cls=Command, section=section, place=place, examples=examples)


class SectionedGroup(click.Group):
    """A group whose help lists its commands under headings."""

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write the commands of each section with the first sentence of their help."""
        width = max(map(len, self.commands))
        listed = [made for made in self.commands.values() if isinstance(made, Command)]
        for title in SECTIONS:
            with formatter.section(title):
                commands = sorted((made.place, str(made.name), made) for made in listed if made.section == title)
                formatter.write_dl(
                    [(name.ljust(width), made.get_short_help_str(formatter.width)) for _, name, made in commands]
                )
