"""A tire as a Rust module without the standard library: functions of the crate libm, no allocation."""

from __future__ import annotations

from collections.abc import Mapping

from tirefmu.boundary.escaping import c_comment

from ..routines import Routine
from .expressions import RustPrinter
from .layout import Layout, filled
from .program import TOLERANCE, Program

LAYOUT = Layout(RustPrinter(), "let {name}: f64 = {value};", "// {}", c_comment)

_MODULE = """\
@head@
//
// Usage, with libm = "0.2" in Cargo.toml; nothing needs std:
//     mod @name@;
//     let inputs = @name@::Inputs { alpha: 0.05, ..Default::default() };   // other inputs are nominal
//     let forces = @name@::forces(&inputs@argument@);
// Self-test: @name@_selftest.rs
#![allow(non_snake_case, unused_parens, unused_variables, dead_code)]
#![allow(clippy::all)]

@structures@

fn square(x: f64) -> f64 { x*x }
fn cube(x: f64) -> f64 { x*x*x }
fn fourth(x: f64) -> f64 { (x*x)*(x*x) }
fn cubed_sqrt(x: f64) -> f64 { x*libm::sqrt(x) }
// NaN stays NaN.
fn sgn(x: f64) -> f64 { if x > 0.0 { 1.0 } else if x < 0.0 { -1.0 } else if x == 0.0 { 0.0 } else { x } }
fn sgn1(x: f64) -> f64 { if x >= 0.0 { 1.0 } else if x < 0.0 { -1.0 } else { x } }

@functions@
"""

_PARSE = """\
impl Coefficients {
    /// Coefficients in a text with lines "NAME value"; None if one is missing.
    pub fn parse(text: &str) -> Option<Self> {
        let value = |name: &str| -> Option<f64> {
            text.lines().find_map(|line| {
                let (key, number) = line.trim().split_once(' ')?;
                if key == name { number.trim().parse().ok() } else { None }
            })
        };
        Some(Self {
@members@
        })
    }
}"""

_SELF_TEST = """\
@head@
//
// Self-test: rustc -O @name@_selftest.rs --extern libm=liblibm.rlib && ./@name@_selftest
// Compares @name@.rs with the stored results of tirefmu in @check_file@ and prints the largest difference of each
// function, relative to the result or its typical size. Exit code 1: a difference exceeds the tolerance.
mod @name@;
use @name@ as tire;

fn main() {
    let text = std::fs::read_to_string("@check_file@").unwrap_or_default();
    let mut lines = text.lines().map(|line| {
        line.split_whitespace().map(|word| word.parse().unwrap_or(f64::NAN)).collect::<Vec<f64>>()
    });
    let n = lines.next().and_then(|line| line.first().copied()).unwrap_or(0.0);
    let sizes = lines.next().unwrap_or_default();
    let names = [@names@];
    let ends = [@ends@];
    let tolerances = [@tolerances@];
    let mut largest = [0.0_f64; @n_functions@];
    let mut rows = 0.0;
@coefficients@    for row in lines {
@inputs@
        let mut results: Vec<f64> = Vec::new();
@calls@
        for (k, result) in results.iter().enumerate() {
            let expected = row[@n_inputs@ + k];
            let difference = (result - expected).abs()/sizes[k].max(expected.abs());
            let function = ends.iter().position(|end| k < *end).unwrap_or(0);
            if !(difference <= largest[function]) {
                // NaN stays the largest.
                largest[function] = if difference >= 0.0 { difference } else { f64::INFINITY };
            }
        }
        rows += 1.0;
    }
    let mut ok = n > 0.0 && rows == n;
    for i in 0..names.len() {
        println!("{} {:.2e}", names[i], largest[i]);
        ok = ok && largest[i] <= tolerances[i];
    }
    std::process::exit(if ok { 0 } else { 1 });
}
"""


def files(program: Program) -> dict[str, str]:
    """Return the module, its self-test and their data: text by file name."""
    given = {"inline": "", "struct": ", &Default::default()", "file": ", &coefficients"}
    values = {
        "head": LAYOUT.head(program.header),
        "name": program.name,
        "argument": given[program.placement] if program.coefficients else "",
        "structures": "\n\n".join(_structures(program)),
        "functions": "\n\n".join(_function(program, routine) for routine in program.routines),
    }
    return {
        f"{program.name}.rs": filled(_MODULE, values),
        f"{program.name}_selftest.rs": _self_test(program),
        **program.data_files(),
    }


