"""A tire as MATLAB functions, which Octave runs, too.

The functions take a structure of inputs, arrays of any equal shapes. They are those of the Trento report's library: one
for each channel, one for the coefficients, one for the slip stiffnesses, one for all forces and one for all named
quantities.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import product

from ....boundary.escaping import line_comment
from ..routines import Routine, chosen_routines
from .expressions import MatlabPrinter
from .layout import Layout
from .program import PrintedProgram
from .rendering import function_of, render

LAYOUT = Layout(MatlabPrinter(), "{name} = {value};", "% {}", line_comment, continued=" ...")
#: The name of the coefficients in the functions: they are in most lines.
COEFFICIENTS = "c"


def files(program: PrintedProgram) -> dict[str, str]:
    """Return the functions, the self-test and their data: text by file name."""
    path = f"'{program.values_file}'" if program.placement == "file" else ""
    arguments = ["inputs", *([f"{program.name}_coefficients({path})"] if program.coefficients else [])]
    names = [f"'{key}'" for key in program.coefficients]
    templates = {"{}_inputs.m": "matlab_inputs.m", "{}_selftest.m": "matlab_selftest.m"}
    templates |= {"{}_coefficients.m": "matlab_coefficients.m"} if names else {}
    keys = {
        routine.name: [".".join(part) for part in product(_outputs(program), routine.labels)]
        if routine.name.startswith("jacobian_") else list(routine.labels)
        for routine in program.routines
    }  # fmt: skip
    functions = [_function(program, routine, arguments) for routine in _printed(program)]
    functions.append(render(program, LAYOUT, templates, argument=", ".join(arguments), names=names, keys=keys))
    return {name: text for files in functions for name, text in files.items()}


def _outputs(program: PrintedProgram) -> list[str]:
    return [quantity.name for quantity in program.outputs]


def _printed(program: PrintedProgram) -> list[Routine]:
    """Return the routines of the program; those of each force and of the slip stiffnesses are added to `forces`."""
    routines = list(program.routines)
    if not any(routine.name == "forces" for routine in routines):
        return routines
    outputs = [quantity.symbol for quantity in program.outputs]
    for output in outputs:
        (single,) = chosen_routines(program.lines, ["forces"], [output], [], [])
        routines.append(replace(single, name=str(output), summary=f"The channel {output} alone."))
    slips = [quantity.symbol for quantity in program.inputs[:2]]
    (stiffness,) = chosen_routines(program.lines, ["jacobian_inputs"], outputs, slips, [])
    return [*routines, replace(stiffness, name="stiffness", summary="Derivatives of the forces by kappa and alpha.")]


def _function(program: PrintedProgram, routine: Routine, arguments: list[str]) -> dict[str, str]:
    """Return the file of a function, which reads inputs and coefficients from their structures."""
    members = {key: f"inputs.{key}" for key in program.input_names}
    members |= {key: f"{COEFFICIENTS}.{key}" for key in program.coefficients}
    function = function_of(routine, program, replace(LAYOUT, printer=MatlabPrinter(members)))
    name, call = program.name, f"{program.name}_{routine.name}"
    results = f"[{', '.join(routine.labels)}]" if routine.name == "forces" else "result"
    help_lines = [f"inputs: structure of scalars or arrays of one shape, see {name}_inputs."]
    if program.coefficients:
        help_lines.append(f"{COEFFICIENTS}: structure of the coefficients, see {name}_coefficients.")
    help_lines.append(f"Usage: inputs = {name}_inputs(); inputs.alpha = 0.05; {results} = {call}(inputs);")
    help_lines.append(f"Octave has no arguments blocks: call {call}({', '.join(arguments)}).")
    values = zip(product(_outputs(program), routine.labels), function.values, strict=False)
    return render(
        program, LAYOUT, {f"{{}}_{routine.name}.m": "matlab_function.m"}, function=function, results_text=results,
        help=LAYOUT.head(help_lines), is_channel=routine.labels == (routine.name,),
        has_rows=routine.name not in ("quantities", "states"), entries=[(*pair, value) for pair, value in values],
        parameters=list(zip(("inputs", COEFFICIENTS), [f"{name}_inputs()", *arguments[1:]], strict=False)),
    )  # fmt: skip
