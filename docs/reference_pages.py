"""Pages of the documentation that are made from declarations: effects, models, published tires, the command line.

MkDocs calls `on_files` before it builds the site.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from tirefmu.cli import cli
from tirefmu.commands.catalogue import effects, models, published_tires
from tirefmu.symbolic.escaping import html_text

if TYPE_CHECKING:
    from mkdocs.config.defaults import MkDocsConfig
    from mkdocs.structure.files import Files

ROOT = Path(__file__).parents[1]


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the pages to the files of the site."""
    from mkdocs.structure.files import File

    for name, text in pages().items():
        files.append(File.generated(config, name, content=text))
    return files


def pages() -> dict[str, str]:
    """Return the text of each page by its path."""
    return {
        "reference/effects.md": effects_page(),
        "reference/models.md": models_page(),
        "reference/cli.md": cli_page(),
        "changelog.md": (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"),
    }


def effects_page() -> str:
    """Return the page of all effects, each with formula, source, coefficients and measurement."""
    lines = ["# Effects", "", "`tirefmu effects NAME` shows the same in a terminal.", ""]
    for effect in effects():
        lines += [f"## {effect['name']}", "", f"{_plain(effect['physics']).capitalize()}.", ""]
        facts = {
            "kind": effect["kind"],
            "models": ", ".join(effect["models"]),
            "source": effect["source"],
            "states": ", ".join(effect["states"]),
            "inputs that must vary": ", ".join(effect["needs"]),
            "channels": ", ".join(effect["channels"]),
            "confounded with": ", ".join(effect["confounded_with"]),
            "measurement": effect["separate_by"],
        }
        lines += [f"- {key}: {_plain(text)}" for key, text in facts.items() if text]
        for formula in effect["formulas"]:
            sign, text = ("*", formula["factor"]) if "factor" in formula else ("+", formula["term"])
            lines.append(f"- formula: `{formula['on']} {sign} ({text})`")
        lines += ["", "| coefficient | unit | description |", "|---|---|---|"]
        lines += [
            f"| {name} | {one['unit']} | {_plain(one['description'])} |" for name, one in effect["coefficients"].items()
        ]
        lines.append("")
    return "\n".join(lines)


def models_page() -> str:
    """Return the page of models and published tires."""
    lines = [
        "# Models and published tires",
        "",
        "| model | inputs | outputs | coefficients | |",
        "|---|---|---|---|---|",
    ]
    for each in models():
        lines.append(
            f"| `{each['name']}` | {' '.join(each['inputs'])} | {' '.join(each['outputs'])} | {each['coefficients']} "
            f"| {_plain(each['title'])} |"
        )
    lines += ["", "| tire | model | nominal load (N) | radius (m) | source |", "|---|---|---|---|---|"]
    for each in published_tires():
        source = _plain(each["about"].get("source", ""))
        lines.append(f"| `{each['name']}` | {each['model']} | {each['Fz0']:g} | {each['R0']:g} | {source} |")
    return "\n".join([*lines, ""])


def cli_page() -> str:
    """Return the page with the help of every command."""
    lines = ["# Commands and options", ""]
    parent = click.Context(cli, info_name="tirefmu", max_content_width=100, terminal_width=100)
    for name, command in sorted(cli.commands.items()):
        context = click.Context(command, info_name=name, parent=parent, max_content_width=100, terminal_width=100)
        lines += [f"## {name}", "", "```text", command.get_help(context), "```", ""]
    return "\n".join(lines)


def _plain(text: str) -> str:
    """Return a text for Markdown: no markup, no table cell ends."""
    return html_text(text).replace("|", "\\|").replace("_", "\\_").replace("*", "\\*")
