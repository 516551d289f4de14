"""A tire as a JavaScript module (ES2020) with type declarations, for browsers and Node."""

from __future__ import annotations

from tirefmu.boundary.escaping import c_comment

from ..routines import Routine
from .expressions import JavaScriptPrinter
from .layout import Layout, filled
from .program import TOLERANCE, Program

LAYOUT = Layout(JavaScriptPrinter(), "const {name} = {value};", "// {}", c_comment, "  ")

_MODULE = """\
@head@
//
// Usage:
//   import { forces } from "./@name@.mjs";
//   const { Fy } = forces({ alpha: 0.05, Fz: 1000 }@argument@);
// Inputs that are not given have their nominal values.
// Self-test: node @name@_selftest.mjs

/** Operating conditions that are not given. */
export const NOMINAL = Object.freeze({
@nominal@
});
@coefficients@
const square = (x) => x * x;
const cube = (x) => x * x * x;
const fourth = (x) => x * x * (x * x);
const cubed_sqrt = (x) => x * Math.sqrt(x);
const sgn = Math.sign;
const sgn1 = (x) => (x >= 0 ? 1 : Math.sign(x));

@functions@
"""

_STRUCT = """
/** Coefficients of the tire. */
export const COEFFICIENTS = Object.freeze({
@values@
});
"""

_FILE = """
const NAMES = [
@names@
];

/** Return the coefficients in a text with lines "NAME value"; an Error if one is missing. */
export function parseCoefficients(text) {
  const found = Object.fromEntries(text.trim().split("\\n").map((line) => line.split(" ")));
  return Object.fromEntries(
    NAMES.map((name) => {
      if (!Number.isFinite(Number(found[name] ?? NaN))) throw new Error(`no coefficient ${name}`);
      return [name, Number(found[name])];
    }),
  );
}
"""

_SELF_TEST = """\
@head@
//
// Self-test: node @name@_selftest.mjs
// Compares @name@.mjs with the stored results of tirefmu in @check_file@ and prints the largest difference of each
// function, relative to the result or its typical size. Exit code 1: a difference exceeds the tolerance.
import { readFileSync } from "node:fs";
import * as tire from "./@name@.mjs";

const read = (file) => readFileSync(new URL(file, import.meta.url), "ascii");
const [[n], sizes, ...rows] = read("@check_file@").trim().split("\\n").map((line) => line.split(" ").map(Number));
const names = [@inputs@];
const functions = [@functions@];
const tolerances = [@tolerances@];
const largest = functions.map(() => 0);
@read_coefficients@
for (const row of rows) {
  const inputs = Object.fromEntries(names.map((name, i) => [name, row[i]]));
  const expected = row.slice(names.length);
  let k = 0;
  functions.forEach((name, f) => {
    for (const result of Object.values(tire[name](inputs@argument@)).flat()) {
      const difference = Math.abs(result - expected[k]) / Math.max(sizes[k], Math.abs(expected[k]));
      if (!(difference <= largest[f])) largest[f] = difference >= 0 ? difference : Infinity; // NaN stays the largest
      k += 1;
    }
  });
}
functions.forEach((name, f) => console.log(`${name} ${largest[f].toPrecision(3)}`));
process.exitCode = rows.length === n && n > 0 && largest.every((value, f) => value <= tolerances[f]) ? 0 : 1;
"""


def files(program: Program) -> dict[str, str]:
    """Return the module, its type declarations, its self-test and their data: text by file name."""
    name = program.name
    values = {
        "head": LAYOUT.head(program.header),
        "name": name,
        "argument": ", coefficients" if program.placement == "file" else "",
        "nominal": LAYOUT.indented(f"{key}: {value!r}," for key, value in program.nominal.items()),
        "coefficients": _coefficients(program),
        "functions": "\n\n".join(_function(program, routine) for routine in program.routines),
    }
    return {
        f"{name}.mjs": filled(_MODULE, values),
        f"{name}.d.mts": _declarations(program),
        f"{name}_selftest.mjs": _self_test(program),
        **program.data_files(),
    }


