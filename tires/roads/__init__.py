"""Roads: a grid of heights, and its files."""
