"""A tire as a Rust module without the standard library: functions of the crate libm, no allocation."""

from __future__ import annotations

from ....boundary.escaping import c_comment
from .expressions import RustPrinter
from .layout import Layout
from .program import PrintedProgram
from .rendering import render

LAYOUT = Layout(RustPrinter(), "let {name}: f64 = {value};", "// {}", c_comment)


def files(program: PrintedProgram) -> dict[str, str]:
    """Return the module, its self-test and their data: text by file name."""
    members = ", ".join(f"{name}: row[{i}]" for i, name in enumerate(program.input_names))
    return render(program, LAYOUT, {"{}.rs": "rust.rs", "{}_selftest.rs": "rust_selftest.rs"}, members=members)
