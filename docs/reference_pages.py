"""Pages of the documentation that are made from the code: effects, models, equations, the command line, Python names.

MkDocs calls `on_files` before it builds the site.
"""

from __future__ import annotations

import inspect
import json
import re
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
import sympy

import tirefmu
from tirefmu.boundary.escaping import html_text
from tirefmu.commands.cli import cli
from tirefmu.commands.schemas import KINDS, schema
from tirefmu.measurements.catalogue import effects, models, published_tires
from tirefmu.symbolic.added import library
from tirefmu.symbolic.model import Model
from tirefmu.symbolic.models import MODELS
from tirefmu.symbolic.printers.pages.mathml import equation_mathml

if TYPE_CHECKING:
    from mkdocs.config.defaults import MkDocsConfig
    from mkdocs.structure.files import Files

ROOT = Path(__file__).parents[1]
#: Number of equations that the entry of an effect lists for each model.
MAX_LINES = 6
#: Longest signature in one line.
WIDEST = 90


def on_files(files: Files, config: MkDocsConfig) -> Files:
    """Add the pages to the files of the site."""
    from mkdocs.structure.files import File

    for name, text in pages().items():
        files.append(File.generated(config, name, content=text))
    for kind in KINDS:
        text = json.dumps(schema(kind, cli), indent=1)
        files.append(File.generated(config, f"schemas/{kind}.json", content=text))
    for path in sorted((ROOT / "docs" / "tutorials").glob("*.md")):
        text = json.dumps(notebook(path.read_text(encoding="utf-8")), indent=1)
        files.append(File.generated(config, f"tutorials/{path.stem}.ipynb", content=text))
    return files


def pages() -> dict[str, str]:
    """Return the text of each page by its path."""
    return {
        "reference/effects.md": effects_page(),
        "reference/models.md": models_page(),
        "reference/cli.md": cli_page(),
        "reference/python.md": python_page(),
        **{f"reference/equations/{name}.md": equations_page(model) for name, model in MODELS.items()},
        "changelog.md": (ROOT / "CHANGELOG.md").read_text(encoding="utf-8"),
    }


def notebook(text: str) -> dict[str, Any]:
    """Return a tutorial as a Jupyter notebook: its blocks are cells, commands of the shell with an exclamation mark.

    Parameters
    ----------
    text : str
        Markdown with blocks of the languages ``python`` and ``sh``.

    Returns
    -------
    dict of str to Any
        JSON of the notebook format 4.5.
    """
    cells = []
    for part in re.split(r"^(```\w+\n.*?^```\n)", text, flags=re.MULTILINE | re.DOTALL):
        block = re.match(r"```(\w+)\n(.*)```", part, flags=re.DOTALL)
        source = block[2].strip() if block else part.strip()
        if block and block[1] == "sh":
            source = "\n".join(f"!{line}" for line in source.splitlines())
        if source:
            kind: dict[str, Any] = {"cell_type": "code", "execution_count": None, "outputs": []}
            cell = kind if block else {"cell_type": "markdown"}
            cells.append({**cell, "id": f"cell{len(cells)}", "metadata": {}, "source": source})
    kernel = {"display_name": "Python 3", "language": "python", "name": "python3"}
    return {"cells": cells, "metadata": {"kernelspec": kernel}, "nbformat": 4, "nbformat_minor": 5}


def effects_page() -> str:
    """Return the page of all effects, each with formula, source, coefficients and measurement."""
    lines = ["# Effects", "", "`tirefmu effects NAME` shows the same in a terminal.", ""]
    for effect in effects():
        lines += [f"## {effect['name']}", "", f"{_sentence(effect['physics'])}.", ""]
        facts = {
            "kind": effect["kind"],
            "models": ", ".join(effect["models"]),
            "source": effect["source"] or "the equations of the models, see below",
            "states": ", ".join(effect["states"]),
            "inputs that must vary": ", ".join(effect["needs"]),
            "channels": ", ".join(effect["channels"]),
            "confounded with": ", ".join(effect["confounded_with"]),
            "measurement": effect["separate_by"],
        }
        lines += [f"- {key}: {_plain(text)}" for key, text in facts.items() if text]
        lines += _formulas(effect)
        lines += ["", "| coefficient | unit | description |", "|---|---|---|"]
        lines += [
            f"| {name} | {c['unit']} | {_plain(c['description'])} |" for name, c in effect["coefficients"].items()
        ]
        lines.append("")
    return "\n".join(lines)


def _formulas(effect: dict[str, Any]) -> list[str]:
    """Return the formulas of an effect: what it adds, or the equations of models that it is part of."""
    added = library().get(effect["name"])
    if added is None:
        lines = []
        for model in effect["models"]:
            changed = [line for line in MODELS[model].structure.lines if effect["name"] in line.effects]
            numbers = {line.symbol.name: line.number for line in MODELS[model].equations}
            named = ", ".join(f"{_plain(line.name)} ({_plain(numbers[line.name])})" for line in changed[:MAX_LINES])
            more = f" and {len(changed) - MAX_LINES} more" if len(changed) > MAX_LINES else ""
            lines.append(f"- [equations of {model}](equations/{model}.md): {named}{more}")
        return lines
    lines = []
    for act in added.acts:
        before = sympy.Symbol(act.on)
        after = before * act.expression if act.how == "factor" else before + act.expression
        lines += ["", _equation(f"{act.on}_new", after)]
    return lines


