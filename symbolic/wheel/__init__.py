"""The wheel around a tire: its kinematics at a wheel carrier and a road, equal for all models."""