def _structures(program: Program) -> list[str]:
    inputs = {q.name: f"{q.description} [{q.unit}]" for q in program.inputs}
    parts = [_structure("Inputs", "Operating conditions.", inputs), _default("Inputs", program.nominal)]
    if program.coefficients:
        declared = program.model.coefficients
        members = {key: f"{declared[key].description} [{declared[key].unit}]" for key in program.coefficients}
        parts.append(_structure("Coefficients", "Coefficients.", members))
        if program.placement == "struct":
            parts.append(_default("Coefficients", program.coefficients))
        else:
            lines = LAYOUT.indented((f'{key}: value("{key}")?,' for key in program.coefficients), 3)
            parts.append(filled(_PARSE, {"members": lines}))
    units = {quantity.name: f"{quantity.description} [{quantity.unit}]" for quantity in program.outputs}
    units |= {str(line.symbol): f"{line.description} [{line.unit}]" for line in program.lines}
    for routine in program.routines:
        if not routine.name.startswith("jacobian_"):
            members = {label: units[label] for label in routine.labels}
            parts.append(_structure(routine.name.capitalize(), routine.summary, members))
    return parts


def _structure(name: str, meaning: str, members: Mapping[str, str]) -> str:
    body = LAYOUT.indented(f"pub {member}: f64, {LAYOUT.remark(text)}" for member, text in members.items())
    return f"{LAYOUT.remark(meaning)}\n#[derive(Clone, Copy, Debug)]\npub struct {name} {{\n{body}\n}}"


def _default(name: str, values: Mapping[str, float]) -> str:
    members = LAYOUT.indented((f"{key}: {value!r}," for key, value in values.items()), 3)
    return (
        f"impl Default for {name} {{\n    fn default() -> Self {{\n        Self {{\n{members}\n        }}\n    }}\n}}"
    )


def _function(program: Program, routine: Routine) -> str:
    parameters = "inputs: &Inputs" + (", coefficients: &Coefficients" if program.coefficients else "")
    used = routine.uses(list(program.coefficients))
    read = [f"let {key} = inputs.{key};" for key in routine.uses(program.input_names)]
    read += [f"let {key} = coefficients.{key};" for key in used]
    if routine.name.startswith("jacobian_"):
        kind = f"[[f64; {len(routine.results[0])}]; {len(routine.results)}]"
        result = f"[\n{LAYOUT.indented(LAYOUT.rows(routine, '[{}],'), 2)}\n    ]"
    else:
        kind = routine.name.capitalize()
        result = "\n    ".join(LAYOUT.lines(f"{kind} {{ {', '.join(routine.labels)} }}"))
    return (
        f"{LAYOUT.remark(routine.summary)}\npub fn {routine.name}({parameters}) -> {kind} {{\n"
        f"{LAYOUT.indented(read)}\n{LAYOUT.statements(routine)}\n    {result}\n}}"
    )


def _self_test(program: Program) -> str:
    argument = ", &coefficients" if program.coefficients else ""
    calls: list[str] = []
    ends: list[int] = []
    for routine, (function, size) in zip(program.routines, program.sizes(), strict=True):
        ends.append(size + (ends[-1] if ends else 0))
        calls.append(f"let {function} = tire::{function}(&inputs{argument});")
        if function.startswith("jacobian_"):
            calls.append(f"{function}.iter().for_each(|row| results.extend_from_slice(row));")
        else:
            members = ", ".join(f"{function}.{label}" for label in routine.labels)
            calls += LAYOUT.lines(f"results.extend_from_slice(&[{members}]);")
    load = "    let coefficients = tire::Coefficients::default();\n"
    if program.placement == "file":
        load = (
            f'    let values = std::fs::read_to_string("{program.values_file}").unwrap_or_default();\n'
            "    let Some(coefficients) = tire::Coefficients::parse(&values) else { std::process::exit(1) };\n"
        )
    members = ", ".join(f"{key}: row[{i}]" for i, key in enumerate(program.input_names))
    values = {
        "head": LAYOUT.head(program.header[:1]),
        "name": program.name,
        "check_file": program.check_file,
        "names": ", ".join(f'"{function}"' for function, _ in program.sizes()),
        "ends": ", ".join(map(str, ends)),
        "tolerances": ", ".join(repr(TOLERANCE[function]) for function, _ in program.sizes()),
        "n_functions": len(ends),
        "n_inputs": len(program.inputs),
        "coefficients": load if program.coefficients else "",
        "inputs": LAYOUT.indented(LAYOUT.lines(f"let inputs = tire::Inputs {{ {members} }};"), 2),
        "calls": LAYOUT.indented(calls, 2),
    }
    return filled(_SELF_TEST, values)
