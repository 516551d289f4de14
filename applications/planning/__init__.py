"""Test programs of a bench: what a program determines, the program that determines the most, the one that separates."""
