"""The image of a tire on the other side of the vehicle, and a tire without a side."""

from __future__ import annotations

from dataclasses import replace
from typing import TypeVar

import numpy as np

from ...boundary.errors import TireError
from ..definition import RANGES, TireDefinition
from ..evaluation import Conventions, evaluate
from ..signs import MIRRORED

AnyTire = TypeVar("AnyTire", bound=TireDefinition)

OTHER_SIDE = {"left": "right", "right": "left"}
#: Largest difference between the forces of an image and the mirrored forces, relative to the largest force.
EQUAL = 1e-9


def sided(tire: TireDefinition) -> dict[str, float]:
    """Return the coefficients by which left and right differ, without those that are 0.

    >>> from tirefmu.tires import Tire
    >>> sided(Tire("mf61", {"FNOMIN": 4000.0, "UNLOADED_RADIUS": 0.3, "PHY1": 0.01, "PDY2": -0.1}))
    {'PHY1': 0.01}
    """
    declared = tire.symbolic_model.coefficients
    return {name: value for name, value in tire.values.items() if declared[name].sided and value}


def mirrored(tire: AnyTire) -> AnyTire:
    """Return the tire that has the mirrored forces at mirrored inputs: the same tire on the other side of the vehicle.

    Raises `TireError` if an added effect has no image: its coefficients do not state which of them have a side.

    >>> from tirefmu.tires import published
    >>> left = published("trento_hoosier")
    >>> right = mirrored(left)
    >>> right.side, right.values["PHY1"] == -left.values["PHY1"]
    ('right', True)
    """
    values = {name: value for name, value in tire.values.items() if name not in tire.defaulted}
    values |= {name: -value for name, value in sided(tire).items()}
    ranges = dict(tire.ranges)
    for name in MIRRORED & ranges.keys():
        low, high = ranges[name]
        ranges[name] = (0.0 - high, 0.0 - low)
        keys = [key for key in RANGES.get(name, ()) if key in values]
        values |= dict(zip(keys, ranges[name], strict=False))
    image = replace(tire, values=values, ranges=ranges, side=OTHER_SIDE.get(tire.side, tire.side))
    if tire.symbolic_model.added:
        _check_image(tire, image)
    return image


def symmetric(tire: AnyTire) -> AnyTire:
    """Return a tire without a side: the coefficients by which left and right differ are 0.

    >>> from tirefmu.tires import published
    >>> tire = symmetric(published("trento_hoosier"))
    >>> tire.side, sided(tire), abs(float(tire.forces(alpha=0.0)["Fy"]))
    ('symmetric', {}, 0.0)
    """
    values = {name: value for name, value in tire.values.items() if name not in tire.defaulted}
    return replace(tire, values=values | dict.fromkeys(sided(tire), 0.0), side="symmetric")


def _check_image(tire: TireDefinition, image: TireDefinition) -> None:
    import pandas as pd  # here, because every reading of a tire imports this module

    nominal, slips = tire.values["FNOMIN"], np.array([-0.1, -0.02, 0.0, 0.03, 0.12])
    table = pd.DataFrame({"kappa": slips[::-1], "alpha": slips, "gamma": slips / 2.0, "Fz": nominal})
    outputs, signs = list(tire.outputs), tire.signs
    expected = evaluate(tire, table, Conventions(signs, mirror=True, steady=True))[outputs].to_numpy()
    computed = evaluate(image, table, Conventions(signs, steady=True))[outputs].to_numpy()
    if not np.max(np.abs(computed - expected)) <= EQUAL * np.max(np.abs(expected)):
        names = ", ".join(effect.name for effect in tire.symbolic_model.added if effect.name in tire.has)
        raise TireError(f"{tire.name or tire.model}: no mirror image with the added effects {names}")
