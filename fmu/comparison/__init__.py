"""How the outputs of an FMU compare with a recording and with direct evaluation of its tire."""
