"""Everything that is generated: rendered as text, written, or compared with what is committed.

The files that people read are committed: the forces, quantities, operations and structure of each model. The Jacobians,
the kernels for tables, and each model with the whole library of effects are printed when a wheel is built, or at first
use (`tirefmu.tires.code.printed`).
"""

from __future__ import annotations

import difflib
import hashlib
import json
from dataclasses import replace
from functools import lru_cache
from pathlib import Path

from ..added import packaged_library, texts_digest
from ..model import Model
from ..model.discovery import packaged_models
from ..model.verification import verify
from ..models import MODELS, WITH_EFFECTS, whole_library
from .batch import KERNELS, batch_sources
from .c import c_header, c_jacobians, c_values
from .line_functions import line_function_files
from .operations import c_operations
from .python import origin, python_jacobians, python_values
from .rolling_radius import c_loaded_radius, c_rolling_radius
from .routines import Routine, jacobians, value_routines


def render(everything: bool = False) -> dict[str, str]:
    """Return the generated files: path relative to the folder, text. They are identical byte by byte in every run.

    `everything`: also the files on demand, and in the folder `WITH_EFFECTS` each model with the whole library of
    effects, for the diagnosis. Without it, the committed files.

    See render_model : the files of one model.
    """
    files = line_function_files()
    models = [_from_lines(MODELS[name]) for name in sorted(packaged_models())]
    extended = [_with_library(model) for model in models] if everything else []
    for model in models:
        on_demand = set() if everything else set(files_on_demand(model.name))
        printed = render_model(model) if everything else render_values(model)
        files |= {name: text for name, text in printed.items() if name not in on_demand}
    for model in extended:
        files |= {f"{WITH_EFFECTS}/{name}": text for name, text in render_model(model).items()}
    files["MANIFEST.json"] = _manifest(files, models, extended)
    return files


@lru_cache(maxsize=16)
def _from_lines(model: Model) -> Model:
    """Return a model without its stored structure, which may be outdated."""
    return replace(model)


@lru_cache(maxsize=16)
def _with_library(model: Model) -> Model:
    return model.extended(whole_library(model, packaged_library()))


def render_model(model: Model) -> dict[str, str]:
    """Return the files of one model: path relative to the folder, text.

    `model`: also one with added effects. Raises `ModelError` if the model violates its declarations; see
    `tirefmu.symbolic.model.verification`.

    >>> from tirefmu.symbolic.models import model_named
    >>> sorted(render_model(model_named("mf96")))[:3]
    ['c/mf96.c', 'c/mf96.h', 'c/mf96_batch_forces.c']
    """
    return render_values(model) | render_jacobians(model)


@lru_cache(maxsize=16)
def render_values(model: Model) -> dict[str, str]:
    """Return those of the files of one model that are not about Jacobians."""
    verify(model)
    parts = value_routines(model)
    return {
        **_kernels(model, parts),
        f"numpy/{model.name}.py": python_values(model, parts),
        f"c/{model.name}.c": c_values(model, parts),
        f"c/{model.name}.h": c_header(model, parts),
        f"c/{model.name}_operations.h": c_operations(model),
        f"c/{model.name}_rolling_radius.h": c_rolling_radius(model),
        f"c/{model.name}_loaded_radius.h": c_loaded_radius(model),
        f"structure/{model.name}.json": model.structure.to_text(origin(model)),
    }


@lru_cache(maxsize=16)
def render_jacobians(model: Model) -> dict[str, str]:
    """Return the files of the Jacobians of one model, and the header that they include."""
    parts, header = jacobians(model), f"c/{model.name}.h"
    return {
        **_kernels(model, parts),
        f"numpy/{model.name}_jacobians.py": python_jacobians(model, parts),
        f"c/{model.name}_jacobians.c": c_jacobians(model, parts),
        header: render_values(model)[header],
    }


def _kernels(model: Model, routines: tuple[Routine, ...]) -> dict[str, str]:
    return {f"c/{model.name}_batch_{name}.c": text for name, text in batch_sources(model, routines).items()}


def files_on_demand(name: str) -> list[str]:
    """Return the files of a model that are not committed: its Jacobians and its kernels, most of the text.

    >>> files_on_demand("mf96")[:2]
    ['numpy/mf96_jacobians.py', 'c/mf96_jacobians.c']
    """
    kernels = [f"c/{name}_batch_{kernel}.c" for kernel in KERNELS]
    return [f"numpy/{name}_jacobians.py", f"c/{name}_jacobians.c", *kernels]


def write(folder: Path, everything: bool = False) -> list[Path]:
    """Write what `render` returns below a folder and remove generated files that are no longer made.

    `everything`: as for `render`. Returns: the files whose text changed, removed ones included.
    """
    changed = []
    files = render(everything)
    for name, text in files.items():
        path = folder / name
        if _text(path) != text:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="ascii", newline="\n")
            changed.append(path)
    for path in _strays(folder, files):
        path.unlink()
        changed.append(path)
    return changed


def difference(folder: Path) -> str:
    """Return the unified diff from the committed files in a folder to the generated texts; empty if equal."""
    files = render()
    stale = {path.relative_to(folder).as_posix(): "" for path in _strays(folder, files)}
    diffs: list[str] = []
    for name, text in {**files, **stale}.items():
        committed = _text(folder / name) or ""
        if committed == text:  # comparing lines takes seconds over all files
            continue
        diffs += difflib.unified_diff(
            committed.splitlines(keepends=True),
            text.splitlines(keepends=True),
            f"generated/{name}",
            f"the equations: {name}",
        )
    return "".join(diffs)


def _text(path: Path) -> str | None:
    """Return the text on disk, line ends included, or None."""
    return path.read_bytes().decode("utf-8") if path.is_file() else None


def _strays(folder: Path, files: dict[str, str]) -> list[Path]:
    """Files that look generated but are not (or no longer) generated."""
    made = {folder / name for name in files}
    kinds = ("numpy/*.py", "c/*.c", "c/*.h", "structure/*.json")
    places = (folder, folder / WITH_EFFECTS)
    present = {path for place in places for kind in kinds for path in place.glob(kind) if path.name != "__init__.py"}
    return sorted(present - made)


def _manifest(files: dict[str, str], models: list[Model], extended: list[Model]) -> str:
    """Return the list of the files with their digests, and the digests of their sources."""
    content = {
        "lines": {model.name: _lines_hash(model) for model in models},
        WITH_EFFECTS: {model.name: texts_digest(model.added) for model in extended},
        "files": {name: hashlib.sha256(text.encode()).hexdigest() for name, text in sorted(files.items())},
    }
    return json.dumps(content, indent=2) + "\n"


@lru_cache(maxsize=16)
def _lines_hash(model: Model) -> str:
    text = "\n".join(f"{line.number} {line.symbol} = {line.expression}" for line in model.lines())
    return hashlib.sha256(text.encode()).hexdigest()
