"""A tire or a model printed in the language of another program, with its values and a self-test."""

from __future__ import annotations

import os
import tempfile
from collections.abc import Sequence
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path

from ...boundary.errors import TirefmuError, UnknownName, writing
from ...boundary.escaping import excerpt
from ...symbolic.model.lines import reaching
from ...symbolic.models import MODELS
from ...symbolic.printers.languages import printer
from ...symbolic.printers.languages.program import (
    FUNCTIONS,
    PLACEMENTS,
    PrintedProgram,
    PrintoutSelection,
    operations,
    program,
)
from ...symbolic.printers.routines import chosen_routines
from ...tires import Tire, TireLike, tire_from
from .self_test import ROWS, check_text

#: Load and radius of the tire that represents a model: N, m.
SAMPLE = {"FNOMIN": 4000.0, "UNLOADED_RADIUS": 0.3}


def generate(
    tire: TireLike,
    language: str,
    folder: str | Path,
    *,
    functions: Sequence[str] = FUNCTIONS[:3],
    values: str | None = None,
    only: Sequence[str] = (),
    rows: int = ROWS,
) -> list[Path]:
    """Print a tire as code for another program.

    `tire`: a tire, a .tir file, a published tire, or a model: then with default values. `folder`: created if necessary;
    files of the same names are replaced. `functions`: of "forces", "quantities", "jacobian_inputs",
    "jacobian_parameters" and "states". `values`, one of "inline", "struct", "file": where the coefficients are;
    default: "inline" for a tire, "struct" for a model. `only`: forces and moments to print; all if empty. `rows`: rows
    of the self-test. Returns: the written files. Raises `UnknownName` if a language, a function, an output or the tire
    does not exist. Raises `TirefmuError` if the derivatives by coefficients are requested without coefficients, or
    states of a tire without states, or a file cannot be written.

    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     written = generate("trento_hoosier", "cpp", folder, only=["Fy"])
    >>> [path.name for path in written]
    ['trento_hoosier.hpp', 'trento_hoosier_selftest.cpp', 'trento_hoosier_selftest.txt']
    """
    files = printed(tire, language, functions=functions, values=values, only=only, rows=rows)
    folder = Path(folder)
    with writing(folder):
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryDirectory(dir=folder, prefix=".tirefmu.") as scratch:
            for name, text in files.items():
                (Path(scratch) / name).write_text(text, encoding="ascii", newline="\n")
            for name in files:
                os.replace(Path(scratch) / name, folder / name)
    return [folder / name for name in files]


def printed(
    tire: TireLike,
    language: str,
    *,
    functions: Sequence[str] = FUNCTIONS[:3],
    values: str | None = None,
    only: Sequence[str] = (),
    rows: int = ROWS,
) -> dict[str, str]:
    """Return the files of `generate` as texts by name; the parameters are the same."""
    print_files = printer(language)
    for name in functions:
        if name not in FUNCTIONS:
            raise UnknownName("function", name, FUNCTIONS)
    if not functions:
        raise TirefmuError(f"no function: choose from {', '.join(FUNCTIONS)}")
    if values is not None and values not in PLACEMENTS:
        raise UnknownName("placement of values", values, PLACEMENTS)
    given, name = _tire(tire)
    for output in only:
        if output not in given.outputs:
            raise UnknownName(f"output of {given.model}", output, given.outputs)
    placement = values or ("struct" if isinstance(tire, str) and tire in MODELS else "inline")
    selection = PrintoutSelection(tuple(functions), placement, tuple(only))
    return print_files(program_of(given, name, selection, rows))


def _tire(tire: TireLike) -> tuple[Tire, str]:
    """Return a tire in ISO-W and its name."""
    if isinstance(tire, str) and tire in MODELS:
        return Tire(tire, SAMPLE), tire
    given = tire_from(tire)
    stem = tire.model if isinstance(tire, Tire) else Path(os.fspath(tire)).stem
    return given.in_signs("iso"), stem


def program_of(tire: Tire, name: str, selection: PrintoutSelection, rows: int = ROWS) -> PrintedProgram:
    """Return what is printed of a tire: lines, header and self-test.

    `tire`: in ISO-W.
    """
    model = tire.symbolic_model
    parameters = dict(zip(model.coefficients, tire.parameters().tolist(), strict=False))
    nominal = {name: tire.nominal(name) for name in tire.inputs}
    printout = program(name, model, tire.has, parameters, nominal, selection)
    printout = replace(printout, header=_header(tire, printout))
    return replace(printout, check=check_text(tire, printout, rows))


def _header(tire: Tire, printout: PrintedProgram) -> tuple[str, ...]:
    model = tire.symbolic_model
    absent = [name for name in model.effects if name not in tire.has and not model.effects[name].optional]
    lines = [
        f"{model.title} ({model.name}): {', '.join(q.name for q in printout.outputs)}.",
        f"Tire: {excerpt(tire.name or 'unnamed')}. Generated by tirefmu {version('tirefmu')}; do not edit.",
        f"Effects: {', '.join(printout.effects) or 'none'}.",
        *([f"Without: {', '.join(absent)}."] if absent else []),
        "Units: SI (m, N, rad, s, Pa, K differences in deg C); slip kappa is a fraction.",
        "Signs: TYDEX W axes (ISO): positive alpha gives negative Fy. Forces act at the contact point.",
    ]
    lines += [
        f"Nominal inputs: {', '.join(f'{q.name} {printout.nominal[q.name]:g}' for q in printout.inputs)}.",
    ]
    lines += _about_states(tire, printout)
    if printout.placement == "inline":
        lines.append(_saved(tire, printout))
    return tuple(lines)


def _about_states(tire: Tire, printout: PrintedProgram) -> list[str]:
    """Return how states are used: they are inputs, and lagged slips act in place of the wheel's."""
    lagged = [quantity.name for quantity in printout.inputs if quantity.name not in tire.inputs]
    states = [*lagged, *tire.states]
    if not any(routine.name == "states" for routine in printout.routines):
        return [f"States are inputs: {', '.join(states)}. The function states has their derivatives."] if states else []
    lines = [
        f"States are inputs: {', '.join(states)}. NAME_dot is the derivative of NAME. After a step h of constant"
        " inputs: NAME + NAME_dot*(1 - exp(-NAME_decay*h))/NAME_decay, or NAME + NAME_dot*h if NAME_decay is 0."
    ]
    acting = {"kappa_lagged": "kappa = kappa_lagged", "tan_alpha_lagged": "alpha = atan(tan_alpha_lagged)"}
    if lagged:
        lines.append(f"Forces at lagged slips: call forces with {', '.join(acting[name] for name in lagged)}.")
    return lines


def _saved(tire: Tire, printout: PrintedProgram) -> str:
    """Return how many operations the values in the lines save, compared with the code for any tire of the model."""
    outputs = [quantity.symbol for quantity in printout.outputs]
    lines = tire.symbolic_model.lines()
    general = chosen_routines(reaching(lines, [str(output) for output in outputs]), ["forces"], outputs, [], [])[0]
    forces = chosen_routines(printout.lines, ["forces"], outputs, [], [])[0]
    before, after = operations(general), operations(forces)
    return (
        f"Values are in the lines: {after} operations for the forces, {before} in the code for any {tire.model} tire."
    )
