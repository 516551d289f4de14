"""The radii of a wheel in C: an FMU computes kappa from the effective rolling radius, its load from the loaded one."""

from __future__ import annotations

from ..model import Model
from ..model.lines import reaching
from ..notation import Equation
from .c import PRINTER
from .definitions import calling_functions, calling_math, comment, definitions
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
    read = {name for line in needed for name in line.reads} or {"UNLOADED_RADIUS"}
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


def loaded_radius_lines(model: Model) -> list[Equation]:
    """Return the lines of the loaded radius behind those of the forces, which are given.

    Returns: none if the model has no loaded radius.

    >>> from tirefmu.symbolic.models import model_named
    >>> loaded_radius_lines(model_named("brush"))
    []
    """
    outputs = {quantity.name for quantity in model.outputs}
    return reaching(
        [line for line in model.lines() if line.symbol.name not in outputs], [model.quantity("loaded_radius")]
    )


def c_loaded_radius(model: Model) -> str:
    """Return a header with the loaded radius under a load; its macro states whether the radius depends on the forces.

    Returns: without the function if the model has no loaded radius.

    >>> from tirefmu.symbolic.models import model_named
    >>> print(c_loaded_radius(model_named("mf61")).splitlines()[3])
    #define RADIUS_READS_FORCES 1
    """
    prefix, needed = model.name.upper(), loaded_radius_lines(model)
    read = {name for line in needed for name in line.reads}
    outputs = [q.name for q in model.outputs if q.name in read]
    sources = {
        "parameters": [name for name in model.parameters if name in read],
        "inputs": [q.name for q in model.inputs if q.name in read],
        "forces": outputs,
    }
    lines = [f"const double {name} = {kind}[{prefix}_{name}];" for kind, names in sources.items() for name in names]
    lines += [f"const double {line.symbol} = {PRINTER.doprint(line.expression)};" for line in needed]
    lines += [f"(void) {kind};" for kind, names in sources.items() if not names]
    lines += [f"return {model.quantity('loaded_radius')};"]
    body = calling_functions("\n".join(f"    {line}" for line in lines))
    remark = comment(
        "The loaded radius under a load, for the forces that act then, from the model's equations.", origin(model)
    )
    head = "static double loaded_radius(const double inputs[], const double forces[], const double parameters[])"
    function = f"{head}\n{{\n{body}\n}}"
    parts = [remark, f"#define RADIUS_READS_FORCES {int(bool(outputs))}"]
    parts += [definitions(body), function] if needed else []
    return "\n\n".join(part for part in parts if part) + "\n"