def _coefficients(program: Program) -> str:
    if not program.coefficients:
        return ""
    if program.placement == "file":
        return filled(_FILE, {"names": LAYOUT.indented(f'"{key}",' for key in program.coefficients)})
    declared = program.model.coefficients
    lines = [
        f"{key}: {value!r}, {LAYOUT.remark(f'{declared[key].description} [{declared[key].unit}]')}"
        for key, value in program.coefficients.items()
    ]
    return filled(_STRUCT, {"values": LAYOUT.indented(lines)})


def _parameters(program: Program) -> str:
    defaults = {"inline": "", "struct": ", coefficients = COEFFICIENTS", "file": ", coefficients"}
    return "inputs = {}" + (defaults[program.placement] if program.coefficients else "")


def _function(program: Program, routine: Routine) -> str:
    read = [f"const {key} = inputs.{key} ?? NOMINAL.{key};" for key in routine.uses(program.input_names)]
    used = routine.uses(list(program.coefficients))
    read += LAYOUT.lines(f"const {{ {', '.join(used)} }} = coefficients;") if used else []
    if routine.name.startswith("jacobian_"):
        result = f"return [\n{LAYOUT.indented(LAYOUT.rows(routine, '[{}],'), 2)}\n  ];"
    else:
        pairs = [f"{label}," for label in routine.labels]
        result = f"return {{\n{LAYOUT.indented(pairs, 2)}\n  }};"
    return (
        f"/** {c_comment(routine.summary)} */\nexport function {routine.name}({_parameters(program)}) {{\n"
        f"{LAYOUT.indented(read)}\n{LAYOUT.statements(routine)}\n  {result}\n}}"
    )


def _declarations(program: Program) -> str:
    """Return the type declarations for TypeScript."""
    units = {quantity.name: f"{quantity.description} [{quantity.unit}]" for quantity in program.outputs}
    units |= {str(line.symbol): f"{line.description} [{line.unit}]" for line in program.lines}
    members = [f"/** {c_comment(f'{q.description} [{q.unit}]')} */ {q.name}?: number;" for q in program.inputs]
    parts = [LAYOUT.head(program.header[:2]), f"export interface Inputs {{\n{LAYOUT.indented(members)}\n}}"]
    last = ""
    if program.coefficients:
        fields = LAYOUT.indented(f"{key}: number;" for key in program.coefficients)
        parts.append(f"export interface Coefficients {{\n{fields}\n}}")
        last = f", coefficients{'?' if program.placement == 'struct' else ''}: Coefficients"
        parts.append(
            "export function parseCoefficients(text: string): Coefficients;"
            if program.placement == "file"
            else "export const COEFFICIENTS: Readonly<Coefficients>;"
        )
    parts.append("export const NOMINAL: Readonly<Required<Inputs>>;")
    for routine in program.routines:
        result = "number[][]"
        if not routine.name.startswith("jacobian_"):
            result = routine.name.capitalize()
            fields = LAYOUT.indented(f"/** {c_comment(units[label])} */ {label}: number;" for label in routine.labels)
            parts.append(f"export interface {result} {{\n{fields}\n}}")
        parts.append(f"export function {routine.name}(inputs?: Inputs{last}): {result};")
    return "\n\n".join(parts) + "\n"


def _self_test(program: Program) -> str:
    load = f'const coefficients = tire.parseCoefficients(read("{program.values_file}"));\n'
    values = {
        "head": LAYOUT.head(program.header[:1]),
        "name": program.name,
        "check_file": program.check_file,
        "inputs": ", ".join(f'"{key}"' for key in program.input_names),
        "functions": ", ".join(f'"{function}"' for function, _ in program.sizes()),
        "tolerances": ", ".join(f"{TOLERANCE[function]!r}" for function, _ in program.sizes()),
        "read_coefficients": load if program.placement == "file" else "",
        "argument": ", coefficients" if program.placement == "file" else "",
    }
    return filled(_SELF_TEST, values)
