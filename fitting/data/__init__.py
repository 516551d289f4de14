"""Data of a fit: preprocessed rows, initial values, test whether recordings are of one tire."""
