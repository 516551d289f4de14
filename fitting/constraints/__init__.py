"""Physical constraints: definitions, values and derivatives, verification.

Constraints are imposed at the corners of the operating range and verified on a grid four times as dense. From the grid
points with the smallest margins, `local_extrema` minimizes the margin over all inputs, because E_x of a fit exceeded 1
by 0.004 between two loads of the grid. The worst points are added and the stage is solved again until no constraint is
violated by more than 1e-6. Points are never removed. Constraints at neighboring points are almost equal, which IPOPT
does not solve: a damped Gauss-Newton step moves the solution onto the added ones. The bounds of the solver are narrower
by 1.5e-6. Constraints that no free coefficient influences are omitted, because an interior-point solver cannot move
rows of zeros away from a bound. Constraints outside the measured range change the fit within it, and valid tires
violate them: `extrapolation` is enforced on request only.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...boundary.on_demand import on_demand

if TYPE_CHECKING:
    from .constraint_functions import ConstraintFunctions, measured_values
    from .physical import TOLERANCE, Constraint, chosen_constraints, declared_constraints, grid, operating_range
    from .verification import Margin, VerifiedConstraints

__getattr__, __dir__ = on_demand(__name__)
