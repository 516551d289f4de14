"""States of a tire over time: slips that lag, heat, wear, hysteresis."""
