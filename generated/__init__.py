"""Machine-made code, printed from the equations by "tirefmu generate"; never edited."""
