"""A tire as MATLAB functions, which Octave runs, too.

The functions take arrays of any equal shapes. They are those of the Trento report's library: one for each channel, one
for the coefficients, one for the slip stiffnesses, one for all forces and one for all named quantities.
"""

from __future__ import annotations

from dataclasses import replace

import sympy as sp

from ...escaping import line_comment
from ..routines import Routine, chosen_routines
from .expressions import MatlabPrinter
from .layout import Layout, filled, wrapped
from .program import TOLERANCE, Program

LAYOUT = Layout(MatlabPrinter(), "{name} = {value};", "% {}", line_comment)

_FUNCTION = """\
function @results@ = @name@_@function@(@parameters@)
% @summary@
%
@help@
@head@
@defaults@@read@
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
% Compare the functions of this folder with the stored results of tirefmu in @check_file@.
%
% Run it with "octave-cli @name@_selftest.m" or "matlab -batch @name@_selftest". It prints the largest difference of
% each function, relative to the result or its typical size. Exit code 1: a difference exceeds the tolerance.
@head@
try
    file = fopen('@check_file@', 'r');
    numbers = fscanf(file, '%f');
    fclose(file);
    n = numbers(1);
    sizes = numbers(2:1 + @n_results@)';
    rows = reshape(numbers(2 + @n_results@:end), [], n)';
@read_coefficients@    @arguments@ = deal(@columns@);
    expected = rows(:, @n_inputs@ + 1:end);
    results = zeros(n, @n_results@);
@calls@
    differences = abs(results - expected)./max(repmat(sizes, n, 1), abs(expected));
    differences(isnan(differences)) = Inf;
    ok = n > 0;
@report@
catch problem
    fprintf(2, '%s\\n', problem.message);
    ok = false;
end
exit(double(~ok));
"""


def files(program: Program) -> dict[str, str]:
    """Return the functions, the self-test and their data.

    Parameters
    ----------
    program : Program

    Returns
    -------
    dict of str to str
        Text by file name.
    """
    name = program.name
    printed = {f"{name}_{routine.name}.m": _function(program, routine) for routine in _printed(program)}
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
    help_lines = [f"{q.name}: {q.description} [{q.unit}]" for q in program.inputs]
    help_lines.append("An absent or empty input has its nominal value; all inputs are scalars or arrays of one shape.")
    if program.coefficients:
        help_lines.append(f"coefficients: structure, see {program.name}_coefficients.")
    parameters = [*program.input_names, *(["coefficients"] if program.coefficients else [])]
    results = f"[{', '.join(routine.labels)}]" if routine.name == "forces" else "result"
    help_lines.append(f"Usage: {results} = {program.name}_{routine.name}([], 0.05);")
    values = {
        "results": results,
        "name": program.name,
        "function": routine.name,
        "parameters": ", ".join(parameters),
        "summary": line_comment(routine.summary),
        "help": LAYOUT.head(help_lines),
        "head": LAYOUT.head(program.header),
        "defaults": "".join(_default(program, i, parameter) for i, parameter in enumerate(parameters, 1)),
        "read": LAYOUT.indented(f"{key} = coefficients.{key};" for key in routine.uses(list(program.coefficients))),
        "statements": LAYOUT.statements(routine),
        "values": LAYOUT.indented(_results(program, routine)),
    }
    return filled(_FUNCTION, values)


def _default(program: Program, position: int, parameter: str) -> str:
    value = f"{program.name}_coefficients()" if parameter == "coefficients" else repr(program.nominal.get(parameter))
    if parameter == "coefficients" and program.placement == "file":
        value = f"{program.name}_coefficients('{program.values_file}')"
    return f"    if nargin < {position} || isempty({parameter}), {parameter} = {value}; end\n"


def _results(program: Program, routine: Routine) -> list[str]:
    """Return the statements that assign the results; a result without inputs takes the shape of the inputs."""
    shape = f"shape = zeros(size({' + '.join(program.input_names)}));"
    if routine.name == "forces":
        return [shape, *(f"{label} = {label} + shape;" for label in routine.labels)]
    if routine.name in ("quantities", "states"):
        return [shape, "result = struct();", *(f"result.{label} = {label} + shape;" for label in routine.labels)]
    if len(routine.results) == 1 and len(routine.results[0]) == 1 and routine.name == routine.labels[0]:
        return [shape, f"result = {LAYOUT.values(routine)[0]} + shape;"]
    rows = [str(quantity.name) for quantity in program.outputs]
    lines = [shape, "% Derivative of a force by a column, such as result.Fy.alpha.", "result = struct();"]
    for row, values in zip(rows, routine.results, strict=True):
        for label, value in zip(routine.labels, values, strict=True):
            lines.append(f"result.{row}.{label} = {LAYOUT.printer.doprint(sp.sympify(value))} + shape;")
    return lines


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
    argument = ", ".join([*inputs, *(["coefficients"] if program.coefficients else [])])
    calls, report, start = [], [], 1
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
    load = f"    coefficients = {name}_coefficients({_path(program)});\n"
    values = {
        "head": LAYOUT.head(program.header[:1]),
        "name": name,
        "check_file": program.check_file,
        "n_results": start - 1,
        "n_inputs": len(inputs),
        "read_coefficients": load if program.coefficients else "",
        "arguments": f"[{', '.join(inputs)}]",
        "columns": ", ".join(f"rows(:, {i})" for i in range(1, len(inputs) + 1)),
        "calls": LAYOUT.indented(calls),
        "report": LAYOUT.indented(report),
    }
    return filled(_SELF_TEST, values)


def _path(program: Program) -> str:
    return f"'{program.values_file}'" if program.placement == "file" else ""
