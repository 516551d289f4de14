"""The effective rolling radius of a wheel at a given speed, in C: an FMU with wheel inputs computes kappa from it."""

from __future__ import annotations

from ..model import Model
from .c import PRINTER
from .definitions import calling_math, comment, definitions
from .operations import rolling_radius_lines
from .python import origin


def c_rolling_radius(model: Model) -> str:
    """Return a header with the rolling radius of a wheel at a given angular speed.

    Returns: the free radius for a model without an effective rolling radius.

    >>> from tirefmu.symbolic.models import model_named
    >>> print(c_rolling_radius(model_named("mf96")).splitlines()[-2].strip())
    return UNLOADED_RADIUS;
    """
    prefix = model.name.upper()
    needed = rolling_radius_lines(model)
    turning = model.quantity("wheel_speed") or "omega"
    read = {symbol.name for line in needed for symbol in line.expression.free_symbols} or {"UNLOADED_RADIUS"}
    lines = [f"const double {name} = parameters[{prefix}_{name}];" for name in model.parameters if name in read]
    lines += [f"const double {q.name} = inputs[{prefix}_{q.name}];" for q in model.inputs if q.name in read]
    lines += [f"const double {line.symbol} = {PRINTER.doprint(line.expression)};" for line in needed]
    lines += [] if needed else ["(void) inputs;", f"(void) {turning};"]
    lines += [f"return {model.quantity('rolling_radius') if needed else 'UNLOADED_RADIUS'};"]
    body = calling_math("\n".join(f"    {line}" for line in lines))
    remark = comment(
        "The effective rolling radius by load, pressure and angular speed, from the model's equations.",
        origin(model),
    )
    head = f"static double rolling_radius(const double inputs[], double {turning}, const double parameters[])"
    parts = [remark, definitions(body), f"{head}\n{{\n{body}\n}}"]
    return "\n\n".join(part for part in parts if part) + "\n"
