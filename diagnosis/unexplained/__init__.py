"""Structure in the residual that no candidate effect explains, and a formula proposed for it."""
