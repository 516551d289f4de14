"""The files of a proof: their places in an FMU, the manifest that lists them, and the page about them.

The layout follows FMI-LS-REF, a layered standard in work at the FMI project: it is experimental.

Source: https://github.com/modelica/fmi-ls-ref, version 1.0.0-alpha.1.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from importlib.resources import files
from typing import Any

from ...boundary.escaping import html_text

#: The version of FMI-LS-REF that the layout follows, and the version of proof.json.
LAYOUT, FORMAT = "1.0.0-alpha.1", 1
NAME = "org.fmi-standard.fmi-ls-ref"
ROOT = f"extra/{NAME}/"
MANIFEST, PROOF = f"{ROOT}fmi-ls-manifest.xml", f"{ROOT}proof.json"
STIMULI, REFERENCE = f"{ROOT}stimuli.csv", f"{ROOT}reference.csv"
PAGE, SCRIPT, INDEX = "documentation/fmi-ls-ref.html", "documentation/check_proof.py", "documentation/index.html"
#: Related files: media type, path relative to the manifest, role of FMI-LS-REF, description.
RELATED = (
    ("text/csv", "stimuli.csv", "testcase", "Inputs of the proof by time"),
    ("text/csv", "reference.csv", "result", "Outputs that the FMU must reproduce"),
    ("application/json", "proof.json", "meta-data", "Tolerance, segments, provenance and digests of the proof"),
    ("text/html", f"../../{PAGE}", "report", "What the proof contains and how to repeat it"),
    ("text/x-python", f"../../{SCRIPT}", "testcase", "Program that repeats the proof with FMPy"),
    ("text/plain", "../../resources/tire.tir", "model", "Coefficients of the tire"),
)
DIRECT, SIMULATED = "direct evaluation of the tire", "simulation of the FMU when the proof was written"


def manifest() -> bytes:
    """Return fmi-ls-manifest.xml.

    >>> manifest().count(b"<Related ")
    6
    """
    purpose = "Layered Standard providing information on related files included in an FMU."  # as its schema requires
    entries = [
        f'  <Related type="{kind}" source="{source}" role="{role}" description="{text}"/>'
        for kind, source, role, text in RELATED
    ]
    lines = [
        '<?xml version="1.0" encoding="UTF-8"?>',
        '<fmiReferences xmlns:fmi-ls="http://fmi-standard.org/fmi-ls-manifest"',
        f'  fmi-ls:fmi-ls-name="{NAME}" fmi-ls:fmi-ls-version="{LAYOUT}" fmi-ls:fmi-ls-description="{purpose}">',
        *entries,
        "</fmiReferences>",
    ]
    return ("\n".join(lines) + "\n").encode()


def script() -> bytes:
    """Return the program that repeats a proof with FMPy and NumPy only."""
    return (files("tirefmu.fmu.proof") / "check_proof.py").read_bytes()


def page(proof: Mapping[str, Any]) -> bytes:
    """Return documentation/fmi-ls-ref.html.

    `proof`: contents of proof.json without digests.
    """
    lines = [
        '<!DOCTYPE html>\n<html lang="en"><head><meta charset="utf-8"><title>Proof</title></head><body>',
        "<h1>Proof</h1>",
        f"<p>The FMU reproduces {proof['rows']} rows of outputs within {proof['tolerance']:g} of 1 + |reference|.",
        f"The reference is the {html_text(proof['reference'])}.",
        "Every file of the FMU has a SHA-256 digest in proof.json.</p>",
        "<p>The command <code>check</code> of tirefmu repeats it, and so does FMPy alone:",
        "<code>python check_proof.py FMU</code>. Both print the digest of proof.json. Compare it with the digest that",
        "the author of the FMU states: a change of a file and of its digest in proof.json changes it.</p>",
        f"<p>Layout: FMI-LS-REF {LAYOUT}, experimental.</p>",
        *_table("Verdict on the fit", ("verdict, reasons",), [[line] for line in proof["verdict"]]),
        *_table("Ranges of the table", ("input", "low", "high"), proof["ranges"]),
        *_table("Agreement with the measured table", ("channel", "rows", "RMSE", "unit", "R2"), proof["agreement"]),
        *_table("Tire", ("entry", "text"), proof["tire"]),
        *_table("Provenance", ("source", "text"), proof["provenance"]),
        "</body></html>",
    ]
    return ("\n".join(lines) + "\n").encode()


def _table(title: str, header: Iterable[str], rows: Iterable[Iterable[Any]]) -> Iterable[str]:
    shown = [[f"{cell:.6g}" if isinstance(cell, float) else str(cell) for cell in row] for row in rows]
    if shown:
        yield f"<h2>{title}</h2><table><tr>{''.join(f'<th>{name}</th>' for name in header)}</tr>"
        for row in shown:
            yield f"<tr>{''.join(f'<td>{html_text(cell)}</td>' for cell in row)}</tr>"
        yield "</table>"
