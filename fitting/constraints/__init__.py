"""Physical constraints: their catalogue, their values and derivatives, and where they are verified."""
