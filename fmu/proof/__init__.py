"""The proof of an FMU: stimuli, reference values and digests inside it, with which any machine repeats its check."""
