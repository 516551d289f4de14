"""The book printed as code: what is computed, in which language, and the files that are written."""
