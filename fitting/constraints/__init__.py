"""Physical constraints: definitions, values and derivatives, verification."""
