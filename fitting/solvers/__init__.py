"""Solvers of a stage, convergence criterion, restarts, and interruption."""
