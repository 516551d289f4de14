"""Fit of the effect `temperature` to recorded temperatures."""
