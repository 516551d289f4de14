"""A tire as MATLAB functions, which Octave runs, too.

The functions take a structure of inputs, arrays of any equal shapes. They are those of the Trento report's library: one
for each channel, one for the coefficients, one for the slip stiffnesses, one for all forces and one for all named
quantities.
"""

from __future__ import annotations

from dataclasses import replace

import sympy as sp

from tirefmu.boundary.escaping import line_comment

from ..routines import Routine, chosen_routines
from .expressions import MatlabPrinter
from .layout import Layout, filled, wrapped
from .program import TOLERANCE, Program

LAYOUT = Layout(MatlabPrinter(), "{name} = {value};", "% {}", line_comment, continued=" ...")
#: The name of the coefficients in the functions: they are in most lines.
COEFFICIENTS = "c"

_FUNCTION = """\
function @results@ = @name@_@function@(@parameters@)
% @summary@
%
@help@
@head@
    arguments
@arguments@
    end

@statements@

@values@
end

function y = choose(condition, then, rest)
% Element by element: then where the condition holds, rest elsewhere.
    y = then + zeros(size(condition)) + zeros(size(rest));
    rest = rest + zeros(size(y));
    condition = condition & true(size(y));
    y(~condition) = rest(~condition);
end

function y = sgn1(x)
% Sign of x, 1 at 0.
    y = sign(x);
    y(x == 0) = 1;
end
"""

_INPUTS = """\
function inputs = @name@_inputs()
% Nominal inputs of the tire as a structure.
%
@head@
@body@
end
"""

_COEFFICIENTS = """\
function coefficients = @name@_coefficients(@path@)
% Coefficients of the tire as a structure.
%
@head@
@body@
end
"""

_READ_FILE = """\
    names = {@names@};
    [file, problem] = fopen(path, 'r');
    assert(file >= 0, '%s: %s', path, problem);
    pairs = textscan(file, '%s %f');
    fclose(file);
    coefficients = struct();
    for i = 1:numel(pairs{1})
        coefficients.(pairs{1}{i}) = pairs{2}(i);
    end
    for i = 1:numel(names)
        assert(isfield(coefficients, names{i}), 'no coefficient %s', names{i});
    end"""

_SELF_TEST = """\
function @name@_selftest()
% Compare the functions of this folder with the stored results of tirefmu in @check_file@.
%
% It prints the largest difference of each function, relative to the result or its typical size. A difference that
% exceeds the tolerance is an error, with which "matlab -batch @name@_selftest" and "octave-cli --eval @name@_selftest"
% end with exit code 1.
@head@
    [file, problem] = fopen('@check_file@', 'r');
    assert(file >= 0, '@check_file@: %s', problem);
    numbers = fscanf(file, '%f');
    fclose(file);
    n = numbers(1);
    sizes = numbers(2:1 + @n_results@)';
    rows = reshape(numbers(2 + @n_results@:end), [], n)';
    expected = rows(:, @n_inputs@ + 1:end);
    results = zeros(n, @n_results@);
@calls@
    differences = abs(results - expected)./max(repmat(sizes, n, 1), abs(expected));
    differences(isnan(differences)) = Inf;
    ok = n > 0;
@report@
    assert(ok, 'the functions differ from the stored results');
end
"""


def files(program: Program) -> dict[str, str]:
    """Return the functions, the self-test and their data: text by file name."""
    name = program.name
    printed = {f"{name}_{routine.name}.m": _function(program, routine) for routine in _printed(program)}
    printed[f"{name}_inputs.m"] = _inputs(program)
    if program.coefficients:
        printed[f"{name}_coefficients.m"] = _coefficients(program)
    return {**printed, f"{name}_selftest.m": _self_test(program), **program.data_files()}


def _printed(program: Program) -> list[Routine]:
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


def _function(program: Program, routine: Routine) -> str:
    name, struct = program.name, bool(program.coefficients)
    results = f"[{', '.join(routine.labels)}]" if routine.name == "forces" else "result"
    parameters = {"inputs": f"{name}_inputs()"}
    help_lines = [f"inputs: structure of scalars or arrays of one shape, see {name}_inputs."]
    if struct:
        parameters[COEFFICIENTS] = f"{name}_coefficients({_path(program)})"
        help_lines.append(f"{COEFFICIENTS}: structure of the coefficients, see {name}_coefficients.")
    call, layout = f"{name}_{routine.name}", _layout(program)
    help_lines.append(f"Usage: inputs = {name}_inputs(); inputs.alpha = 0.05; {results} = {call}(inputs);")
    help_lines.append(f"Octave has no arguments blocks: call {call}({', '.join(_arguments(program))}).")
    values = {
        "results": results,
        "name": name,
        "function": routine.name,
        "parameters": ", ".join(parameters),
        "summary": line_comment(routine.summary),
        "help": LAYOUT.head(help_lines),
        "head": LAYOUT.head(program.header),
        "arguments": LAYOUT.indented((f"{key} (1,1) struct = {value}" for key, value in parameters.items()), 2),
        "statements": layout.statements(routine),
        "values": LAYOUT.indented(_results(program, routine, layout)),
    }
    return filled(_FUNCTION, values)


