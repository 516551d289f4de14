"""Generator of the recordings, in plain NumPy: it imports nothing of tirefmu, and runs without it.

cd benchmarks/missing_effects && python -m generator --seed 1 -o recordings
"""
