"""A tire as a C++17 header, templated on the scalar type: double, float, automatic differentiation, firmware."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from tirefmu.boundary.escaping import c_comment

from ..routines import Routine
from .expressions import CppPrinter
from .layout import Layout, filled
from .program import TOLERANCE, Program

LAYOUT = Layout(CppPrinter(), "const Scalar {name} = {value};", "// {}", c_comment)

_HEADER = """\
@head@
//
// Usage:
//     #include "@name@.hpp"
//     @name@::Inputs<double> inputs;       // nominal values
//     inputs.alpha = 0.05;
//     const auto forces = @name@::forces(inputs@argument@);
// Scalar is double, float, or a type of automatic differentiation that has the functions of <cmath>. A symbolic type,
// whose comparisons are no bool, specializes Choice<Scalar>. Nothing allocates memory or throws.
// Self-test: compile @name@_selftest.cpp and run it in this folder.
#ifndef TIREFMU_@guard@_HPP
#define TIREFMU_@guard@_HPP

#include <array>
#include <cmath>
#include <cstddef>
@file_includes@
namespace @name@ {

// A value by a condition; specialize it for a symbolic type.
template <class Scalar>
struct Choice {
    template <class Condition>
    static Scalar choose(const Condition &condition, const Scalar &then, const Scalar &otherwise)
    {
        return condition ? then : otherwise;
    }
};

namespace detail {

// Functions that act on signs have the derivative 0 at a jump, and NaN stays NaN.
template <class Scalar>
struct Functions : Choice<Scalar> {
    using Choice<Scalar>::choose;
    static Scalar sgn(const Scalar &x)
    {
        const Scalar zero = choose(x == x, Scalar(0.0), x);
        return choose(x > Scalar(0.0), Scalar(1.0), choose(x < Scalar(0.0), Scalar(-1.0), zero));
    }
    static Scalar sgn1(const Scalar &x)
    {
        return choose(x >= Scalar(0.0), Scalar(1.0), choose(x < Scalar(0.0), Scalar(-1.0), x));
    }
    static Scalar absolute(const Scalar &x)
    {
        const Scalar zero = choose(x == x, Scalar(0.0), x);
        return choose(x > Scalar(0.0), x, choose(x < Scalar(0.0), Scalar(-x), zero));
    }
    static Scalar square(const Scalar &x) { return x*x; }
    static Scalar cube(const Scalar &x) { return x*x*x; }
    static Scalar fourth(const Scalar &x) { return (x*x)*(x*x); }
    static Scalar cubed_sqrt(const Scalar &x)
    {
        using std::sqrt;
        return x*sqrt(x);
    }
};

} // namespace detail

@structures@

@functions@

} // namespace @name@

#endif
"""

_FUNCTION = """\
// @summary@
template <class Scalar>
@result@<Scalar> @function@(@parameters@)
{
    using std::acos, std::atan, std::cos, std::exp, std::log, std::pow, std::sin, std::sqrt, std::tan;
    using Math [[maybe_unused]] = detail::Functions<Scalar>;
@read@
@statements@

@values@
}"""

_READ_FILE = """\
// Read coefficients from a text file with lines "NAME value"; false if it cannot be read or one is missing.
template <class Scalar>
bool read_coefficients(const char *path, Coefficients<Scalar> &coefficients)
{
    std::ifstream file(path);
    std::size_t found = 0;
    std::string name;
    for (double value; file >> name >> value;) {
@assignments@
    }
    return found == N_COEFFICIENTS;
}"""

_SELF_TEST = """\
@head@
//
// Self-test: c++ -std=c++17 -O1 @name@_selftest.cpp -o selftest && ./selftest
// Compares @name@.hpp with the stored results of tirefmu in @check_file@ and prints the largest difference of each
// function, relative to the result or its typical size. Exit code 1: a difference exceeds the tolerance.
#include "@name@.hpp"

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <vector>

