"""A preprocessed recording: its signals, its own disturbances, and a tire simulated over it."""
