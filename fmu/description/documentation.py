"""The documentation inside an FMU: documentation/index.html and the licenses."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from pathlib import Path

from tirefmu.boundary.errors import FmuError
from tirefmu.boundary.escaping import html_text
from tirefmu.tires import Tire

from .model_description import Header
from .variables import Variable

#: The license of the sources inside an FMU; the same text as the project's LICENSE file.
LICENSE = """\
BSD 3-Clause License

Copyright (c) 2026, tirefmu contributors

Redistribution and use in source and binary forms, with or without
modification, are permitted provided that the following conditions are met:

1. Redistributions of source code must retain the above copyright notice, this
   list of conditions and the following disclaimer.

2. Redistributions in binary form must reproduce the above copyright notice,
   this list of conditions and the following disclaimer in the documentation
   and/or other materials provided with the distribution.

3. Neither the name of the copyright holder nor the names of its
   contributors may be used to endorse or promote products derived from
   this software without specific prior written permission.

THIS SOFTWARE IS PROVIDED BY THE COPYRIGHT HOLDERS AND CONTRIBUTORS "AS IS"
AND ANY EXPRESS OR IMPLIED WARRANTIES, INCLUDING, BUT NOT LIMITED TO, THE
IMPLIED WARRANTIES OF MERCHANTABILITY AND FITNESS FOR A PARTICULAR PURPOSE ARE
DISCLAIMED. IN NO EVENT SHALL THE COPYRIGHT HOLDER OR CONTRIBUTORS BE LIABLE
FOR ANY DIRECT, INDIRECT, INCIDENTAL, SPECIAL, EXEMPLARY, OR CONSEQUENTIAL
DAMAGES (INCLUDING, BUT NOT LIMITED TO, PROCUREMENT OF SUBSTITUTE GOODS OR
SERVICES; LOSS OF USE, DATA, OR PROFITS; OR BUSINESS INTERRUPTION) HOWEVER
CAUSED AND ON ANY THEORY OF LIABILITY, WHETHER IN CONTRACT, STRICT LIABILITY,
OR TORT (INCLUDING NEGLIGENCE OR OTHERWISE) ARISING IN ANY WAY OUT OF THE USE
OF THIS SOFTWARE, EVEN IF ADVISED OF THE POSSIBILITY OF SUCH DAMAGE.
"""

_STYLE = (
    "body{font-family:sans-serif;max-width:60em;margin:2em auto}"
    "table{border-collapse:collapse}td,th{padding:.2em .8em;text-align:left;border-bottom:1px solid #ccc}"
    "td.number{text-align:right;font-variant-numeric:tabular-nums}"
)


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
    lines = [
        "<!DOCTYPE html>",
        f'<html lang="en"><head><meta charset="utf-8"><title>{html_text(header.name)}</title>',
        f"<style>{_STYLE}</style></head><body>",
        f"<h1>{html_text(header.name)}</h1>",
        f"<p>{html_text(header.description)}</p>",
        f"<p>Model: {html_text(tire.symbolic_model.title)}.",
        f"Effects: {html_text(', '.join(sorted(tire.has)) or 'none')}.",
        "The tire file is resources/tire.tir. License: licenses/license.txt.</p>",
        *((f"<p>Assumption: {html_text(header.note)}.</p>",) if header.note else ()),
        *_about(tire),
        *_how_to_connect(tire, by_causality["input"]),
        "<h2>Inputs</h2>",
        *_table(by_causality["input"], "start value"),
        "<h2>Outputs</h2>",
        *_table(by_causality["output"], ""),
        *(_transient(by_causality["local"]) if by_causality["local"] else ()),
        "<h2>Parameters</h2>",
        "<p>All parameters are tunable: a host can set them before and during a simulation. The coefficients of an",
        "effect that the tire lacks have neutral values; the effect acts when they are set. Relaxation, turn slip and",
        "added effects act only in the FMU of a tire that has them.</p>",
        *_table(by_causality["parameter"], "value"),
        "</body></html>",
    ]
    return ("\n".join(lines) + "\n").encode()


def _about(tire: Tire) -> Iterable[str]:
    """Yield the source of the tire and the ranges in which it is valid."""
    rows = [(key, text) for key, text in tire.about.items()]
    rows += [(f"range of {name}", f"{low:g} ... {high:g}") for name, (low, high) in tire.ranges.items()]
    if rows:
        yield "<h2>The tire</h2><table>"
        for key, text in rows:
            yield f"<tr><th>{html_text(key)}</th><td>{html_text(text)}</td></tr>"
        yield "</table>"


def _how_to_connect(tire: Tire, inputs: Sequence[Variable]) -> Iterable[str]:
    """Yield instructions for connecting the inputs and outputs."""
    names = {variable.name for variable in inputs}
    yield "<h2>How to connect</h2>"
    yield "<p>One instance is one wheel. Outputs belong to the present inputs: set inputs, read forces, do a step."
    yield "Forces and moments act on the wheel at its contact point, in the wheel's own axes (TYDEX W where the"
    yield "sentence above states ISO axes). The FMU rejects a value that is not finite and does not change its state."
    yield "An unconnected input has its start value. Fz is load, positive in ISO axes; at Fz = 0 all forces are 0.</p>"
    if "r_x" in names:
        yield from _hub("T_drive" in names)
        yield from _standstill(True)
    elif "V_x" in names:
        yield "<p>V_x and V_y are the velocity of the contact point, which moves with the wheel's centre, in the plane"
        yield "of the road: along the wheel plane and across it. omega is the angular speed of the wheel, 0 if locked."
        yield "Apply Fx at the loaded radius R_l, if it is an output, in the wheel's equation of motion.</p>"
        yield from _standstill("psi_dot" in names)
    else:
        yield f"<p>{_slips(tire)}</p>"


def _slips(tire: Tire) -> str:
    """Return the definition of the slips in both directions of travel."""
    if tire.symbolic_model.motion.reverses:
        return "kappa = (omega R_e - V_x)/V_x, also with V_x < 0; tan(alpha) = V_y/|V_x|."
    if "V" in tire.inputs:
        return "kappa = (omega R_e - V_x)/|V_x|, tan(alpha) = V_y/|V_x|; Mz is that of a wheel that rolls forward."
    return "kappa = (omega R_e - V_x)/V_x, tan(alpha) = V_y/V_x; in reverse the host mirrors Fx and Mz."


def _hub(spins: bool) -> Iterable[str]:
    """Yield the section about the wheel carrier and the road."""
    yield "<p>r is the position of the wheel centre; R_11 to R_33 the orientation of the wheel carrier, whose columns"
    yield "are its axes in global axes: x forward, y to the left along the spin axis, z up. Velocities v and w are in"
    yield "global axes. The road is a plane: its height road_z at r_x, r_y, its normal, and its velocity. On an uneven"
    yield "road, give the plane that touches the road near the contact point c_x, c_y, c_z. Forces F and moments M act"
    yield "on the wheel at its centre, in the axes of the carrier and in global axes. The load is that at which the"
    yield "loaded radius of the model is the distance R_l of the wheel centre from the contact point, with"
    yield "VERTICAL_DAMPING and, below BOTTOM_RADIUS, with BOTTOM_STIFF in addition; it is constant over a step.</p>"
    if spins:
        yield "<p>The spin omega, relative to the carrier, is a state: it follows from T_drive, M_y and a brake, which"
        yield "holds the wheel or slows it by T_brake. The carrier has the moments M_x and M_z, and -brake_torque about"
        yield "its y axis in place of M_y. Gyroscopic moments of the wheel are those of the host.</p>"


def _standstill(turns: bool) -> Iterable[str]:
    """Yield the section about a wheel at rest and close to it."""
    yield "<h2>Standstill</h2>"
    yield "<p>A tire at rest is a spring with a damper (LOW_SPEED_DAMPING, relative to the critical damping of"
    yield "the load; one tenth of it for a wheel that turns). It holds a car on a slope without creep. A"
    yield "relaxation length that the tire lacks is DEFAULT_SIGMA; with DEFAULT_SIGMA = 0 the slip has no lag,"
    yield "and the tire is a damper only. Below LOW_SPEED the forces at zero slip (shifts, ply-steer, conicity,"
    yield "camber thrust) fade out. The vector of Fx and Fy is limited to the friction ellipse below 2"
    yield "LOW_SPEED; the limit fades out up to 3 LOW_SPEED, unless FRICTION_LIMIT is 1.</p>"
    if turns:
        yield "<p>Turn slip psi_dot/V fades out below LOW_SPEED. A wheel that turns on the spot has no side force"
        yield "and a moment that grows with the twist of the contact patch up to the friction torque: M_zphi_inf of"
        yield "a tire with turn slip, otherwise 9/8 mu_y Fz times the trail at zero slip.</p>"
    yield "<p>A host that holds forces over a step must resolve the oscillation of the wheel on the tire's"
    yield "spring: with inertia J, slip stiffness K and relaxation length sigma, steps below sqrt(J sigma / K)"
    yield "/ R, 2 to 5 ms for a passenger car. Set the velocities at the end of the step before doStep: with"
    yield "those of its begin, the coupling itself excites the wheel. With the FMU's directional derivatives in"
    yield "an implicit method, steps of 20 ms are stable.</p>"


def _transient(local: Sequence[Variable]) -> Iterable[str]:
    """Yield the section about states."""
    yield "<h2>States</h2>"
    yield "<p>The slips have a first-order lag: d x/dt = |V|/sigma (u - x) for kappa and tan(alpha). Co-Simulation uses"
    yield "the exact solution for inputs that are constant over a step of any size. The slips start in steady state for"
    yield "the inputs at the end of initialization: set the inputs before. The distance starts at its start value.</p>"
    if "twist" in {variable.name for variable in local}:
        yield "<p>The twist of the contact patch follows the yaw rate, d twist/dt = psi_dot - (|psi_dot|/0.1 rad +"
        yield "|V|/0.1 m) twist. It starts at 0.</p>"
    yield from _table(local, "")


def _table(variables: Sequence[Variable], value: str) -> Iterable[str]:
    """Yield the lines of a table of variables; `value` is the heading of the start values, empty for no column."""
    yield f"<table><tr><th>name</th>{f'<th>{value}</th>' if value else ''}<th>unit</th><th>meaning</th></tr>"
    for variable in variables:
        number = f'<td class="number">{variable.start!r}</td>' if value else ""
        yield (
            f"<tr><td>{html_text(variable.name)}</td>{number}<td>{html_text(variable.unit)}</td>"
            f"<td>{html_text(variable.description)}</td></tr>"
        )
    yield "</table>"


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