def _layout(program: Program) -> Layout:
    """Return the layout in which inputs and coefficients are read from their structures."""
    members = {key: f"inputs.{key}" for key in program.input_names}
    members |= {key: f"{COEFFICIENTS}.{key}" for key in program.coefficients}
    return replace(LAYOUT, printer=MatlabPrinter(members))


def _arguments(program: Program) -> list[str]:
    """Return the arguments of a call, all of them, as Octave needs them."""
    return ["inputs", *([f"{program.name}_coefficients({_path(program)})"] if program.coefficients else [])]


def _results(program: Program, routine: Routine, layout: Layout) -> list[str]:
    """Return the statements that assign the results; a result without inputs takes the shape of the inputs."""
    shape = LAYOUT.lines(f"shape = zeros(size({' + '.join(f'inputs.{name}' for name in program.input_names)}));")
    if routine.name == "forces":
        return [*shape, *(f"{label} = {label} + shape;" for label in routine.labels)]
    if routine.name in ("quantities", "states"):
        return [*shape, "result = struct();", *(f"result.{label} = {label} + shape;" for label in routine.labels)]
    if len(routine.results) == 1 and len(routine.results[0]) == 1 and routine.name == routine.labels[0]:
        return [*shape, *layout.lines(f"result = {layout.values(routine)[0]} + shape;")]
    rows = [str(quantity.name) for quantity in program.outputs]
    lines = [*shape, "% Derivative of a force by a column, such as result.Fy.alpha.", "result = struct();"]
    for row, values in zip(rows, routine.results, strict=True):
        for label, value in zip(routine.labels, values, strict=True):
            lines += layout.lines(f"result.{row}.{label} = {layout.printer.doprint(sp.sympify(value))} + shape;")
    return lines


def _inputs(program: Program) -> str:
    lines = [
        f"inputs.{q.name} = {program.nominal[q.name]!r};  {LAYOUT.remark(f'{q.description} [{q.unit}]')}"
        for q in program.inputs
    ]
    values = {"name": program.name, "head": LAYOUT.head(program.header), "body": LAYOUT.indented(lines)}
    return filled(_INPUTS, values)


def _coefficients(program: Program) -> str:
    if program.placement == "file":
        names = wrapped([f"'{key}'" for key in program.coefficients], 90)
        body = filled(_READ_FILE, {"names": " ...\n        ".join(line.strip() for line in names)})
    else:
        declared = program.model.coefficients
        lines = [
            f"coefficients.{key} = {value!r};  {LAYOUT.remark(f'{declared[key].description} [{declared[key].unit}]')}"
            for key, value in program.coefficients.items()
        ]
        body = LAYOUT.indented(["coefficients = struct();", *lines])
    values = {"name": program.name, "head": LAYOUT.head(program.header), "body": body}
    return filled(_COEFFICIENTS, values | {"path": "path" if program.placement == "file" else ""})


def _self_test(program: Program) -> str:
    name, inputs = program.name, program.input_names
    argument = ", ".join(_arguments(program))
    calls = [f"inputs.{key} = rows(:, {i});" for i, key in enumerate(inputs, 1)]
    report, start = [], 1
    outputs = [quantity.name for quantity in program.outputs]
    for routine, (function, size) in zip(program.routines, program.sizes(), strict=True):
        if function == "forces":
            calls.append(f"[{', '.join(outputs)}] = {name}_forces({argument});")
            calls += [f"results(:, {i}) = {label};" for i, label in enumerate(outputs, start)]
        else:
            keys = list(routine.labels)
            if function not in ("quantities", "states"):
                keys = [f"{output}.{label}" for output in outputs for label in routine.labels]
            calls.append(f"answer = {name}_{function}({argument});")
            calls += [f"results(:, {i}) = answer.{key};" for i, key in enumerate(keys, start)]
        report += [
            f"largest = max(max(differences(:, {start}:{start + size - 1})));",
            f"fprintf('{function} %.3g\\n', largest);",
            f"ok = ok && largest <= {TOLERANCE[function]!r};",
        ]
        start += size
    values = {
        "head": LAYOUT.head(program.header[:1]),
        "name": name,
        "check_file": program.check_file,
        "n_results": start - 1,
        "n_inputs": len(inputs),
        "calls": LAYOUT.indented(calls),
        "report": LAYOUT.indented(report),
    }
    return filled(_SELF_TEST, values)


def _path(program: Program) -> str:
    return f"'{program.values_file}'" if program.placement == "file" else ""
