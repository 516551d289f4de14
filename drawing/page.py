"""A report as one self-contained HTML page with any texts; its only script draws charts of its figures."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Callable, Mapping
from importlib.resources import files
from pathlib import Path
from types import CodeType
from typing import Any, ClassVar

from jinja2 import BytecodeCache, DictLoader, Environment, StrictUndefined
from jinja2.bccache import Bucket
from markupsafe import Markup

from ..boundary.bounded_file import write_whole
from ..boundary.escaping import visible
from .chart_data import chart_data
from .chart_library import LIBRARY_SCRIPT, LIBRARY_STYLE, allowed, library_file
from .figure import Figure

#: Common parts of all pages: the frame with the style, and tables and figures that scroll on a narrow screen.
FRAME, PARTS, STYLE = "page.html", "parts.html", "page.css"
#: The script that draws charts of figures in a page.
CHART_SCRIPT, CHART_STYLE = "panels.js", "panels.css"


def page_text(
    package: str, filters: Mapping[str, Callable[..., object]], *, template: str = "report.html", **content: Any
) -> str:
    """Return the text of a package's report.

    All texts are escaped, and control characters and marks of the writing direction are made visible. The content
    security policy of the template allows embedded images, and one script, which draws charts of figures. It is part of
    the page if the page has a figure. The first figure is also drawn as a picture, which is shown in print and without
    scripts.

    `package`: package with the template: "tirefmu.fitting.reporting", "tirefmu.diagnosis.reporting". `filters`: filters
    of the template by name. `template`: file of the package; it extends ``page.html`` of this one. `**content`:
    variables of the template.
    """
    source = (files(package) / template).read_text(encoding="utf-8")
    environment = Environment(
        autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True, finalize=_visible,
        loader=DictLoader({**{name: _shared(name) for name in (FRAME, PARTS, STYLE)}, template: source}),
        bytecode_cache=_Compiled(),
    )  # fmt: skip
    script = f"{library_file(LIBRARY_SCRIPT)}\n{_shared(CHART_SCRIPT)}"
    environment.globals |= {
        "charted": [],  # titles of the figures so far: the script is last in the page
        "chart_script": Markup(script), "allowed_script": Markup(allowed(script)),
        "chart_style": Markup(f"{library_file(LIBRARY_STYLE)}\n{_shared(CHART_STYLE)}"),
    }  # fmt: skip
    environment.filters |= {"sentence": _sentence, "chart_data": chart_data, "still": _still, **filters}
    return environment.get_template(template).render(**content)


class _Compiled(BytecodeCache):
    """Templates that were compiled in this process, which takes half of the time of a page without figures."""

    codes: ClassVar[dict[tuple[str, str], CodeType | None]] = {}

    def load_bytecode(self, bucket: Bucket) -> None:
        """Find the code of a template with the same text."""
        bucket.code = self.codes.get((bucket.key, bucket.checksum))

    def dump_bytecode(self, bucket: Bucket) -> None:
        """Store the code of a template."""
        self.codes[bucket.key, bucket.checksum] = bucket.code


def _sentence(text: str) -> str:
    """Return a text with a capital first letter; unlike capitalize, it does not change the other letters."""
    return text[:1].upper() + text[1:]


def _still(figure: Figure) -> str:
    """Return the picture of a figure for a page."""
    from .picture import PAGE_DPI, png  # imports matplotlib, which is slow

    return b64encode(png(figure, PAGE_DPI)).decode("ascii")


def style_sheet() -> str:
    """Return the style that all pages share."""
    return _shared(STYLE)


def _shared(name: str) -> str:
    return (files(__package__) / name).read_text(encoding="utf-8")


def _visible(value: object) -> str:
    """Return a value as text without invisible characters; the output of a macro is already escaped."""
    return value if isinstance(value, Markup) else visible(str(value))


def write_page(page: str, path: Path) -> None:
    """Write a page; the file is complete or not written.

    Raises `OSError` if the file cannot be written.
    """
    write_whole(path, page.encode("utf-8"))
