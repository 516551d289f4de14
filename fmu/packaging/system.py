"""Export of tires as a system of FMUs (SSP), and of a tire's values as a parameter set (.ssv)."""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from difflib import get_close_matches
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from ...boundary.errors import FmuError, path_from
from ...boundary.escaping import visible
from ...tires import Tire, TireLike, tire_from
from ...tires.property_file.mirror import mirrored, sided
from ...tires.property_file.writing import tir_text
from ..description.interface import interface
from ..description.system_structure import (
    Component,
    inputs_of,
    parameter_mapping,
    parameter_set,
    parameters,
    system_structure,
)
from ..description.variables import Variable
from ..simulation.archive import unpacked
from ..simulation.simulate import read_description
from .export import c_identifier, checked_interface, export, fmi_version, write_file, write_zip

#: Names of four tires.
FOUR = ("FL", "FR", "RL", "RR")
#: The parameter set with the start values of the inputs of a system.
SYSTEM_VALUES = "resources/inputs.ssv"


def export_system(
    tires: Sequence[TireLike],
    path: str | os.PathLike[str],
    *,
    fmi: int | float | str = 2,
    inputs: str = "slip",
    axes: str = "iso",
    quantities: bool = False,
    platforms: str | Iterable[str] = "host",
    vehicle: str | os.PathLike[str] | None = None,
    mirror: bool = True,
) -> Path:
    """Write a system of tires as an SSP archive: FMUs, a parameter set for each tire, and its mapping.

    Equal tires have one FMU. The system has the inputs and outputs of every tire, named as in FL_Fz; a host connects
    its vehicle to them. Its inputs have the start values of the tires. A parameter set (.ssv) has every coefficient:
    replacing the file replaces the tire.

    Parameters
    ----------
    tires : sequence of Tire, paths of .tir files, or names of published tires
        Four tires are FL, FR, RL and RR; others are tire_1, tire_2 and so on.
    path : path-like
        The file to write.
    fmi : {2, 3}
        2 for SSP 1.0, which most hosts read; 3 for SSP 2.0.
    inputs, axes, quantities, platforms
        As in `export`.
    vehicle : path-like, optional
        An FMU of the same FMI version that is part of the system. Its inputs and outputs whose names begin with the
        name of a tire, such as FL_Fz, are connected to those of that tire; the system has no connectors of its own.
    mirror : bool
        Whether a corner whose tire is of the other side of the vehicle (TYRESIDE) has its mirror image. A tire that
        states no side is used as it is.

    Returns
    -------
    Path
        The file written.

    Raises
    ------
    FmuError
        As `export`, or if there is no tire, or the vehicle cannot be connected.
    TireError
        If a tire to be mirrored has an added effect without a mirror image.

    References
    ----------
    System Structure and Parameterization 1.0 and 2.0, https://ssp-standard.org.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as folder:
    ...     export_system(["trento_hoosier"] * 4, Path(folder) / "car.ssp").name
    'car.ssp'
    """
    version, target, loaded = fmi_version(fmi), path_from(path), [tire_from(tire) for tire in tires]
    if not loaded:
        raise FmuError("a system needs at least one tire")
    checked_interface(inputs, axes)
    options: dict[str, Any] = {"inputs": inputs, "axes": axes, "quantities": quantities}
    names = FOUR if len(loaded) == len(FOUR) else tuple(f"tire_{i}" for i in range(1, len(loaded) + 1))
    if mirror:
        loaded = [
            mirrored(tire) if side_mismatch(name, tire) else tire for name, tire in zip(names, loaded, strict=True)
        ]
    files: dict[str, bytes] = {}
    components: list[Component] = []
    for name, tire in zip(names, loaded, strict=True):
        equal = (tir_text(other) == tir_text(tire) for other in loaded)
        same = next((done for done, is_equal in zip(components, equal, strict=False) if is_equal), None)
        stem = c_identifier(tire.name or tire.model)
        stem = f"{stem}_{name}" if f"resources/{stem}.fmu" in files else stem
        fmu, mapping = (same.fmu, same.mapping) if same else (f"resources/{stem}.fmu", f"resources/{stem}.ssm")
        variables = interface(tire, **options).variables
        components.append(Component(name, fmu, f"resources/{name}.ssv", mapping, variables))
        files[components[-1].values] = parameter_set(version, name, parameters(variables))
        if not same:
            files[mapping] = parameter_mapping(version, variables)
            with TemporaryDirectory(prefix="tirefmu-") as folder:
                packed = export(tire, Path(folder) / f"{stem}.fmu", fmi=version, platforms=platforms, **options)
                files[fmu] = packed.read_bytes()
    body = None
    if vehicle is None:
        files[SYSTEM_VALUES] = parameter_set(version, "inputs", inputs_of(components))
    else:
        body = _connected(path_from(vehicle), version, components)
        files[body.fmu] = path_from(vehicle).read_bytes()
    name = c_identifier(target.stem)
    files["SystemStructure.ssd"] = system_structure(version, name, components, body, SYSTEM_VALUES)
    write_zip(target, files)
    return target


