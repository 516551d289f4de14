"""The book printed as code: the routines, the languages and the files."""
