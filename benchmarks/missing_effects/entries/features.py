"""Responses of a tire's forces to effects in their simplest form, at the fitted baseline model."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from tirefmu.fitting import fit
from tirefmu.tires import Tire

from ..answers import Case, FloatArray

ByChannel = dict[str, FloatArray]
#: Scales of the tire whose derivatives are the directions of friction, stiffness, trail and curvature.
SCALES = {"mu": ("LMUX", "LMUY"), "K": ("LKX", "LKY"), "K_y": ("LKY",), "trail": ("LTR",), "E": ("LEX", "LEY")}
STEP = 1e-3


def fitted_baseline(case: Case) -> tuple[Tire, list[str]]:
    """Return the baseline model, fitted to the recording, and its free coefficients."""
    result = fit(case.recording, "mf61", effects=case.about["base"], nominal=case.about["nominal"])
    return result.tire, list(result.covariance.columns)


def forces_of(tire: Tire, x: Mapping[str, FloatArray]) -> ByChannel:
    """Return Fx, Fy and Mz of a tire in steady state."""
    inputs: dict[str, Any] = {name: x[name] for name in tire.inputs if name in x}
    computed = tire.forces(**inputs)
    return {name: np.asarray(computed[name]) for name in ("Fx", "Fy", "Mz")}


def tire_responses(
    case: Case, x: Mapping[str, FloatArray]
) -> tuple[ByChannel, ByChannel, dict[str, dict[str, list[FloatArray]]]]:
    """Return forces, derivatives by coefficients, shape (n, k), by channel, and responses by candidate and channel.

    A coefficient counts in the first channel that it changes: the moment does not determine those of the forces.
    """
    tire, free = fitted_baseline(case)
    forces = forces_of(tire, x)

    def change(moved: Tire, size: float, at: Mapping[str, FloatArray] = x) -> ByChannel:
        computed = forces_of(moved, at)
        return {channel: (computed[channel] - force) / size for channel, force in forces.items()}

    steps = {name: STEP * max(abs(tire.values[name]), 0.1) for name in free}
    derivatives = [change(tire.with_values(**{name: tire.values[name] + step}), step) for name, step in steps.items()]
    first = [next(channel for channel in forces if np.any(one[channel])) for one in derivatives]
    pairs = list(zip(derivatives, first, strict=True))
    base = {channel: np.stack([one[channel] for one, its in pairs if its == channel], axis=1) for channel in forces}
    along = {name: change(tire.with_values(**dict.fromkeys(scales, 1.0 + STEP)), STEP)
             for name, scales in SCALES.items()}  # fmt: skip
    for slip in ("alpha", "kappa"):
        along[slip] = change(tire, 1e-4, {**x, slip: x[slip] + 1e-4})
    return forces, base, _responses(case, x, forces, along)


def _responses(
    case: Case, x: Mapping[str, FloatArray], forces: ByChannel, along: Mapping[str, ByChannel]
) -> dict[str, dict[str, list[FloatArray]]]:
    nominal, n = case.about["nominal"], len(case.recording)
    slip, radius, warm = np.tan(x["alpha"]), nominal["R0"], x["T"] - np.mean(x["T"][:n])
    load, pressure, speed = (x[name] / nominal[key] - 1.0 for name, key in (("Fz", "Fz0"), ("p", "p0"), ("V", "V0")))
    parts = slice(None, n), slice(n, None)
    distance = np.concatenate([np.cumsum(x["V"][one] * np.gradient(x["t"][one])) for one in parts]) / 1000.0
    delay = {name: np.concatenate([np.gradient(x[name][one], x["t"][one]) for one in parts]) / x["V"]
             for name in ("alpha", "kappa")}  # fmt: skip
    spin, sign = radius * np.abs(x["phit"]), np.sign(x["alpha"])

    def at(direction: str, factor: FloatArray, *only: str) -> dict[str, list[FloatArray]]:
        return {name: [one * factor] for name, one in along[direction].items() if not only or name in only}

    found = {
        "camber_thrust": {"Fy": [x["Fz"] * x["gamma"]]}, "camber_stiffness": at("K_y", np.abs(x["gamma"])),
        "camber_friction": at("mu", x["gamma"] ** 2), "load_friction": at("mu", load),
        "load_stiffness": at("K_y", load), "load_curvature": at("E", load), "pressure_friction": at("mu", pressure),
        "pressure_stiffness": at("K", pressure), "combined_Gxa": {"Fx": [forces["Fx"] * slip**2]},
        "combined_Gyk": {name: [forces[name] * x["kappa"] ** 2] for name in ("Fy", "Mz")},
        "kappa_sideforce_SVyk": {"Fy": [x["Fz"] * np.tanh(x["kappa"] / 0.05)]},
        "plysteer": at("alpha", np.ones_like(load)), "conicity": {"Fy": [x["Fz"]]}, "curvature_asym": at("E", sign),
        "temp_friction": at("mu", warm), "temp_stiffness": at("K", warm), "speed_friction": at("mu", speed),
        "wear_drift": at("mu", distance), "trail_load": at("trail", load, "Mz"),
        "residual_torque_Mzr": {"Mz": [radius * x["Fz"] / (1.0 + (10.0 * slip) ** 2)]},
        "Mz_from_Fx": {"Mz": [radius * forces["Fx"]]}, "turn_slip": at("K_y", spin),
        "relax_lat": at("alpha", delay["alpha"]), "relax_load": at("alpha", load * delay["alpha"]),
        "relax_lon": at("kappa", delay["kappa"]),
    }  # fmt: skip
    return {name: found[name] for name in case.about["candidates"]}
