"""A two-track vehicle: its equations in SymPy, and the Python functions printed from them.

The body moves in the plane and has roll and pitch with linear springs and dampers. Each of the four wheels spins.
The loads follow from the springs, so that there is no algebraic loop of tire forces and loads. Axes are those of ISO
8855: x forward, y left, z up, roll positive to the right, pitch positive nose down. The equations of the body are those
of Newton and Euler for small angles. For models of this kind see Schramm, Hiller, Bardini, Vehicle Dynamics (2018),
chapter 10.
"""

from __future__ import annotations

import sympy as sp
from sympy.printing.pycode import PythonCodePrinter

CORNERS = ("fl", "fr", "rl", "rr")

STATES = ("v_x", "v_y", "yaw_rate", "roll", "roll_rate", "pitch", "pitch_rate", *(f"omega_{c}" for c in CORNERS))
#: Inputs of the driver: steering angle of the front wheels, rad, brake torque of each front and rear wheel, N m.
CONTROLS = ("steer", "brake_front", "brake_rear")
#: Outputs of the tires in their W axes: N, N, N m.
FORCES = tuple(f"{name}_{c}" for c in CORNERS for name in ("Fx", "Fy", "Mz"))
#: Inputs of the tires: 1, rad, rad, N.
SLIPS = tuple(f"{name}_{c}" for c in CORNERS for name in ("kappa", "alpha", "gamma", "Fz"))

#: A Formula Student car, SI units.
PARAMETERS = {
    "m": 290.0, "I_x": 45.0, "I_y": 110.0, "I_z": 130.0, "I_w": 0.45,
    "l_f": 0.80, "l_r": 0.75, "w_f": 1.22, "w_r": 1.18, "h": 0.30, "R": 0.225,
    "c_f": 16000.0, "c_r": 14000.0, "d_f": 900.0, "d_r": 800.0, "c_p": 42000.0, "d_p": 3000.0,
    "roll_camber": 0.4, "g": 9.81,
}  # fmt: skip

Lines = dict[str, sp.Expr]


def symbols(names: tuple[str, ...]) -> tuple[sp.Symbol, ...]:
    """Return real symbols."""
    return tuple(sp.Symbol(name, real=True) for name in names)


def _corners() -> dict[str, tuple[sp.Expr, sp.Expr, sp.Expr]]:
    """Return x and y of each wheel from the centre of gravity, and its steering angle."""
    l_f, l_r, w_f, w_r, steer = symbols(("l_f", "l_r", "w_f", "w_r", "steer"))
    return {
        "fl": (l_f, w_f / 2, steer),
        "fr": (l_f, -w_f / 2, steer),
        "rl": (-l_r, w_r / 2, sp.S.Zero),
        "rr": (-l_r, -w_r / 2, sp.S.Zero),
    }


def slips() -> Lines:
    """Return the inputs of the tires as functions of states and controls."""
    v_x, v_y, yaw_rate, roll, roll_rate, pitch, pitch_rate = symbols(STATES[:7])
    m, g, l_f, l_r, w_f, w_r, R, c_p, d_p, camber = symbols(
        ("m", "g", "l_f", "l_r", "w_f", "w_r", "R", "c_p", "d_p", "roll_camber")
    )
    dive = (c_p * pitch + d_p * pitch_rate) / (l_f + l_r)
    lines: Lines = {}
    for corner, (x, y, turned) in _corners().items():
        axle, width, other, shifted = ("f", w_f, l_r, dive) if corner[0] == "f" else ("r", w_r, l_f, -dive)
        c, d, omega = symbols((f"c_{axle}", f"d_{axle}", f"omega_{corner}"))
        along, across = v_x - yaw_rate * y, v_y + yaw_rate * x
        rolling = along * sp.cos(turned) + across * sp.sin(turned)
        sliding = across * sp.cos(turned) - along * sp.sin(turned)
        side = 1 if corner[1] == "l" else -1
        lines[f"kappa_{corner}"] = (omega * R - rolling) / rolling
        lines[f"alpha_{corner}"] = sp.atan(sliding / rolling)
        lines[f"gamma_{corner}"] = camber * roll
        lines[f"Fz_{corner}"] = (
            m * g * other / (l_f + l_r) / 2 + shifted / 2 - side * (c * roll + d * roll_rate) / width
        )
    return lines