def equations_page(model: Model) -> str:
    """Return the book of equations of a model: every line with number, description and unit."""
    lines = [
        f"# Equations: {_plain(model.title)}",
        "",
        "All effects of the model are on; options have their default. Coefficients are upright. In brackets: number",
        "in the source and unit. `tirefmu generate TIRE --language latex -o FOLDER` prints the equations of one tire.",
    ]
    written = model.as_written(model.effects)
    chapter = ""
    for line in model.equations:
        if line.variant:
            continue
        if line.chapter != chapter:
            chapter = line.chapter
            lines += ["", f"## {_plain(chapter)}", ""]
        unit = f", {line.unit}" if line.unit not in ("", "1") else ""
        about = f"{_sentence(line.description or 'step')} [{_plain(line.number)}{_plain(unit)}]"
        lines += [f"{about}:", "", _equation(line.symbol, written[line.symbol.name]), ""]
    return "\n".join(lines)


def _equation(symbol: sympy.Symbol | str, expression: sympy.Expr) -> str:
    return f'<div style="overflow-x: auto">{equation_mathml(symbol, expression)}</div>'


def python_page() -> str:
    """Return the page of the public names of Python with their docstrings."""
    lines = ["# Python", "", "The names of `import tirefmu`. The examples run as tests.", ""]
    for name in tirefmu.__all__:
        public = getattr(tirefmu, name)
        lines += [f"## {name}", "", *_documented(name, public)]
        if inspect.isclass(public):
            for key, member in vars(public).items():
                function = getattr(member, "__func__", member)
                if not key.startswith("_") and inspect.isfunction(function):
                    lines += [f"### {name}.{key}", "", *_documented(f"{name}.{key}", function)]
                elif not key.startswith("_") and isinstance(member, (property, cached_property)):
                    lines += [f"### {name}.{key}", "", *_sections(inspect.getdoc(member) or ""), ""]
    return "\n".join(lines)


def _documented(name: str, public: Any) -> list[str]:
    """Return signature and docstring."""
    try:
        given = inspect.signature(public)
    except ValueError:  # a class without a signature
        return _sections(inspect.getdoc(public) or "")
    parts: list[str] = []
    for parameter in given.parameters.values():
        if parameter.kind is inspect.Parameter.KEYWORD_ONLY and "*" not in parts:
            parts.append("*")
        if parameter.name != "self":
            parts.append(re.sub("'([^']*)'", r"\1", str(parameter), count=1))
    returned = "" if given.return_annotation in (inspect.Signature.empty, "None") else f" -> {given.return_annotation}"
    signature = f"{name}({', '.join(parts)}){returned}"
    if len(signature) > WIDEST:
        signature = f"{name}(\n    " + ",\n    ".join(parts) + f",\n){returned}"
    return ["```python", signature, "```", "", *_sections(inspect.getdoc(public) or ""), ""]


def _sections(docstring: str) -> list[str]:
    """Return a numpydoc docstring as Markdown: sections as bold lines, examples as code, the rest as it is."""
    lines: list[str] = []
    title, code = "", False
    given = docstring.splitlines()
    for line, following in zip(given, [*given[1:], ""], strict=True):
        if following and set(following) == {"-"}:
            title = line
            lines += ["", f"**{title}**", ""]
        elif line and set(line) == {"-"}:
            continue
        elif title == "Examples":
            if bool(line) != code:
                lines += ["```python" if line else "```"]
                code = bool(line)
            lines += [line] if line else [""]
        elif title and line and not line.startswith(" "):  # a parameter, a result or an error
            parameter, _, kind = line.partition(" : ")
            lines += ["", f"- `{parameter}`" + (f": {_plain(kind)}" if kind else ""), ""]
        else:
            lines.append(_prose(line))
    return [*lines, "```"] if code else lines


def _prose(line: str) -> str:
    """Return a line of a docstring: code in single or double backticks stays code."""
    parts = re.split(r"(`+[^`]+`+)", line)
    return "".join(f"`{part.strip('`')}`" if i % 2 else _plain(part) for i, part in enumerate(parts))


def models_page() -> str:
    """Return the page of models and published tires."""
    lines = [
        "# Models and published tires",
        "",
        "| model | inputs | outputs | coefficients | |",
        "|---|---|---|---|---|",
    ]
    for model in models():
        lines.append(
            f"| `{model['name']}` | {' '.join(model['inputs'])} | {' '.join(model['outputs'])} "
            f"| {model['coefficients']} | {_plain(model['title'])} |"
        )
    lines += ["", "| tire | model | nominal load (N) | radius (m) | source |", "|---|---|---|---|---|"]
    for tire in published_tires():
        source = _plain(tire["about"].get("source", ""))
        lines.append(f"| `{tire['name']}` | {tire['model']} | {tire['Fz0']:g} | {tire['R0']:g} | {source} |")
    return "\n".join([*lines, ""])


def cli_page() -> str:
    """Return the page with the help of every command."""
    lines = ["# Commands and options", ""]
    parent = click.Context(cli, info_name="tirefmu", max_content_width=100, terminal_width=100)
    for name, command in sorted(cli.commands.items()):
        context = click.Context(command, info_name=name, parent=parent, max_content_width=100, terminal_width=100)
        lines += [f"## {name}", "", "```text", command.get_help(context), "```", ""]
    return "\n".join(lines)


def _sentence(text: str) -> str:
    """Return a text for Markdown that starts with a capital letter."""
    return _plain(text[:1].upper() + text[1:])


def _plain(text: str) -> str:
    """Return a text for Markdown: no markup, no table cell ends."""
    return html_text(text).replace("|", "\\|").replace("_", "\\_").replace("*", "\\*")