def side_mismatch(name: str, tire: Tire) -> bool:
    """Return whether a tire is of the other side of the vehicle than its corner, such as FR.

    >>> side_mismatch("FR", tire_from("trento_hoosier")), side_mismatch("tire_2", tire_from("trento_hoosier"))
    (True, False)
    """
    side = {"L": "left", "R": "right"}[name[1]] if name in FOUR else tire.side
    return tire.side in ("left", "right") and tire.side != side


def side_notes(tires: Sequence[Tire], mirror: bool) -> tuple[str, ...]:
    """Return sentences on the corners of a car whose tires are of another side or state none."""
    corners = list(zip(FOUR, tires, strict=True)) if len(tires) == len(FOUR) else []
    other = [name for name, tire in corners if side_mismatch(name, tire) and sided(tire)]
    unknown = [name for name, tire in corners if not tire.side and sided(tire)]
    notes = []
    if other:
        how = "have the mirror image of" if mirror else "have, not mirrored,"
        notes.append(f"{', '.join(other)} {how} a tire of the other side of the vehicle")
    if unknown:
        notes.append(f"{', '.join(unknown)}: the file states no side (TYRESIDE), so left and right are not mirrored")
    return tuple(notes)


def _connected(path: Path, fmi: int, tires: Sequence[Component]) -> Component:
    """Return the vehicle of a system with its connections checked: names, causality and units."""
    with unpacked(path) as folder:
        described = read_description(path, folder)
    version = int(described.fmiVersion[0])
    if version != fmi:
        raise FmuError(f"{path}: the vehicle is of FMI {version}, the tires are of FMI {fmi}")
    ends = {f"{tire.name}_{variable.name}": variable for tire in tires for variable in tire.connectors}
    ports = [variable for variable in described.modelVariables if variable.causality in ("input", "output")]
    listed = [port for port in ports if port.type in ("Real", "Float64")]
    variables = []
    for variable in listed:
        tire = ends.get(variable.name)
        if tire is None and variable.name.startswith(tuple(f"{tire.name}_" for tire in tires)):
            near = get_close_matches(variable.name, ends, 1)
            hint = f", but {near[0]}" if near else ""
            raise FmuError(f"{path}: the tires have no {visible(variable.name)[:60]}{hint}")
        if tire and tire.causality == variable.causality:
            raise FmuError(f"{path}: {variable.name} is an {tire.causality} of the tire and of the vehicle")
        if tire and variable.unit not in (None, "", tire.unit):
            raise FmuError(
                f"{path}: {variable.name} has the unit {visible(variable.unit)[:20]}, that of the tire {tire.unit}"
            )
        unit = tire.unit if tire else ""
        variables.append(Variable(variable.name, variable.causality, unit, variable.description or ""))
    if not {variable.name for variable in listed} & set(ends):
        raise FmuError(
            f"{path}: no input or output of the vehicle is named as one of a tire, such as {next(iter(ends))}"
        )
    return Component("vehicle", "resources/vehicle.fmu", "", "", tuple(variables))


def export_parameters(
    tire: TireLike,
    path: str | os.PathLike[str],
    *,
    fmi: int | float | str = 2,
    inputs: str = "slip",
    axes: str = "iso",
) -> Path:
    """Write the values of a tire as a parameter set (.ssv), which hosts apply to an FMU of the same model and axes.

    An FMU refuses values outside the limits of its parameters, and names that it does not have are ignored by hosts.

    Parameters
    ----------
    tire : Tire, path of a .tir file, or name of a published tire
        In any signs.
    path : path-like
        The file to write.
    fmi : {2, 3}
        2 for SSP 1.0, 3 for SSP 2.0.
    inputs, axes
        Those of the FMU.

    Returns
    -------
    Path
        The file written.

    Raises
    ------
    FmuError
        If an option is unknown, or the file cannot be written.

    Examples
    --------
    >>> from tempfile import TemporaryDirectory
    >>> with TemporaryDirectory() as folder:
    ...     export_parameters("trento_hoosier", Path(folder) / "tire.ssv").name
    'tire.ssv'
    """
    version, target, loaded = fmi_version(fmi), path_from(path), tire_from(tire)
    checked_interface(inputs, axes)
    variables = interface(loaded, inputs=inputs, axes=axes).variables
    write_file(target, parameter_set(version, loaded.name or loaded.model, parameters(variables)))
    return target
