"""Where a fitted tire and its data disagree, and which effect is missing."""

from .residual_map import Bin, ResidualMap, draw_residual_maps, residual_map

__all__ = ["Bin", "ResidualMap", "draw_residual_maps", "residual_map"]
