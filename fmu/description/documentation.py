"""The documentation inside an FMU: documentation/index.html and the licenses."""

from __future__ import annotations

import importlib.metadata
import re
from collections.abc import Sequence
from functools import cache
from importlib.resources import files
from pathlib import Path

from jinja2 import Environment, StrictUndefined, Template
from markupsafe import Markup

from ...boundary.errors import FmuError
from ...boundary.escaping import html_text
from ...tires import Tire
from .model_description import Header
from .variables import Variable


def index_html(tire: Tire, header: Header, variables: Sequence[Variable]) -> bytes:
    """Return documentation/index.html.

    `header`: of the model description.

    >>> from tirefmu.tires import published
    >>> b"<h1>a &lt; b</h1>" in index_html(published("trento_hoosier"), Header("a < b", "a", "", ()), [])
    True
    """
    by_causality = {
        causality: [v for v in variables if v.causality == causality]
        for causality in ("input", "output", "parameter", "local")
    }
    names = {variable.name for variable in by_causality["input"]}
    return (_page().render(tire=tire, header=header, names=names, variables=by_causality) + "\n").encode()


@cache
def _page() -> Template:
    environment = Environment(
        autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True, finalize=_escaped
    )
    return environment.from_string((files(__package__) / "documentation.html").read_text(encoding="utf-8"))


def _escaped(value: object) -> Markup:
    """Return a value as HTML; a part of the template that is HTML already stays."""
    return value if isinstance(value, Markup) else Markup(html_text(str(value)))


def license_of(distribution: str) -> str:
    """Return the texts of the license files of an installed package.

    Raises `FmuError` if it is not installed.

    >>> license_of("tirefmu").splitlines()[0]
    'BSD 3-Clause License'
    """
    try:
        installed = importlib.metadata.distribution(distribution)
    except importlib.metadata.PackageNotFoundError as error:
        raise FmuError(f"the package {distribution} is not installed: pip install {distribution}") from error
    licenses = [path for path in installed.files or () if re.search("licen[sc]e", path.name, re.IGNORECASE)]
    return "\n".join(path.read_text(encoding="utf-8") for path in licenses)


def header_license(header: Path) -> bytes:
    """Return the license notice of the FMI standard's header. The license requires it with binaries.

    `header`: one of the standard's C headers. Raises `FmuError` if the header cannot be read or contains no notice.
    """
    try:
        text = header.read_text(encoding="utf-8")
    except OSError as error:
        raise FmuError(f"the FMI header {header.name} cannot be read: {error.strerror}") from error
    notice = re.search(r"Copyright \(C\).*?(?=\*/)", text, re.DOTALL)
    if notice is None:
        raise FmuError(f"the FMI header {header.name} contains no license")
    lines = [line.strip() for line in notice[0].splitlines()]
    return ("Headers of the FMI standard\n\n" + "\n".join(lines).rstrip() + "\n").encode()
