"""Selection of rows by an expression such as ``t > 120 and p in 70..90 kPa``."""
