"""Everything that is generated: rendered as text, written, or compared with what is committed."""

from __future__ import annotations

import difflib
import hashlib
import json
from dataclasses import replace
from functools import lru_cache
from pathlib import Path

from ..added import texts_digest
from ..model import Model
from ..model.verification import verify
from ..models import MODELS, WITH_EFFECTS, whole_library
from .batch import batch_sources
from .c import c_header, c_sources
from .laws import law_files
from .operations import c_operations
from .python import CASADI, HEADER, NUMPY, python_modules
from .routines import routines
from .wheel.kinematics import kinematic_files
from .wheel.rolling_radius import c_rolling_radius


def render() -> dict[str, str]:
    """Return every generated file: path relative to the folder, text. Deterministic to the byte.

    Each model is printed as it is, and in the folder `WITH_EFFECTS` with the whole library of effects, for the
    diagnosis.

    Returns
    -------
    dict of str to str

    See Also
    --------
    render_model : the files of one model.
    """
    files = law_files() | kinematic_files()
    models = [_from_lines(model) for model in MODELS.values()]
    for model in models:
        files |= render_model(model)
        files |= {f"{WITH_EFFECTS}/{name}": text for name, text in render_model(_with_library(model)).items()}
    files["MANIFEST.json"] = _manifest(files, models)
    return files


@lru_cache(maxsize=16)
def _from_lines(model: Model) -> Model:
    """Return a model without its stored structure, which may be outdated."""
    return replace(model)


@lru_cache(maxsize=16)
def _with_library(model: Model) -> Model:
    return model.extended(whole_library(model))


@lru_cache(maxsize=16)
def render_model(model: Model) -> dict[str, str]:
    """Return the files of one model: path relative to the folder, text.

    Parameters
    ----------
    model : Model
        Also one with added effects, which no committed file holds.

    Returns
    -------
    dict of str to str

    Raises
    ------
    ModelError
        If the model violates its declarations; see `tirefmu.symbolic.model.verification`.

    Examples
    --------
    >>> from tirefmu.symbolic.models import model
    >>> sorted(render_model(model("mf96")))[:3]
    ['c/mf96.c', 'c/mf96.h', 'c/mf96_batch_forces.c']
    """
    verify(model)
    parts = routines(model)
    kernels = {f"c/{model.name}_batch_{name}.c": text for name, text in batch_sources(model, parts).items()}
    sources = {f"c/{name}.c": text for name, text in c_sources(model, parts).items()}
    modules = {
        f"{folder}/{name}.py": text
        for folder, flavor in (("numpy", NUMPY), ("casadi", CASADI))
        for name, text in python_modules(model, parts, flavor).items()
    }
    return {
        **kernels,
        **modules,
        **sources,
        f"c/{model.name}.h": c_header(model, parts),
        f"c/{model.name}_operations.h": c_operations(model),
        f"c/{model.name}_rolling_radius.h": c_rolling_radius(model),
        f"structure/{model.name}.json": model.structure.to_text(HEADER.format(name=model.name)),
    }


def write(folder: Path) -> list[Path]:
    """Write what `render` returns below a folder and remove generated files that are no longer made.

    Parameters
    ----------
    folder : Path

    Returns
    -------
    list of Path
        The files whose text changed, removed ones included.
    """
    changed = []
    files = render()
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
    """Return the unified diff from the files in a folder to what would be generated; empty where equal.

    Parameters
    ----------
    folder : Path

    Returns
    -------
    str
    """
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
            f"the book: {name}",
        )
    return "".join(diffs)


def _text(path: Path) -> str | None:
    """Return the text on disk, line ends included, or None."""
    return path.read_bytes().decode("utf-8") if path.is_file() else None


def _strays(folder: Path, files: dict[str, str]) -> list[Path]:
    """Files that look generated but are not made (any more)."""
    made = {folder / name for name in files}
    kinds = ("numpy/*.py", "casadi/*.py", "c/*.c", "c/*.h", "structure/*.json")
    places = (folder, folder / WITH_EFFECTS)
    found = {path for place in places for kind in kinds for path in place.glob(kind) if path.name != "__init__.py"}
    return sorted(found - made)


def _manifest(files: dict[str, str], models: list[Model]) -> str:
    content = {
        "lines": {model.name: _lines_hash(model) for model in models},
        WITH_EFFECTS: {model.name: texts_digest(whole_library(model)) for model in models},
        "files": {name: hashlib.sha256(text.encode()).hexdigest() for name, text in sorted(files.items())},
    }
    return json.dumps(content, indent=2) + "\n"


@lru_cache(maxsize=16)
def _lines_hash(model: Model) -> str:
    text = "\n".join(f"{line.number} {line.symbol} = {line.expression}" for line in model.lines())
    return hashlib.sha256(text.encode()).hexdigest()
