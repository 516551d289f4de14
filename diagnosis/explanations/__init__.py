"""How probable each explanation of a recording is: explanations refitted and compared under one score."""
