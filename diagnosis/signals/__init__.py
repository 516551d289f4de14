"""The preprocessed recording: signals, disturbances, measurement artefacts, and simulation of a tire over it."""
