"""Operating conditions of a recording: levels of the inputs, phases of the test, groups of rows."""
