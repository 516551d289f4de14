"""The models: those of every folder of `tirefmu.symbolic` that has `MODELS`, and of other installed packages."""

from __future__ import annotations

from importlib import import_module
from pkgutil import iter_modules

from ...boundary.errors import ModelError
from ...boundary.plugins import described, loaded, plugins
from .definition import Model


def found_models() -> dict[str, Model]:
    """Return the models of this package and of others, by name and in the order of their names.

    Entry points of the group ``tirefmu.models`` name tuples of models. Raises `ModelError` if one is no model, or two
    have one name or one FITTYP.
    """
    models = packaged_models()
    for entry in plugins("models"):
        for model in loaded(entry):
            if not isinstance(model, Model):
                raise ModelError(f"{described(entry)}: {type(model).__name__} is no Model")
            register(model, models)
    return dict(sorted(models.items()))


def packaged_models() -> dict[str, Model]:
    """Return the models of this package's folders, by name."""
    package = __name__.rsplit(".", 2)[0]  # tirefmu.symbolic
    folders = [module.name for module in iter_modules(import_module(package).__path__) if module.ispkg]
    models: dict[str, Model] = {}
    for folder in folders:
        for model in getattr(import_module(f"{package}.{folder}"), "MODELS", ()):
            register(model, models)
    return models


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
