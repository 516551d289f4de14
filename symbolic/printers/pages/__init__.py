"""Equations for pages."""
