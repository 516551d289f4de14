"""Output of a diagnosis: the HTML report, figures of residuals, comparison of the FMUs with the recording."""
