"""Structure in the residual that no known effect explains, and a formula proposed for it."""
