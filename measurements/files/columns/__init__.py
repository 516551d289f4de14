"""The columns of a file as stored, and what they are: names, units, signs, times and validity."""
