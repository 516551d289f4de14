"""Contents of recordings: channels, sweeps, operating conditions, drifts, excluded rows; tables, figures and a page."""
