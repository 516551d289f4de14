"""Machine-made code, printed from the book by "tirefmu generate"; never edited."""
