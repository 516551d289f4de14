"""What an FMU contains: variables, units, model description, documentation, terminals and icon."""
