"""Two tires compared: coefficients that differ, error over recordings, figures, a page (`comparison.py`)."""
