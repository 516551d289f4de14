"""Build the binaries of `prebuilt` for every model and platform: ``python -m tirefmu.fmu.packaging.prebuilding``."""

from __future__ import annotations

import argparse
import hashlib
import json
import lzma
import os
import shutil
from collections.abc import Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from itertools import product

from ...boundary.errors import FmuError
from ...symbolic.models import MODELS
from ...tires import Tire
from ..description.interface import AXES, INPUTS
from . import prebuilt
from .binaries import binary, chosen_platforms, host_platform
from .cross_compiler import ziglang
from .export import fmi_headers
from .prebuilt import MANIFEST, Generic, generic


def every_generic(models: Iterable[str]) -> Iterator[Generic]:
    """Yield each set of variables that tires without added effects can have.

    >>> [(each.shown.inputs, each.shown.axes) for each in every_generic(["brush"])][:3]
    [('slip', 'iso'), ('slip', 'sae'), ('wheel', 'iso')]
    """
    for name in models:
        model, seen = MODELS[name], set()
        relaxation = sorted(model.relaxing_effects)[:1]
        on_demand = [effect for effect, _ in model.on_demand]
        values = {"FNOMIN": 4000.0, "UNLOADED_RADIUS": 0.3}
        for inputs, axes, lags, turns in product(INPUTS, AXES, (False, True), (False, True)):
            effects = [*(relaxation if lags else ()), *(on_demand if turns else ())]
            try:
                shape = generic(Tire(name, values, effects=effects), inputs=inputs, axes=axes)
            except FmuError:  # hub inputs have ISO axes only
                continue
            if shape.structure not in seen:
                seen.add(shape.structure)
                yield shape


def build(shapes: Iterable[Generic], platforms: Iterable[str]) -> int:
    """Build the binaries, and write them and the list of their digests; other files of the folder are removed.

    The binaries of a model for a platform are compressed together, because they differ little.

    `shapes`: as from `every_generic`. `platforms`: as from `chosen_platforms`: ``host`` with the system's compiler,
    others with ziglang. Returns: number of binaries. Raises `FmuError` if there is no compiler, or it fails.
    """
    folder, headers, jobs = prebuilt.FOLDER, fmi_headers(), list(product(shapes, platforms))

    def built(job: tuple[Generic, str]) -> bytes:
        shape, platform = job
        cross = None if platform == "host" else ziglang(platform)
        return binary(shape.sources, shape.shown.tire.model, headers, cross)

    with ThreadPoolExecutor(os.cpu_count()) as pool:
        contents = list(pool.map(built, jobs))
    packs: dict[str, bytes] = {}
    entries: dict[str, dict[str, str | int]] = {}
    for (shape, platform), content in zip(jobs, contents, strict=True):
        named = host_platform() if platform == "host" else platform
        file = f"{shape.shown.tire.model}-{named}.xz"
        place: dict[str, str | int] = {"file": file, "start": len(packs.get(file, b"")), "size": len(content)}
        entries[f"{shape.structure} {named}"] = {**place, "sha256": hashlib.sha256(content).hexdigest()}
        packs[file] = packs.get(file, b"") + content
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    for file, pack in packs.items():
        (folder / file).write_bytes(lzma.compress(pack, preset=9 | lzma.PRESET_EXTREME))
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
