"""One offline page for a tire: sliders, curves, measured points, computed by the tire's JavaScript (`explore.py`)."""
