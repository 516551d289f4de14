"""The coefficients of MF5.2, MF6.1 and MF6.2 by .tir section; a model has those that its lines read.

Bounds and starts are in adapted SAE signs (Fy > 0 for alpha > 0). `assumed` is the value that other readers assume if a
file lacks the key: that of the default tire of MFeval 4.3, not 0.
"""

from __future__ import annotations

from . import body, forces, moments, scaling

SECTIONS = (
    body.Model,
    body.Dimension,
    body.Operating,
    body.Vertical,
    body.Structural,
    body.Patch,
    body.PressureRange,
    body.LoadRange,
    body.LongSlipRange,
    body.SlipAngleRange,
    body.InclinationRange,
    scaling.Scaling,
    forces.Longitudinal,
    moments.Overturning,
    forces.Lateral,
    moments.Rolling,
    moments.Aligning,
    moments.TurnSlip,
    body.Transient,
)
