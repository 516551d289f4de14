"""The models of the package: every folder of `tirefmu.symbolic` that has `MODELS`."""

from __future__ import annotations

from importlib import import_module
from pkgutil import iter_modules

from tirefmu.boundary.errors import ModelError

from .definition import Model


def found_models() -> dict[str, Model]:
    """Return the models of all folders that have them, by name and in the order of their names.

    Raises `ModelError` if two have one name or one FITTYP.
    """
    package = __name__.rsplit(".", 2)[0]  # tirefmu.symbolic
    folders = [found.name for found in iter_modules(import_module(package).__path__) if found.ispkg]
    models: dict[str, Model] = {}
    for folder in folders:
        for model in getattr(import_module(f"{package}.{folder}"), "MODELS", ()):
            register(model, models)
    return dict(sorted(models.items()))


def register(model: Model, models: dict[str, Model]) -> None:
    """Add a model to others.

    `models`: changed. Raises `ModelError` if its name is not a lower-case word, or the name or FITTYP is in use.
    """
    if not (model.name.isidentifier() and model.name == model.name.lower()):
        raise ModelError(f"model {model.name!r}: a name is a word of lower-case letters, digits and _")
    if model.name in models:
        raise ModelError(f"model {model.name!r} is there twice")
    for other in models.values():
        for number in sorted(set(model.property_file.fittyp) & set(other.property_file.fittyp)):
            raise ModelError(f"model {model.name!r}: FITTYP {number} is {other.name}'s")
    models[model.name] = model
