"""A tire model: its definition, the passes over its lines, its discovery and verification."""

from .definition import INDISPENSABLE, Model
from .lines import reaching

__all__ = ["INDISPENSABLE", "Model", "reaching"]
