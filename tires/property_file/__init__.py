"""Tire property files (.tir): text to tire and back.

`reading` and `writing` convert a file to a tire and back. `text` has the syntax of the format, `names` and `units` its
names and units, `unit_system` the [UNITS] section of a file, `model_identification` the model of a file. Information
that the format cannot state (the effects, the origin of the tire, the coefficients that were not given) is in the
sections [TIREFMU], [TIREFMU_ABOUT], [TIREFMU_NOT_MEASURED] and [TIREFMU_ASSUMED], which other readers skip.
"""
