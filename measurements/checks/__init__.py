"""Checks of columns, of rows and of whole recordings."""
