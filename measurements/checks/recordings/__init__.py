"""Problems in recordings, and causes of the residual of a fit, as findings of one line each."""
