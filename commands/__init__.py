"""Commands of the command line in modules of their own, and the examples in the help of all."""
