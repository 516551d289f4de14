"""The effects that a tire model has or lacks, by their public names.

Where an effect acts stands in the chapters (``effect.term``, ``effect.factor``, ``effect.either``).
"""

from __future__ import annotations

from .notation import Effect

#: PKY2 of a tire whose cornering stiffness is proportional to load, in a file for readers without switches:
#: sin(2 atan(Fz / (PKY2 Fz0))) is then 2 Fz / (PKY2 Fz0) to 1e-12.
PROPORTIONAL_PKY2 = 1e6

load_friction = Effect("load_friction", "friction changes with load")
load_stiffness = Effect(
    "load_stiffness",
    "slip stiffness is not proportional to load: cornering stiffness saturates",
    rescales=(("PKY1", PROPORTIONAL_PKY2 / 2),),
)
load_curvature = Effect("load_curvature", "the curvature factor changes with load")
camber_thrust = Effect("camber_thrust", "inclination makes a side force without slip")
camber_stiffness = Effect("camber_stiffness", "inclination changes the cornering stiffness")
camber_friction = Effect("camber_friction", "inclination lowers friction")
camber_curvature = Effect("camber_curvature", "inclination bends the side force curve")
camber_trail = Effect("camber_trail", "inclination changes the pneumatic trail")
plysteer = Effect("plysteer", "the plies steer: a side force that reverses with the rolling direction")
conicity = Effect("conicity", "the tire is a cone: a side force that does not reverse")
longitudinal_shift = Effect("longitudinal_shift", "the longitudinal force curve misses the origin")
curvature_asym = Effect("curvature_asym", "the two branches of a force curve bend differently")
combined_Gxa = Effect("combined_Gxa", "side slip takes from the longitudinal force")
combined_Gyk = Effect("combined_Gyk", "longitudinal slip takes from the side force")
kappa_sideforce_SVyk = Effect("kappa_sideforce_SVyk", "longitudinal slip makes a side force of its own")
residual_torque_Mzr = Effect("residual_torque_Mzr", "a moment remains that no side force explains")
trail_load = Effect("trail_load", "the pneumatic trail is not proportional to load")
trail_curvature = Effect("trail_curvature", "the trail falls faster or slower than a plain cosine form")
trail_shift = Effect("trail_shift", "the trail has its top beside zero slip")
camber_stiffness_load = Effect("camber_stiffness_load", "inclination moves the load of the highest cornering stiffness")
camber_combined = Effect("camber_combined", "inclination changes how slips share the friction")
camber_torque = Effect("camber_torque", "inclination makes a moment without slip")
pressure_stiffness = Effect("pressure_stiffness", "inflation pressure changes the slip and camber stiffness")
pressure_friction = Effect("pressure_friction", "inflation pressure changes friction")
pressure_trail = Effect("pressure_trail", "inflation pressure changes the pneumatic trail")
pressure_moment = Effect("pressure_moment", "inflation pressure changes M_x, M_y and the camber torque")
residual_stiffness = Effect("residual_stiffness", "the residual moment fades with slip in its own way")
overturning_Mx = Effect("overturning_Mx", "load and side force make an overturning moment")
rolling_resistance_My = Effect("rolling_resistance_My", "the tire resists rolling")
turn_slip = Effect("turn_slip", "a turning contact patch takes from the forces and makes a moment")
relax_lat = Effect("relax_lat", "the side slip acts after a rolled distance", optional=True)
relax_lon = Effect("relax_lon", "the longitudinal slip acts after a rolled distance", optional=True)
relax_load = Effect("relax_load", "the side slip acts after a rolled distance that changes with load", optional=True)
relax_mf = Effect("relax_mf", "slips act after the Magic Formula's own relaxation lengths", optional=True)
Mz_from_Fx = Effect("Mz_from_Fx", "the longitudinal force acts beside the wheel plane")

#: Every effect of the book by its public name.
EFFECTS: dict[str, Effect] = {effect.name: effect for effect in vars().copy().values() if isinstance(effect, Effect)}
