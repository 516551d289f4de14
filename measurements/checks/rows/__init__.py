"""Quality of a recording: plausibility, coverage, excluded rows, correlation of residuals."""