int main()
{
    std::ifstream file("@check_file@");
    std::size_t n = 0;
    file >> n;
    std::vector<double> sizes(@n_results@), expected(@n_results@), results;
    for (double &size : sizes)
        file >> size;
    double largest[@n_functions@] = {};
@read_coefficients@    for (std::size_t i = 0; i < n; i++) {
        @name@::Inputs<double> inputs;
@read@
        for (double &value : expected)
            file >> value;
        results.clear();
@calls@
        std::size_t k = 0;
@compare@
    }
    bool ok = bool(file) && n > 0;
@report@
    return ok ? 0 : 1;
}
"""


def files(program: Program) -> dict[str, str]:
    """Return the header, its self-test and their data: text by file name."""
    name = program.name
    values = {
        "head": LAYOUT.head(program.header),
        "name": name,
        "guard": name.upper(),
        "argument": ", coefficients" if program.placement == "file" else "",
        "file_includes": "#include <fstream>\n#include <string>\n" if program.placement == "file" else "",
        "structures": "\n\n".join(_structures(program)),
        "functions": "\n\n".join(_functions(program)),
    }
    return {
        f"{name}.hpp": filled(_HEADER, values),
        f"{name}_selftest.cpp": _self_test(program),
        **program.data_files(),
    }


def _structures(program: Program) -> list[str]:
    inputs = {q.name: f" = Scalar({program.nominal[q.name]!r}); // {_meaning(q)}" for q in program.inputs}
    parts = [_structure("Inputs", "Operating conditions", inputs)]
    if program.coefficients:
        declared = program.model.coefficients
        stored = program.placement == "struct"
        members = {
            name: f"{f' = Scalar({value!r})' if stored else '{}'}; // {_meaning(declared[name])}"
            for name, value in program.coefficients.items()
        }
        count = f"constexpr std::size_t N_COEFFICIENTS = {len(members)};"
        parts += [_structure("Coefficients", "Coefficients", members), count]
    for routine in program.routines:
        parts.append(_result(program, routine))
    return parts


def _meaning(declared: object) -> str:
    return c_comment(f"{declared.description} [{declared.unit}]")  # type: ignore[attr-defined]


def _structure(name: str, meaning: str, members: Mapping[str, str]) -> str:
    body = "\n".join(f"    Scalar {member}{rest}" for member, rest in members.items())
    return f"// {meaning}.\ntemplate <class Scalar>\nstruct {name} {{\n{body}\n}};"


def _result(program: Program, routine: Routine) -> str:
    """Return the type of a function's result."""
    if not routine.name.startswith("jacobian_"):
        units = {quantity.name: _meaning(quantity) for quantity in program.outputs}
        units |= {str(line.symbol): c_comment(f"{line.description} [{line.unit}]") for line in program.lines}
        return _structure(routine.name.capitalize(), routine.summary.rstrip("."),
                          {label: f"; // {units[label]}" for label in routine.labels})  # fmt: skip
    rows, columns = len(routine.results), len(routine.labels)
    return (
        f"// {routine.summary[:-1]}: a row for each force, a column for each.\ntemplate <class Scalar>\n"
        f"using {_type(routine)} = std::array<std::array<Scalar, {columns}>, {rows}>;"
    )


def _type(routine: Routine) -> str:
    return "".join(word.capitalize() for word in routine.name.split("_"))


def _functions(program: Program) -> list[str]:
    parts = [_function(program, routine) for routine in program.routines]
    if program.placement == "file":
        assignments = "\n".join(
            f'        if (name == "{name}") {{\n            coefficients.{name} = Scalar(value);\n'
            "            found++;\n        }"
            for name in program.coefficients
        )
        parts.append(filled(_READ_FILE, {"assignments": assignments}))
    return parts


def _function(program: Program, routine: Routine) -> str:
    parameters = f"const Inputs<Scalar> &{'inputs' if routine.uses(program.input_names) else ''}"
    read = [f"const Scalar &{name} = inputs.{name};" for name in routine.uses(program.input_names)]
    if program.coefficients:
        used = routine.uses(list(program.coefficients))
        default = " = {}" if program.placement == "struct" else ""
        parameters += f", const Coefficients<Scalar> &{'coefficients' if used else ''}{default}"
        read += [f"const Scalar &{name} = coefficients.{name};" for name in used]
    if routine.name.startswith("jacobian_"):
        values = ["return {{", *(f"    {line}" for line in LAYOUT.rows(routine, "{{{{{}}}}},")), "}};"]
    else:
        values = LAYOUT.lines(f"return {{{', '.join(LAYOUT.values(routine))}}};")
    return filled(
        _FUNCTION,
        {
            "summary": c_comment(routine.summary),
            "result": _type(routine),
            "function": routine.name,
            "parameters": parameters,
            "read": LAYOUT.indented(read),
            "statements": LAYOUT.statements(routine),
            "values": LAYOUT.indented(values),
        },
    )


def _self_test(program: Program) -> str:
    name = program.name
    calls, compare, report = [], [], []
    for i, (routine, (_, size)) in enumerate(zip(program.routines, program.sizes(), strict=True)):
        argument = ", coefficients" if program.placement == "file" else ""
        calls.append(f"const auto {routine.name} = {name}::{routine.name}(inputs{argument});")
        calls += _collected(routine)
        compare += [
            f"for (std::size_t end = k + {size}; k < end; k++) {{",
            "    const double size = std::max(sizes[k], std::abs(expected[k]));",
            "    const double difference = std::abs(results[k] - expected[k])/size;",
            f"    if (!(difference <= largest[{i}]))",
            f"        largest[{i}] = difference >= 0.0 ? difference : HUGE_VAL; // NaN stays the largest",
            "}",
        ]
        tolerance = f"{TOLERANCE[routine.name]!r}"
        report += [
            f'std::printf("{routine.name} %.3g\\n", largest[{i}]);',
            f"ok = ok && largest[{i}] <= {tolerance};",
        ]
    load = (
        f"    {name}::Coefficients<double> coefficients;\n"
        f'    if (!{name}::read_coefficients("{program.values_file}", coefficients))\n        return 1;\n'
    )
    values = {
        "head": LAYOUT.head(program.header[:1]),
        "name": name,
        "check_file": program.check_file,
        "n_results": sum(size for _, size in program.sizes()),
        "n_functions": len(program.routines),
        "read_coefficients": load if program.placement == "file" else "",
        "read": LAYOUT.indented([f"file >> inputs.{input_};" for input_ in program.input_names], 2),
        "calls": LAYOUT.indented(calls, 2),
        "compare": LAYOUT.indented(compare, 2),
        "report": LAYOUT.indented(report),
    }
    return filled(_SELF_TEST, values)


def _collected(routine: Routine) -> Sequence[str]:
    """Return the statements that append the results of a function to those of the row."""
    if not routine.name.startswith("jacobian_"):
        return [f"results.push_back({routine.name}.{label});" for label in routine.labels]
    return [f"for (const auto &row : {routine.name})", "    results.insert(results.end(), row.begin(), row.end());"]
