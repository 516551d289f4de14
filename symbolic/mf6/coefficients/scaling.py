"""The book's lambda: factors that scale a tire to another road surface or to a similar tire."""

from __future__ import annotations

from ...declarations import Coefficient, Section


def factor(description: str, *, signed: bool = False) -> Coefficient:
    """Declare a scaling factor: 1 has no influence; a factor of a shift or a moment may be zero or negative."""
    return Coefficient(f"scale of {description}", "1", -10.0 if signed else 0.1, 10.0, 1.0)


class Scaling(Section, title="SCALING_COEFFICIENTS", fitted=False):
    """One factor for each physical property."""

    LFZO = factor("the nominal load")
    LCX = factor("the Fx shape factor")
    LMUX = factor("the Fx peak friction")
    LEX = factor("the Fx curvature", signed=True)
    LKX = factor("the longitudinal slip stiffness")
    LHX = factor("the Fx horizontal shift", signed=True)
    LVX = factor("the Fx vertical shift", signed=True)
    LCY = factor("the Fy shape factor")
    LMUY = factor("the Fy peak friction")
    LEY = factor("the Fy curvature", signed=True)
    LKY = factor("the cornering stiffness")
    LKYC = factor("the camber stiffness", signed=True)
    LKZC = factor("the camber torque stiffness", signed=True)
    LHY = factor("the Fy horizontal shift", signed=True)
    LVY = factor("the Fy vertical shift", signed=True)
    LTR = factor("the pneumatic trail", signed=True)
    LRES = factor("the residual moment", signed=True)
    LXAL = factor("alpha's influence on Fx")
    LYKA = factor("kappa's influence on Fy")
    LVYKA = factor("the side force that kappa makes", signed=True)
    LS = factor("the moment arm of Fx", signed=True)
    LMX = factor("the overturning moment", signed=True)
    LVMX = factor("the overturning moment's vertical shift", signed=True)
    LMY = factor("the rolling resistance", signed=True)
    LMP = factor("the parking moment", signed=True)
    LSGKP = factor("MF5.2's relaxation length of kappa")
    LSGAL = factor("MF5.2's relaxation length of alpha")
    LMUV = Coefficient("fall of friction with slip speed (convention book)", "1", -10.0, 10.0)
