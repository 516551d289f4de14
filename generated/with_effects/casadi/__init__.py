"""The models as CasADi functions, one module per model."""
