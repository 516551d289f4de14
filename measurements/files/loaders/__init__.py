"""Loaders of logs by libraries, one for each format; the reading process runs them without tirefmu.

``load(path)`` returns the channels of numbers, and the names of the others. A channel is a tuple of name, unit, group,
times in s or None, samples, invalid samples or None, and what its samples are at if it is not time.
"""
