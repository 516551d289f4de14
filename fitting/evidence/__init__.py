"""Evidence on the quality of a fit: residuals, uncertainty, identifiability, consistency of the data."""
