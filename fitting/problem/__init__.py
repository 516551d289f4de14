"""The least-squares problem of a stage: weighted residuals, loss, regularization, and the recipe that chooses it."""
