"""The models as NumPy functions, one module per model."""
