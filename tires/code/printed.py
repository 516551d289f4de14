"""Location of the code of a model: in the package, or printed once and stored by content.

The package has the files that `generated/MANIFEST.json` lists: in a clone the forces, operations and structure of each
model, in a wheel also the Jacobians, the kernels and the models with the whole library of effects. Code that the
package lacks is printed into the cache at first use. This includes models with other effects and models that a program
registers. The name of an entry contains a digest of the equations, the printers and the effects: after a change of one
of them the code is printed again.
"""

from __future__ import annotations

import hashlib
import json
import py_compile
from collections.abc import Sequence
from functools import lru_cache
from importlib.resources import files
from importlib.util import MAGIC_NUMBER
from pathlib import Path
from typing import Any

from ...boundary.errors import TirefmuError
from ...symbolic.added import AddedEffect, texts_digest
from ...symbolic.model import Model
from ...symbolic.models import MODELS, WITH_EFFECTS, model_named
from .build_cache import cached, intact_entry

#: Extensions of the files of `symbolic` that determine the printed code.
SOURCES = (".py", ".toml", ".h")


def model_with(name: str, added: Sequence[AddedEffect] = ()) -> Model:
    """Return a model by its name, with effects in its lines.

    If its code has been generated before, its structure is read from there, without loading equations.

    Equal arguments return the same object. Raises `UnknownName`, `EffectError`: as
    `tirefmu.symbolic.models.model`.
    """
    return model_named(name, added, find=_printed_structure)


def code_file(model: Model, name: str) -> Path:
    """Return a file of a model's code, printed if it is missing.

    `name`: relative to the folder of all code, such as "c/mf61_jacobians.c". Returns: headers that it includes are in
    the same folder. Raises `ModelError` if the model violates its declarations. Raises `TirefmuError` if the code
    cannot be written.
    """
    packaged = packaged_file(model, name)
    if packaged:
        return Path(str(files("tirefmu.generated"))) / packaged
    return printed_folder(model, jacobians="_jacobian" in name) / name


def packaged_file(model: Model, name: str) -> str:
    """Return the path of a file of a model's code below `generated/`, or "" if the package does not have it."""
    if model.stored is None:  # changed, or with effects for which nothing was printed
        return ""
    path = f"{WITH_EFFECTS}/{name}" if model.added else name
    if model.added and _manifest()[WITH_EFFECTS].get(model.name) != texts_digest(model.added):
        return ""
    return path if path in _manifest()["files"] else ""


def printed_folder(model: Model, *, jacobians: bool = False) -> Path:
    """Return the folder of a printed model; print the model if the folder does not exist.

    `jacobians`: the folder of its Jacobians, most of the text, which a fit needs and a simulation does not. The folder
    contains numpy/, c/ and structure/, and the Python files compiled. Raises `ModelError` if the model
    violates its declarations. Raises `TirefmuError` if it cannot be written.
    """

    def write(folder: Path) -> None:
        for name, text in _render(model, jacobians).items():
            path = folder / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="ascii", newline="\n")
            if path.suffix == ".py":
                compiled = path.with_suffix(".pyc")
                py_compile.compile(str(path), cfile=str(compiled), dfile=name, doraise=True)

    try:
        return cached(_entry_of(model) + "-jacobians" * jacobians, write)
    except OSError as error:
        raise TirefmuError(f"the code of {model.name} cannot be written ({error.strerror or error})") from error


@lru_cache(maxsize=1)
def sources_digest() -> str:
    """Return the SHA-256 digest of all equations, effects and printers."""
    folder = Path(str(files("tirefmu.symbolic")))
    digest = hashlib.sha256()
    for path in sorted(path for path in folder.rglob("*") if path.suffix in SOURCES):
        digest.update(path.relative_to(folder).as_posix().encode() + b"\0" + path.read_bytes() + b"\0")
    return digest.hexdigest()


@lru_cache(maxsize=1)
def _manifest() -> dict[str, Any]:
    """Return the contents of the package: `lines` by model, `WITH_EFFECTS` by model, `files` by path."""
    text = (files("tirefmu.generated") / "MANIFEST.json").read_text(encoding="ascii")
    content: dict[str, Any] = json.loads(text)
    return content


@lru_cache(maxsize=64)
def _entry_of(model: Model) -> str:
    """Return the name of the cache's entry for a model."""
    declared = (
        (*model.equations, *model.coefficients.values(), model.roles) if model.name not in _manifest()["lines"] else ()
    )
    return _entry(model.name, model.added, "\0".join(map(repr, declared)))


def _entry(name: str, added: Sequence[AddedEffect], declared: str = "") -> str:
    content = "\0".join([sources_digest(), MAGIC_NUMBER.hex(), texts_digest(added), declared])
    return f"{name}-{hashlib.sha256(content.encode()).hexdigest()[:24]}"


def _printed_structure(name: str, added: Sequence[AddedEffect]) -> Path | None:
    """Return the stored structure of a model with effects if its code has been printed before."""
    folder = intact_entry(_entry(name, added)) if MODELS[name].stored is not None else None
    return folder / "structure" / f"{name}.json" if folder else None


def _render(model: Model, jacobians: bool) -> dict[str, str]:
    from ...symbolic.printers.generate import render_jacobians, render_values  # SymPy's printers load slowly

    return render_jacobians(model) if jacobians else render_values(model)
