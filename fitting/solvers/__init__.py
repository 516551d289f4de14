"""What minimizes the cost of a stage, and what decides whether a point is the optimum."""
