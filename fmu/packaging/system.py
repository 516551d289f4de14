"""Export of tires as a system of FMUs (SSP), and of a tire's values as a parameter set (.ssv)."""

from __future__ import annotations

import os
from collections.abc import Iterable, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from tirefmu.symbolic.errors import FmuError, path_from
from tirefmu.tires import Tire, TireLike, tire_from
from tirefmu.tires.property_file.writing import tir_text

from ..description.interface import interface
from ..description.system_structure import Component, parameter_mapping, parameter_set, system_structure
from .export import c_identifier, checked_interface, export, fmi_version, write_file, write_zip

#: Names of four tires.
FOUR = ("FL", "FR", "RL", "RR")


def export_system(
    tires: Sequence[TireLike],
    path: str | os.PathLike[str],
    *,
    fmi: int | float | str = 2,
    inputs: str = "slip",
    axes: str = "iso",
    quantities: bool = False,
    platforms: str | Iterable[str] = "host",
) -> Path:
    """Write a system of tires as an SSP archive: FMUs, a parameter set for each tire, and its mapping.

    Equal tires have one FMU. The system has the inputs and outputs of every tire, named as in FL_Fz; a host connects
    its vehicle to them. A parameter set (.ssv) has every coefficient: replacing the file replaces the tire.

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

    Returns
    -------
    Path
        The file written.

    Raises
    ------
    FmuError
        As `export`, or if there is no tire.

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
    files: dict[str, bytes] = {}
    components: list[Component] = []
    for name, tire in zip(names, loaded, strict=True):
        same = next((done for done, other in zip(components, loaded, strict=False) if _equal(other, tire)), None)
        stem = c_identifier(tire.name or tire.model)
        stem = f"{stem}_{name}" if f"resources/{stem}.fmu" in files else stem
        fmu, mapping = (same.fmu, same.mapping) if same else (f"resources/{stem}.fmu", f"resources/{stem}.ssm")
        variables = interface(tire, **options).variables
        components.append(Component(name, fmu, f"resources/{name}.ssv", mapping, variables))
        files[components[-1].values] = parameter_set(version, name, variables)
        if not same:
            files[mapping] = parameter_mapping(version, variables)
            with TemporaryDirectory(prefix="tirefmu-") as folder:
                packed = export(tire, Path(folder) / f"{stem}.fmu", fmi=version, platforms=platforms, **options)
                files[fmu] = packed.read_bytes()
    files["SystemStructure.ssd"] = system_structure(version, c_identifier(target.stem), components)
    write_zip(target, files)
    return target


def _equal(tire: Tire, other: Tire) -> bool:
    return tir_text(tire) == tir_text(other)


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
    write_file(target, parameter_set(version, loaded.name or loaded.model, variables))
    return target
