"""What each column of a recording means: unit, sign and quantity, from what tires do."""
