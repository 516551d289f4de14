"""A model as C kernels for tables: blocks of rows, with as many rows at a time as fit into a vector register."""

from __future__ import annotations

from ..model import Model
from .c import heading, parameters_read, statements
from .definitions import INCLUDES, KERNEL, comment, definitions
from .expressions import LanesPrinter
from .routines import PLAIN, Routine, entries

#: The routines that have a kernel.
KERNELS = ("forces", "jacobian_inputs", "jacobian_parameters")


def batch_sources(model: Model, routines: tuple[Routine, ...]) -> dict[str, str]:
    """Return the sources of the kernels of those of a model's routines that have one, one library each.

    The exported ``<model>_batch_<routine>`` takes n rows whose columns are `stride` numbers apart, for inputs and
    results. It is valid for rows without turn slip under default options and marks the rows without a finite result;
    the caller computes these one by one. Of `jacobian_parameters` it gives the entries of coefficients that a force
    depends on, row by row (`tirefmu.symbolic.printers.routines.entries`); its library also exports
    ``<model>_batch_chosen_derivatives``, some of them, and ``<model>_batch_normal_equations``, which uses them where
    they are (`normal_equations.h`).
    """
    by_name = {routine.full_name: routine for routine in routines}
    sources = {}
    for name in by_name.keys() & set(KERNELS):
        routine = by_name.get(f"{name}_{PLAIN}", by_name[name])
        values = [value for row in routine.results for value in row]
        chosen = entries(model) if name == "jacobian_parameters" else range(len(values))
        sources[name] = _source(model, routine, [values[i] for i in chosen])
    return sources


def _source(model: Model, routine: Routine, values: list[object]) -> str:
    code = f"{_kernel(model, routine, values)}\n\n{_exported(model, routine)}"
    sizes = f"#define WIDE 1\n#define N_INPUTS {model.name.upper()}_N_INPUTS\n#define N_RESULTS {len(values)}"
    if routine.name == "jacobian_parameters":
        code += f"\n\n{_chosen_derivatives(model, routine)}\n\n{_normal_equations(model)}"
        sizes += f"\n#define N_FORCES {model.name.upper()}_N_FORCES"
    parts = [
        heading(model, "a kernel in C with vector types"),
        f'#include "{model.name}.h"\n\n{INCLUDES}',
        sizes,
        definitions(code, KERNEL),
        code,
    ]
    return "\n\n".join(parts) + "\n"


def _kernel(model: Model, routine: Routine, values: list[object]) -> str:
    """Print the loop over a block; terms that depend only on parameters are computed before it."""
    prefix = model.name.upper()
    inputs = routine.uses([quantity.name for quantity in model.inputs])
    printer = LanesPrinter(_varying(inputs, routine))
    fixed = [assignment for assignment in routine.body if not printer.varies(assignment.expression)]
    rows = [assignment for assignment in routine.body if printer.varies(assignment.expression)]
    before = [*parameters_read(model, routine), *statements(fixed)]
    loop = [f"const lanes {name} = *(const lanes_in_array *)(inputs + {prefix}_{name}*BLOCK + i);" for name in inputs]
    loop += [*statements(rows, printer, "lanes"), ""]
    loop += [f"*(lanes_in_array *)(results + {k}*STRIDE + i) = {printer.in_lanes(v)};" for k, v in enumerate(values)]
    return (
        f"{comment(routine.summary)}\n"
        f"static void {routine.name}_kernel(const double inputs[], const double parameters[], double results[])\n{{\n"
        f"{_indented(before, 4)}\n\n    for (size_t i = 0; i < BLOCK; i += LANES) {{\n{_indented(loop, 8)}\n    }}\n}}"
    )


def _varying(inputs: list[str], routine: Routine) -> set[str]:
    """Return the names that differ from row to row."""
    varying = set(inputs)
    for assignment in routine.body:
        if any(symbol.name in varying for symbol in assignment.expression.free_symbols):
            varying.add(assignment.symbol.name)
    return varying


def _indented(lines: list[str], by: int) -> str:
    return "\n".join(" " * by + line if line else "" for line in lines)


def _exported(model: Model, routine: Routine) -> str:
    arguments = "const double parameters[], double results[], unsigned char undone[]"
    put = "put_block(m, stride, aligned(block), results + start, undone + start);"
    return _by_blocks(model, routine, routine.name, arguments, put)


def _chosen_derivatives(model: Model, routine: Routine) -> str:
    arguments = (
        "const double parameters[], size_t count, const size_t chosen[], double results[],\n    unsigned char undone[]"
    )
    put = "put_chosen(m, stride, aligned(block), count, chosen, results + start, undone + start);"
    return _by_blocks(model, routine, "chosen_derivatives", arguments, put)


def _by_blocks(model: Model, routine: Routine, name: str, arguments: str, put: str) -> str:
    """Print an exported function that computes block after block and writes each into the results."""
    head = f"void {model.name}_batch_{name}(size_t n, size_t stride, const double inputs[],\n    {arguments})"
    return (
        f"{head};\n\n{head}\n{{\n"
        "    double columns[N_INPUTS*BLOCK + 8], block[N_RESULTS*STRIDE + 8];\n"
        "    for (size_t start = 0; start < n; start += BLOCK) {\n"
        "        const size_t m = n - start < BLOCK ? n - start : BLOCK;\n"
        "        take_block(m, stride, inputs + start, aligned(columns));\n"
        f"        {routine.name}_kernel(aligned(columns), parameters, aligned(block));\n"
        f"        {put}\n"
        "    }\n}"
    )


def _normal_equations(model: Model) -> str:
    head = (
        f"void {model.name}_batch_normal_equations(size_t n, size_t stride, const double inputs[],\n"
        "    const double parameters[], const size_t first[], const size_t entries[], const double roots[],\n"
        "    const double residuals[], double panels[], double matrices[], unsigned char undone[])"
    )
    return (
        f"{head};\n\n{head}\n{{\n"
        "    add_normal_equations(jacobian_parameters_kernel, n, stride, inputs, parameters, first, entries, roots,\n"
        "        residuals, panels, matrices, undone);\n}"
    )
