"""Figures as data, the frame and style of pages, charts."""
