"""The generated C headers for a model and its variables, and for the values of a tire."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import inf, isfinite

from ...boundary.escaping import c_string
from ...symbolic.added.state import SPEED, couplings
from ...symbolic.model import Model
from ...symbolic.printers.definitions import comment
from ...symbolic.wheel.quantities import CONTACT_FORCES, SPIN
from ...tires.input_check import possible_range
from ...tires.states import simulation as states
from ..description.arrays import arrays
from ..description.interface import Interface, host_input_indices
from ..description.variables import Variable, declared_limits, read_inputs

#: Roles of the quantities that the wrapper reads.
ROLES = (
    "friction_x", "friction_y", "stiffness_x", "stiffness_y", "relaxation_x", "relaxation_y", "turning_torque", "trail",
    "loaded_radius",
)  # fmt: skip
#: Outputs that a mirror across the direction of travel reverses.
MIRRORED_ACROSS = frozenset({"Fx", "My", "Mz"})
#: Parameters that the wrapper reads: with inputs of a wheel, and with those of a hub.
STANDSTILL = ("LOW_SPEED", "LOW_SPEED_DAMPING", "DEFAULT_SIGMA", "FRICTION_LIMIT")
VERTICAL = (
    "FNOMIN",
    "UNLOADED_RADIUS",
    "VERTICAL_STIFFNESS",
    "VERTICAL_DAMPING",
    "BOTTOM_STIFF",
    "BOTTOM_RADIUS",
    "WHEEL_INERTIA",
)


def tire_values(shown: Interface, token: str) -> str:
    """Return the header with the values of the tire, for a binary that is compiled for it.

    `token`: as in the model description.

    >>> from tirefmu.tires import published
    >>> from ..description.interface import interface
    >>> print(tire_values(interface(published("trento_hoosier")), "{1}").splitlines()[1])
    #define INSTANTIATION_TOKEN "{1}"
    """
    listed = shown.variables
    tables = {
        "START_VALUES": [repr(float(variable.start or 0.0)) for variable in listed],
        "INPUT_RANGES": [f"{{{_limit(low)}, {_limit(high)}}}" for low, high in input_ranges(shown)],
    }
    lines = [
        comment("Written by tirefmu for one tire."),
        f"#define INSTANTIATION_TOKEN {c_string(token)}",
        f"#define RELAXATION_NOTE {c_string(shown.relaxation_note)}",
        *(line for name, entries in tables.items() for line in table(name, entries)),
    ]
    return "\n".join(lines) + "\n"


def input_ranges(shown: Interface) -> list[tuple[float, float]]:
    """Return the valid range of each input of the model.

    Where the tire has none: of slips that the host sets, what is possible in SI units and in the FMU's signs; infinite
    for other kinds of inputs, whose slips are not limited near standstill.
    """
    ranges = {name: possible_range(shown.tire, name) for name in shown.tire.inputs if shown.inputs == "slip"}
    ranges |= shown.tire.ranges
    return [ranges.get(name, (-inf, inf)) for name in shown.tire.inputs]


def model_config(shown: Interface) -> str:
    """Return the header that configures the wrapper for a model and its variables; equal for most tires of a model.

    >>> from tirefmu.tires import published
    >>> from ..description.interface import interface
    >>> print(model_config(interface(published("trento_hoosier"))).splitlines()[6])
    #define N_INPUTS MF96_N_INPUTS
    """
    listed, model, coefficients = shown.variables, shown.tire.model, shown.tire.symbolic_model.coefficients

    def limits_of(variable: Variable) -> tuple[float, float]:
        declared = coefficients.get(variable.name)
        return declared_limits(declared, shown.tire.signs) if declared else (variable.lower, variable.upper)

    tables = {
        "VALUE_NAMES": [c_string(variable.name) for variable in listed],
        "VALUE_KINDS": [_kind(variable) for variable in listed],
        "VALUE_DIRECTIONS": ["-1" if variable.reversed else "1" for variable in listed],
        "VALUE_LIMITS": [f"{{{_limit(low)}, {_limit(high)}}}" for low, high in map(limits_of, listed)],
        "NOMINAL_VALUES": [repr(float(variable.nominal)) for variable in listed],
    }
    lines = [
        comment("Written by tirefmu for a model and its variables."),
        "#include <math.h>",
        "",
        f'#include "{model}.h"',
        f'#include "{model}_operations.h"',
        "",
        *_sizes(shown),
        *_indices(shown),
        "",
        comment("By input of the model, by output."),
        *_inputs(shown),
        *table("BACKWARD_SIGNS", _backward_signs(shown.tire.symbolic_model)),
        "",
        comment("By value reference."),
        *(line for name, entries in tables.items() for line in table(name, entries)),
        "",
        comment("By extra output, by state."),
        *table("EXTRAS", [_extra(variable, model) for variable in shown.group("extra")]),
        *(table("MEMORY_TABLE", _memory(shown)) if shown.memory else ()),
        *_temperatures(shown),
        *_arrays(shown),
        *table("STATE_NOMINALS", [repr(float(nominal)) for nominal in shown.state_nominals] or ["0.0"]),
    ]
    return "\n".join(lines) + "\n"


def _arrays(shown: Interface) -> Iterable[str]:
    """Yield the number of arrays, and first value reference and size of each."""
    entries = [f"{{{array.first}, {array.size}}}" for array in arrays(shown.variables)]
    yield f"#define N_ARRAYS {len(entries)}"
    yield from table("ARRAYS", entries or ["{0, 0}"])


def _sizes(shown: Interface) -> Iterable[str]:
    """Yield the number of values of each kind, and the names in the generated code."""
    model = shown.tire.model
    prefix = model.upper()
    yield f"#define N_INPUTS {prefix}_N_INPUTS"
    yield f"#define N_OUTPUTS {prefix}_N_FORCES"
    yield f"#define N_PARAMETERS {prefix}_N_PARAMETERS"
    yield f"#define N_COEFFICIENTS {prefix}_N_COEFFICIENTS"
    yield f"#define N_QUANTITIES {prefix}_N_QUANTITIES"
    yield f"#define N_HOST_INPUTS {len(shown.contact_inputs)}"
    yield f"#define N_COMPUTED_INPUTS {len(shown.group('motion'))}"
    yield f"#define N_HOST_PARAMETERS {len(shown.group('parameter'))}"
    yield f"#define N_STATES {len(shown.group('state'))}"
    yield f"#define N_EXTRAS {len(shown.group('extra'))}"
    paths = [state for state in shown.memory if state.follows_a_path]
    yield f"#define N_MEMORY {len(shown.memory)}"
    yield f"#define N_INDICATORS {len(paths) + shown.spins}"
    yield f"#define N_STATE_LINES {len(shown.tire.symbolic_model.state_lines)}"
    for name in ("FIRST_STEP", "GROWTH", "MAX_ITERATIONS", "ACCEPTED", "MAX_HALVINGS"):
        yield f"#define {name} {getattr(states, name)!r}"
    relaxes = shown.lags and bool(shown.tire.symbolic_model.relaxing_effects)
    yield f"#define LAGS {int(shown.lags)}"
    yield f"#define RELAXES {int(relaxes)}"
    yield f"#define TWISTS {int(shown.twists)}"
    yield f"#define WHEEL {int(shown.wheel)}"
    yield f"#define HUB {int(shown.hub)}"
    yield f"#define SPIN {int(shown.spins)}"
    yield f"#define REVERSES {int(shown.tire.symbolic_model.motion.reverses)}"
    names = [v.name for v in shown.contact_inputs]
    yield f"#define SPIN_PLACE {names.index(SPIN.name) if shown.spins else 0}"
    optional = [name for name, used in (("relaxation", relaxes), ("state_lines", shown.memory)) if used]
    for routine in ["forces", "quantities", *optional]:
        yield f"#define model_{routine} {model}_{routine}"
    for table in ("CONSTANTS", "OPERATIONS"):
        yield f"#define N_{table} {prefix}_N_{table}"
        yield f"#define {table} {prefix}_{table}"
    for name in ("N_LEAVES", "N_SLOTS", "FORCE_SLOTS", "QUANTITY_SLOTS", "ROLLING_RADIUS"):
        yield f"#define {name} {prefix}_{name}"


def _indices(shown: Interface) -> Iterable[str]:
    """Yield the indices of values that the wrapper uses by name."""
    tire, prefix = shown.tire, shown.tire.model.upper()
    indices = {"KAPPA": "kappa", "ALPHA": "alpha", "LOAD": "Fz", "SPEED": "V"}
    indices |= {"LONGITUDINAL_FORCE": "Fx", "SIDE_FORCE": "Fy", "ALIGNING_MOMENT": "Mz", "OVERTURNING_MOMENT": "Mx"}
    indices |= {"INCLINATION": "gamma"}
    indices |= {"DISTANCE": "distance"} if shown.has_distance else {}
    for name, value in indices.items():
        if value in (*tire.inputs, *tire.outputs):
            yield f"#define {name} {prefix}_{value}"
    for role in ROLES:
        if tire.symbolic_model.quantity(role):
            yield f"#define {role.upper()} {prefix}_{tire.symbolic_model.quantity(role)}"
    yield f"#define SIDE_FORCE_SENSE {-1.0 if tire.signs == 'iso' else 1.0}"
    inputs = [variable.name for variable in shown.contact_inputs]
    if shown.wheel and "phit" in read_inputs(tire):
        yield f"#define TURN {prefix}_phit"
    hosts = {"HOST_SPEED": ("V", "V_x"), "HOST_SIDEWAYS": ("V_y",), "HOST_YAWING": ("psi_dot",)}
    hosts["HOST_TURNING"] = ("wheel_speed",) if shown.hub else ("omega",)
    hosts |= {"HOST_LOAD": ("Fz",), "HOST_FRICTION": ("road_mu",), "HOST_SPIN": ("omega",)} if shown.hub else {}
    hosts |= {"HOST_DRIVE": ("T_drive",), "HOST_BRAKE": ("T_brake",)} if shown.spins else {}
    for macro, names in hosts.items():
        for name in set(names) & set(inputs):
            yield f"#define {macro} {inputs.index(name)}"
    parameters = [variable.name for variable in shown.group("parameter")]
    for name in STANDSTILL if shown.wheel else ():
        yield f"#define {name} {parameters.index(name)}"
    for name in [name for name in VERTICAL if name in parameters and shown.hub]:
        yield f"#define OWN_{name} {parameters.index(name)}"
    if shown.hub:
        forces = [q.name for q in CONTACT_FORCES]
        yield from table("CONTACT_FORCES", [str(forces.index(name)) for name in tire.outputs])
        scales = [f"{prefix}_{name}" for name in tire.symbolic_model.motion.friction_scales]
        yield from table("FRICTION_PARAMETERS", [*scales, "-1"])
        if not scales:
            yield "#define HOST_FRICTION 0"  # not read


def _backward_signs(model: Model) -> list[str]:
    """Return the sign of each output of a wheel that rolls backward, relative to one that rolls forward."""
    return ["-1" if q.name in MIRRORED_ACROSS and not model.motion.reverses else "1" for q in model.outputs]


def _memory(shown: Interface) -> list[str]:
    """Return the entries of the table of the states of effects, as declared in effect_states.c."""
    model, names = shown.tire.symbolic_model, [state.name for state in shown.memory]
    prefix, laws = model.name.upper(), {
        "accumulation": "SUM", "hysteresis": "PATH", "play": "PLAY", "oscillator": "POSITION", SPEED: "VELOCITY",
        "temperature": "NODE",
    }  # fmt: skip
    entries = []
    for state in shown.memory:
        own_start = str(int(state.has_start_value))
        lags = [str(names.index(name)) for name in state.drive] if state.follows_a_path else []
        velocity, _, _, derivative = state.line_names
        fields = [
            f"{prefix}_{state.name}", str(model.state_lines.index(velocity)), laws.get(state.kind, "BALANCE"),
            str(int(model.is_direct(state))), own_start, f"{{{', '.join([*lags, '-1', '-1'][:2])}}}",
            f"{prefix}_{derivative}", f"{prefix}_{state.event_line or velocity}",
        ]  # fmt: skip
        entries.append(f"{{{', '.join(fields)}}}")
    return entries


def _temperatures(shown: Interface) -> Iterable[str]:
    """Yield the number of temperatures, their indices among the states, and the lines of their exchange of heat."""
    names, lines_of_states = [state.name for state in shown.memory], shown.tire.symbolic_model.state_lines
    nodes = [state.name for state in shown.memory if state.is_temperature]
    yield f"#define N_TEMPERATURES {len(nodes)}"
    if nodes:
        lines = {(a, b): str(lines_of_states.index(line)) for line, a, b in couplings(shown.memory)}
        yield from table("TEMPERATURES", [str(names.index(name)) for name in nodes])
        yield from table("EXCHANGE", [f"{{{', '.join(lines.get((a, b), '-1') for b in nodes)}}}" for a in nodes])


def _inputs(shown: Interface) -> Iterable[str]:
    """Yield the tables of the model's inputs: indices of the host's inputs, and values of unconnected ones.

    A value that is not read is 0: with nominal values the header would be specific to this tire.
    """
    tire, indices = shown.tire, host_input_indices(shown)
    computed = {name for _, name in tire.symbolic_model.on_demand} | ({"kappa", "alpha", "V"} if shown.wheel else set())
    unconnected = [
        tire.nominal(name) if index < 0 and name not in computed else 0.0
        for name, index in zip(tire.inputs, indices, strict=True)
    ]
    yield from table("MODEL_INPUT_NAMES", [c_string(name) for name in tire.inputs])
    yield from table("HOST_INPUT_INDICES", [str(index) for index in indices])
    yield from table("UNCONNECTED_INPUTS", [repr(float(value)) for value in unconnected])


def _limit(value: float) -> str:
    return repr(float(value)) if isfinite(value) else "-HUGE_VAL" if value < 0 else "HUGE_VAL"


def _kind(variable: Variable) -> str:
    """Return the kind of a variable, as named in the C code."""
    stored = variable.causality in ("local", "output") and variable.start is not None
    return "STORED" if stored else variable.causality.upper()


def _extra(variable: Variable, model: str) -> str:
    """Return the source of an extra output, as named in the C code."""
    kind, _, name = variable.source.partition(" + ")
    if kind in ("FIRST_PATH", "FIRST_HUB"):
        return variable.source
    return f"{kind} + {model.upper()}_{name}" if name else kind


def table(name: str, entries: Sequence[str]) -> Iterable[str]:
    """Yield the lines of a macro that initializes an array, eight entries in each."""
    yield f"#define {name} {{ \\"
    for i in range(0, len(entries), 8):
        yield f"    {', '.join(entries[i : i + 8])}, \\"
    yield "}"
