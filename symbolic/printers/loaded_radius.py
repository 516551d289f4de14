"""The loaded radius from the forces under a load, in C: an FMU with hub inputs finds the load from it."""

from __future__ import annotations

from ..model import Model
from ..model.lines import reaching
from ..notation import Equation
from .c import PRINTER
from .definitions import calling_functions, comment, definitions
from .python import origin


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
    """Return a header with the loaded radius under a load; its macro says whether the radius depends on the forces.

    Returns: without the function if the model has no loaded radius.

    >>> from tirefmu.symbolic.models import model_named
    >>> print(c_loaded_radius(model_named("mf61")).splitlines()[4])
    #define RADIUS_READS_FORCES 1
    """
    prefix, needed = model.name.upper(), loaded_radius_lines(model)
    read = {symbol.name for line in needed for symbol in line.expression.free_symbols}
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
