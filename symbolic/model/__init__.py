"""A tire model: its definition, the passes over its lines, its discovery and verification."""

from .declaration import Source
from .definition import INDISPENSABLE, Model

__all__ = ["INDISPENSABLE", "Model", "Source"]
