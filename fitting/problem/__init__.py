"""The least-squares problem of a stage: weighted residuals, loss, regularization, recipes."""
