"""The vehicle between a log and its tires: a two-track model in the plane with load transfer."""
