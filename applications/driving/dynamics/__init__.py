"""What an interval alone does not have of the car: what lags in it, and what no entry of its file explains."""
