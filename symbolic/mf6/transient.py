"""Transient slip: relaxation over the rolled distance, d x/dt = |V| / sigma (u - x) on tan(alpha) and kappa.

The lagged x replaces the slip in every other line. sigma is constant, changes with load, or is a length of the Magic
Formula; 0 means without delay. The update over a step is in `tirefmu.tires.states.transient`.
"""

from __future__ import annotations

from ..effects import relax_lat, relax_load, relax_lon, relax_mf
from ..notation import Chapter
from .coefficients.body import Transient as c
from .normalized import dfz
from .relaxation import sigmax, sigmay

eq = Chapter("Transient slip")

# fmt: off
sigma_lon = eq("tirefmu", "sigma_kappa",
               relax_lon.term(c.SIGX) + relax_mf.term(c.SIGK * sigmax),
               "m", "relaxation length that acts on kappa")
sigma_lat = eq("tirefmu", "sigma_alpha",
               relax_load.either(c.SIGY * (1 + c.SIGC*dfz), relax_lat.term(c.SIGY)) + relax_mf.term(c.SIGK * sigmay),
               "m", "relaxation length that acts on tan(alpha)")