def derivatives() -> Lines:
    """Return the time derivative of each state as a function of states, controls and tire forces."""
    v_x, v_y, yaw_rate, roll, roll_rate, pitch, pitch_rate = symbols(STATES[:7])
    m, I_x, I_y, I_z, I_w, h, R = symbols(("m", "I_x", "I_y", "I_z", "I_w", "h", "R"))
    c_f, c_r, d_f, d_r, c_p, d_p = symbols(("c_f", "c_r", "d_f", "d_r", "c_p", "d_p"))
    forward, left, turning = sp.S.Zero, sp.S.Zero, sp.S.Zero
    spins: Lines = {}
    for corner, (x, y, turned) in _corners().items():
        Fx, Fy, Mz, omega = symbols((f"Fx_{corner}", f"Fy_{corner}", f"Mz_{corner}", f"omega_{corner}"))
        (brake,) = symbols(("brake_front" if corner[0] == "f" else "brake_rear",))
        along = Fx * sp.cos(turned) - Fy * sp.sin(turned)
        across = Fx * sp.sin(turned) + Fy * sp.cos(turned)
        forward, left, turning = forward + along, left + across, turning + x * across - y * along + Mz
        spins[f"omega_{corner}"] = (-R * Fx - brake * sp.tanh(omega)) / I_w  # smooth at standstill
    return {
        "v_x": forward / m + yaw_rate * v_y,
        "v_y": left / m - yaw_rate * v_x,
        "yaw_rate": turning / I_z,
        "roll": roll_rate,
        "roll_rate": (h * left - (c_f + c_r) * roll - (d_f + d_r) * roll_rate) / I_x,
        "pitch": pitch_rate,
        "pitch_rate": (-h * forward - c_p * pitch - d_p * pitch_rate) / I_y,
        **spins,
    }


def function(name: str, arguments: tuple[tuple[str, ...], ...], lines: Lines) -> str:
    """Return the text of a Python function of sequences that returns the values of the equations as a list."""
    values = {sp.Symbol(key, real=True): sp.Float(value) for key, value in PARAMETERS.items()}
    expressions = [line.subs(values) for line in lines.values()]
    shared, results = sp.cse(expressions, symbols=sp.numbered_symbols("x_"))
    printer = PythonCodePrinter({"fully_qualified_modules": False})
    groups = [f"g{i}" for i in range(len(arguments))]
    text = [f"def {name}({', '.join(groups)}):"]
    text += [f"    {', '.join(names)} = {group}" for names, group in zip(arguments, groups, strict=True)]
    text += [f"    {symbol} = {printer.doprint(value)}" for symbol, value in shared]
    text += ["    return [", *(f"        {printer.doprint(result)}," for result in results), "    ]"]
    return "\n".join(text)


def printed() -> str:
    """Return the text of the module that both the FMU and the monolithic simulation run."""
    names = {"STATES": STATES, "CONTROLS": CONTROLS, "FORCES": FORCES, "SLIPS": SLIPS, "RADIUS": PARAMETERS["R"]}
    return "\n\n\n".join(
        [
            '"""Printed from vehicle_equations.py."""\n\nfrom math import atan, cos, sin, tanh\n\n'
            + "\n".join(f"{name} = {value!r}" for name, value in names.items()),
            function("slips", (STATES, CONTROLS), slips()),
            function("derivatives", (STATES, CONTROLS, FORCES), derivatives()) + "\n",
        ]
    )
