"""The two-track vehicle: slip angles and loads of its wheels, forces at its axles, and what a sensor measures.

The body moves in the plane. Loads follow from the accelerations, behind which roll and pitch lag: the longitudinal
transfer from the height of the center of gravity, the lateral one divided between the axles by their roll stiffness.
Both axles have more load while cornering accelerates the body up, and from downforce.
Both wheels of an axle have one angle; roll and compliance turn and incline them. After Schramm, Hiller, Bardini,
Vehicle Dynamics (2018), chapters 10 and 11; the balance at the axles is the balance of lateral force and yaw moment,
solved for the two axle forces.

The lines are functions of real numbers; `tirefmu.symbolic.printers.line_functions` prints them.
"""

from __future__ import annotations

from sympy import Expr, Float, Symbol, atan, cos, sin

from ..line_function import LineFunction, names
from ..notation import Chapter
from . import quantities as car

#: m/s^2, standard gravity.
GRAVITY = 9.80665
BODY, WHEELS, SENSOR = "Newton, Euler", "ISO 8855", "rigid body"

eq = Chapter("Two-track vehicle")


def line(number: str, name: str, expression: Expr, unit: str = "N", description: str = "") -> Symbol:
    """File a line and return its symbol."""
    return eq(number, name, expression, unit, description)


vx, vy, r = (quantity.symbol for quantity in car.MOTION)
vx_dot, vy_dot, r_dot = (quantity.symbol for quantity in car.RATES)
m, Iz, lf, lr, wf, wr, h, roll_front, drag, down_f, down_r = (quantity.symbol for quantity in car.CAR)
sx, sy, roll_gradient, misalignment = (quantity.symbol for quantity in car.SENSOR)
delta = dict(zip("fr", (quantity.symbol for quantity in car.TURNED), strict=True))
ax_lag, ay_lag = (quantity.symbol for quantity in car.LAG)
(az,) = (quantity.symbol for quantity in car.HEAVE)
steer_f, steer_r, camber = (quantity.symbol for quantity in car.SUSPENSION)
steer, g = car.STEER.symbol, Float(GRAVITY)
Fx = dict(zip(car.CORNERS, (quantity.symbol for quantity in car.FORCES[:4]), strict=True))
Fy = dict(zip(car.CORNERS, (quantity.symbol for quantity in car.FORCES[4:]), strict=True))
position = {"fl": (lf, wf / 2), "fr": (lf, -wf / 2), "rl": (-lr, wr / 2), "rr": (-lr, -wr / 2)}

# fmt: off
ax = line(BODY, "a_x", vx_dot - r*vy, "m/s^2", "longitudinal acceleration of the center of gravity")
ay = line(BODY, "a_y", vy_dot + r*vx, "m/s^2", "lateral acceleration of the center of gravity")

# Angles of the wheels.
rolled = line(BODY, "a_y_rolled", ay + ay_lag, "m/s^2", "lateral acceleration that rolls the body")
line(WHEELS, "delta_f", steer - steer_f*rolled, "rad", "angle of the front wheels")
line(WHEELS, "delta_r", steer_r*rolled, "rad", "angle of the rear wheels")
line(WHEELS, "gamma", camber*rolled, "rad", "inclination angle")

# Slip angles and loads of the wheels.
weight   = m*(g + az)
steady   = {"f": weight*lr / (lf + lr) / 2 + down_f*vx**2 / 2, "r": weight*lf / (lf + lr) / 2 + down_r*vx**2 / 2}
pitched  = line(BODY, "a_x_pitched", ax + ax_lag, "m/s^2", "longitudinal acceleration that pitches the body")
pitching = line(WHEELS, "pitch_transfer", m*pitched*h / (lf + lr) / 2, "N", "load of acceleration, to a rear wheel")
front    = line(WHEELS, "roll_transfer_front", m*rolled*h*roll_front / wf, "N", "load that a left turn moves right")
rear     = line(WHEELS, "roll_transfer_rear", m*rolled*h*(1 - roll_front) / wr, "N", "the same at the rear axle")
rolling  = {"f": front, "r": rear}
forward: dict[str, Symbol] = {}
across: dict[str, Symbol] = {}
for corner, (x, y) in position.items():
    axle, side = corner[0], corner[1]
    turned = delta[axle]
    along = line(WHEELS, f"u_{corner}", vx - r*y, "m/s", "forward speed of the wheel center, vehicle axes")
    left  = line(WHEELS, f"v_{corner}", vy + r*x, "m/s", "lateral speed of the wheel center, vehicle axes")
    V = line(WHEELS, f"V_{corner}", along*cos(turned) + left*sin(turned), "m/s", "forward speed in the wheel plane")
    line(WHEELS, f"alpha_{corner}", atan(left / along) - turned, "rad", "slip angle")
    line(WHEELS, f"Fz_{corner}", steady[axle] + (pitching if axle == "r" else -pitching)
         + (-rolling[axle] if side == "l" else rolling[axle]), "N", "load")
    forward[corner] = line(BODY, f"X_{corner}", Fx[corner]*cos(turned) - Fy[corner]*sin(turned), "N", "vehicle x axis")
    across[corner]  = line(BODY, f"Y_{corner}", Fx[corner]*sin(turned) + Fy[corner]*cos(turned), "N", "vehicle y axis")

