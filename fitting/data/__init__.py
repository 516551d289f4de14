"""From recordings to the table of a fit: preprocessed rows, initial values, whether all are of one tire."""
