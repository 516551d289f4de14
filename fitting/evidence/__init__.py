"""What the data show of a finished fit: residuals, uncertainty, identifiability, consistency."""