# Forces at the axles.
Xf = line(BODY, "F_x_front", forward["fl"] + forward["fr"])
Xr = line(BODY, "F_x_rear",  forward["rl"] + forward["rr"])
Yf = line(BODY, "F_y_front", across["fl"] + across["fr"])
Yr = line(BODY, "F_y_rear",  across["rl"] + across["rr"])
turning = line(BODY, "M_x_forces", (forward["fr"] - forward["fl"])*wf/2 + (forward["rr"] - forward["rl"])*wr/2,
               "N m", "yaw moment of the longitudinal forces")
beyond_y = line(BODY, "e_y", m*ay - Yf - Yr, "N", "side force that the motion requires beyond the tires'")
beyond_n = line(BODY, "e_n", Iz*r_dot - lf*Yf + lr*Yr - turning, "N m", "required beyond the tires'")
line(BODY, "e_x",     m*ax - Xf - Xr + drag*vx**2)
line(BODY, "e_front", (lr*beyond_y + beyond_n) / (lf + lr))
line(BODY, "e_rear",  (lf*beyond_y - beyond_n) / (lf + lr))

# What a sensor measures.
roll = line(SENSOR, "roll", roll_gradient*rolled, "rad", "roll angle of the body")
along = line(SENSOR, "a_x_there", ax - r_dot*sy - r**2*sx, "m/s^2", "longitudinal acceleration at the sensor")
left  = line(SENSOR, "a_y_there", ay + r_dot*sx - r**2*sy + g*roll, "m/s^2", "lateral acceleration, with gravity")
line(SENSOR, "sensor_a_x", along + misalignment*left, "m/s^2", "longitudinal acceleration that the sensor measures")
line(SENSOR, "sensor_a_y", left - misalignment*along, "m/s^2", "lateral acceleration that the sensor measures")
line(SENSOR, "sensor_v_x", vx - r*sy, "m/s", "forward speed of the sensor")
line(SENSOR, "sensor_v_y", vy + r*sx, "m/s", "lateral speed of the sensor")

# What the forces cause.
eq(BODY, "v_x_dot", (Xf + Xr - drag*vx**2) / m + r*vy, "m/s^2", "rate of the forward speed")
eq(BODY, "v_y_dot", (Yf + Yr) / m - r*vx, "m/s^2", "rate of the lateral speed")
eq(BODY, "yaw_rate_dot", (lf*Yf - lr*Yr + turning) / Iz, "rad/s^2", "rate of the yaw rate")
# fmt: on

#: The functions, in the order in which they are printed.
FUNCTIONS = tuple(
    LineFunction(name, summary, eq, names(arguments), names(results))
    for name, summary, arguments, results in (
        ("turned", "Angles of the wheels from steering and lateral acceleration.",
         (*car.MOTION, *car.RATES, *car.LAG, car.STEER, *car.SUSPENSION), car.TURNING),
        ("wheels", "Slip angles, forward speeds and loads of the wheels from the motion.",
         (*car.MOTION, *car.RATES, *car.LAG, *car.HEAVE, *car.TURNED, *car.CAR), car.WHEELS),
        ("balance", "Forces at the axles, and what the motion requires beyond them.",
         (*car.MOTION, *car.RATES, *car.TURNED, *car.CAR, *car.FORCES), car.BALANCE),
        ("accelerations", "Rates of the motion that the forces of the tires cause.",
         (*car.MOTION, *car.TURNED, *car.CAR, *car.FORCES), car.ACCELERATIONS),
        ("sensor", "What a sensor in the vehicle measures.", (*car.MOTION, *car.RATES, *car.LAG, *car.SENSOR),
         car.READINGS),
    )
)  # fmt: skip
