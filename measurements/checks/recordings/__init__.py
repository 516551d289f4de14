"""What recordings lack or contradict, and what the residual of a fit still shows, as findings of one line each."""
