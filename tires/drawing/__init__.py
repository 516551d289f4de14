"""Figures of a tire (`tire_figures`, written by `files`), and the style that all figures share."""
