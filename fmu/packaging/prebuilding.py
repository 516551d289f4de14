"""Build the binaries of `prebuilt` for every model and platform: ``python -m tirefmu.fmu.packaging.prebuilding``."""

from __future__ import annotations

import argparse
import hashlib
import json
import os
from collections.abc import Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from itertools import product

from tirefmu.symbolic.models import MODELS
from tirefmu.tires import Tire
from tirefmu.tires.code.compiler import suffix

from ..description.interface import AXES, INPUTS
from . import prebuilt
from .binaries import binary, chosen_platforms, host_platform
from .cross_compiler import PLATFORMS, ziglang
from .export import fmi_headers
from .prebuilt import MANIFEST, Generic, generic


def every_generic(models: Iterable[str]) -> Iterator[tuple[str, Generic]]:
    """Yield each set of variables that tires without added effects can have, with a name.

    Parameters
    ----------
    models : iterable of str

    Yields
    ------
    str
        Such as ``mf61-wheel-iso-relaxation``.
    Generic

    Examples
    --------
    >>> [name for name, _ in every_generic(["brush"])]
    ['brush-slip-iso', 'brush-slip-sae', 'brush-wheel-iso', 'brush-wheel-sae']
    """
    for name in models:
        book, found = MODELS[name], set()
        relaxation = sorted(book.relaxing_effects)[:1]
        on_demand = [effect for effect, _ in book.on_demand]
        values = {"FNOMIN": 4000.0, "UNLOADED_RADIUS": 0.3}
        for inputs, axes, lags, turns in product(INPUTS, AXES, (False, True), (False, True)):
            effects = [*(relaxation if lags else ()), *(on_demand if turns else ())]
            shape = generic(Tire(name, values, effects=effects), inputs=inputs, axes=axes)
            if shape.structure not in found:
                found.add(shape.structure)
                words = [name, inputs, axes, *(["relaxation"] if lags else []), *(on_demand if turns else [])]
                yield "-".join(words), shape


def build(shapes: Iterable[tuple[str, Generic]], platforms: Iterable[str]) -> int:
    """Build the binaries, and write the list of their digests.

    Parameters
    ----------
    shapes : iterable of tuple of str and Generic
        As from `every_generic`.
    platforms : iterable of str
        As from `chosen_platforms`: ``host`` with the system's compiler, others with ziglang.

    Returns
    -------
    int
        Number of binaries. Other files of the folder are removed.

    Raises
    ------
    FmuError
        If there is no compiler, or it fails.
    """
    folder, platforms = prebuilt.FOLDER, list(platforms)
    folder.mkdir(parents=True, exist_ok=True)
    (folder / MANIFEST).unlink(missing_ok=True)
    headers, entries = fmi_headers(), {}

    def built(job: tuple[str, Generic, str]) -> None:
        name, shape, platform = job
        cross = None if platform == "host" else ziglang(platform)
        content = binary(shape.sources, shape.shown.tire.model, headers, cross)
        named = host_platform() if cross is None else platform
        system = PLATFORMS[named].system
        file = f"{name}-{named}{suffix(system)}"
        (folder / file).write_bytes(content)
        digest = hashlib.sha256(content).hexdigest()
        entries[f"{shape.structure} {named}"] = {"file": file, "sha256": digest}

    jobs = [(*shape, platform) for shape in shapes for platform in platforms]
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        list(pool.map(built, jobs))
    for path in folder.iterdir():
        if path.name not in {entry["file"] for entry in entries.values()}:
            path.unlink()
    (folder / MANIFEST).write_text(json.dumps(entries, indent=1, sort_keys=True) + "\n", encoding="ascii")
    return len(entries)


def main() -> None:
    """Run the command of this module."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--models", default=",".join(MODELS), help="names separated by commas")
    parser.add_argument("--platforms", default="all", help="host, all, or FMI 3 names separated by commas")
    given = parser.parse_args()
    count = build(every_generic(given.models.split(",")), chosen_platforms(given.platforms))
    size = sum(path.stat().st_size for path in prebuilt.FOLDER.iterdir())
    print(f"{count} binaries, {size / 1e6:.1f} MB: {prebuilt.FOLDER}")


if __name__ == "__main__":
    main()
