"""A project file: which data, fit, export and checks belong together, and the run that redoes what has changed."""
