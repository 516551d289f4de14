"""No right table of a published tire is refused: what it grips is what tires do."""

import numpy as np
import pandas as pd
import pytest

from tirefmu.measurements import Recording, check_columns
from tirefmu.measurements.catalogue import published as names
from tirefmu.tires import convert_signs, published

#: What a recording lacks: sweeps of kappa, of alpha, all camber but 0, a moment.
LACKS = {"nothing": (), "kappa": ("Fx",), "alpha": ("Fy", "Mz"), "camber": (), "Mz": ("Mz",)}


def recorded(tire, lacks):
    """Return sweeps of both slips at three loads and three camber angles, in ISO, with 1 % of noise."""
    slip, nominal = 0.2 * np.sin(np.linspace(0.0, 4.0 * np.pi, 300)), tire.values["FNOMIN"]
    sweeps = [
        {"alpha": 0.0, "kappa": 0.0, swept: slip, "gamma": gamma, "Fz": load * nominal}
        for load in (0.5, 1.0, 1.5)
        for gamma in ((0.0,) if lacks == "camber" else (-0.05, 0.0, 0.05))
        for swept in {"alpha", "kappa"} - {lacks}
    ]
    inputs = pd.concat([pd.DataFrame(each) for each in sweeps], ignore_index=True)
    inputs = inputs.assign(V=11.2, p=tire.values.get("NOMPRES", 96e3))
    rng = np.random.default_rng(0)
    forces = tire.evaluate(inputs, signs="iso")[[name for name in tire.outputs if name not in LACKS[lacks]]]
    forces = forces.loc[:, forces.abs().max() > 0.0]
    noisy = forces + rng.normal(0.0, 0.01, forces.shape) * forces.abs().max().to_numpy()
    return inputs.assign(t=0.02 * np.arange(len(inputs)), **noisy)


@pytest.mark.parametrize("signs", ["iso", "adapted-sae", "sae"])
@pytest.mark.parametrize("lacks", LACKS)
@pytest.mark.parametrize("name", names())
def test_a_right_table_is_not_refused(name, lacks, signs):
    table = recorded(published(name).in_signs("iso"), lacks)
    check_columns(Recording(convert_signs(table, "iso", signs), signs, name))
