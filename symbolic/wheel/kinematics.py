"""Wheel kinematics: contact point, W axes and slip velocities from the motion of the wheel carrier; forces at the hub.

ISO 8855 and TYDEX: the contact point is the intersection of the road plane, the wheel plane and the plane through the
spin axis that is normal to the road. The W axes are x along the intersection of wheel plane and road, z along the
normal of the road. After Pacejka, Tire and Vehicle Dynamics (2012), section 2.2: the velocity of the contact point is
the rate of its position, and the wheel turns relative to the W axes.

The lines are functions of real numbers. `tirefmu.symbolic.printers.line_functions` prints them for NumPy, CasADi and
C; C code also has their tangents.
"""

from __future__ import annotations

from collections.abc import Sequence

from sympy import Expr, Symbol, atan, sqrt

from ..declarations import Quantity
from ..line_function import LineFunction, names
from ..notation import Chapter
from . import quantities as hub

Vector = tuple[Expr, Expr, Expr]

eq = Chapter("Wheel kinematics")


def dot(a: Sequence[Expr], b: Sequence[Expr]) -> Expr:
    """Return the scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Sequence[Expr], b: Sequence[Expr]) -> Vector:
    """Return the vector product."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def combined(factors: Sequence[Expr], vectors: Sequence[Sequence[Expr]]) -> Vector:
    """Return the sum of vectors with three factors."""
    x, y, z = (dot(factors, [vector[i] for vector in vectors]) for i in range(3))
    return x, y, z


def vector(number: str, name: str, components: Vector, unit: str, description: str) -> Vector:
    """File a line for each component."""
    x, y, z = (
        eq(number, f"{name}_{axis}", component, unit, f"{description}, global {axis}", named=False)
        for axis, component in zip(hub.AXES, components, strict=True)
    )
    return x, y, z


def line(number: str, quantity: Quantity, expression: Expr) -> Symbol:
    """File the line of a quantity."""
    return eq(number, quantity.name, expression, quantity.unit, quantity.description)


def symbols(quantities: Sequence[Quantity]) -> list[Symbol]:
    """Return the symbols of some quantities."""
    return [quantity.symbol for quantity in quantities]


def unit_vector(name: str, components: Sequence[Expr], description: str) -> Vector:
    """File a vector of length 1."""
    length = eq("ISO 8855", f"{name}_length", sqrt(dot(components, components)), "1", f"length of {name}", named=False)
    x, y, z = components
    return vector("ISO 8855", name, (x / length, y / length, z / length), "1", description)


r, v, w = symbols(hub.POSITION), symbols(hub.VELOCITY), symbols(hub.TURNING)
R = symbols(hub.ROTATION)
columns = [R[j::3] for j in range(3)]

# fmt: off
# The axes: n is the normal of the road, s the spin axis; x, y and n are the W axes; u points up in the wheel plane.
n = unit_vector("n", symbols(hub.NORMAL), "normal of the road")
s = unit_vector("s", columns[1], "spin axis")
sin_gamma = eq("Pacejka 2.2", "sin_gamma", dot(s, n), "1", "sine of the inclination angle", named=False)
ahead     = vector("Pacejka 2.2", "ahead", cross(s, n), "1", "direction of the wheel plane on the road")
cos_gamma = eq("Pacejka 2.2", "cos_gamma", sqrt(dot(ahead, ahead)), "1", "cosine of the inclination angle", named=False)
x = vector("ISO 8855", "x_W", (ahead[0]/cos_gamma, ahead[1]/cos_gamma, ahead[2]/cos_gamma), "1", "W x axis")
y = vector("ISO 8855", "y_W", cross(n, x), "1", "W y axis")
u = vector("ISO 8855", "u", cross(x, s), "1", "direction from the contact point to the wheel centre")

# The contact point.
gamma = line("Pacejka 2.2", hub.MOTION[4], atan(sin_gamma / cos_gamma))
Rl    = line("ISO 8855", hub.LOADED_RADIUS, (r[2] - hub.HEIGHT.symbol) * n[2] / cos_gamma)
for c, centre, up in zip(hub.CONTACT_POINT, r, u, strict=True):
    line("ISO 8855", c, centre - Rl * up)

# Its velocity relative to the road.
past      = vector("Pacejka 2.2", "past", (v[0] - hub.ROAD_VELOCITY[0].symbol, v[1] - hub.ROAD_VELOCITY[1].symbol,
                                   v[2] - hub.ROAD_VELOCITY[2].symbol), "m/s", "velocity relative to the road")
gamma_dot = eq("Pacejka 2.2", "gamma_dot", dot(w, x), "rad/s", "rate of the inclination angle", named=False)
psi_dot   = line("Pacejka 2.2", hub.MOTION[3], dot(w, u) / cos_gamma)
Rl_rate   = line("Pacejka 2.2", hub.RADIUS_RATE, (dot(past, n) + Rl * sin_gamma * gamma_dot) / cos_gamma)
line("Pacejka 2.2", hub.MOTION[0], dot(past, x) - psi_dot * Rl * sin_gamma)
line("Pacejka 2.2", hub.MOTION[1], dot(past, y) + gamma_dot * Rl * cos_gamma + Rl_rate * sin_gamma)
line("Pacejka 2.2", hub.MOTION[2], hub.SPIN.symbol + dot(w, s) - psi_dot * sin_gamma)

# The contact forces, moved to the wheel centre.
Fx, Fy, Fz, Mx, My, Mz = symbols(hub.CONTACT_FORCES)
force  = combined((Fx, Fy, Fz), (x, y, n))
moment = combined((Mx, My, Mz), (x, y, n))
arm    = eq("ISO 8855", "overturning", Rl * (Fy * cos_gamma + Fz * sin_gamma),
            "N m", "moment of the contact forces about the W x axis", named=False)
F = [line("ISO 8855", q, force[i]) for i, q in enumerate(hub.GLOBAL_WRENCH[:3])]
M = [line("ISO 8855", q, moment[i] + arm * x[i] - Rl * Fx * s[i]) for i, q in enumerate(hub.GLOBAL_WRENCH[3:])]
for i in range(3):
    line("ISO 8855", hub.WRENCH[i], dot(columns[i], F))
    line("ISO 8855", hub.WRENCH[3 + i], dot(columns[i], M))
# fmt: on

#: The functions, in the order in which they are printed.
FUNCTIONS = (
    LineFunction(
        "wheel_motion",
        "Motion of the wheel at its contact point from the motion of the carrier and the road.",
        eq,
        names((*hub.CARRIER, *hub.ROAD, hub.SPIN)),
        names((*hub.MOTION, hub.LOADED_RADIUS, hub.RADIUS_RATE, *hub.CONTACT_POINT)),
    ),
    LineFunction(
        "hub_wrench",
        "Forces and moments at the wheel centre from those at the contact point.",
        eq,
        names((*hub.ROTATION, *hub.NORMAL, hub.LOADED_RADIUS, *hub.CONTACT_FORCES)),
        names((*hub.WRENCH, *hub.GLOBAL_WRENCH)),
    ),
)
