"""The evaluation of a tire: forces at given inputs, and a table's forces, quantities and transient slip."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from ..boundary.errors import DataError
from ..symbolic.model import Model
from .code import Code, code_for, fastest_code
from .definition import TireDefinition
from .forces import Forces
from .signs import MIRRORED, TABLE_INPUTS, convert_signs, reversed_columns
from .states.equilibrium import equilibrium
from .states.simulation import StateSimulation
from .states.transient import Course, lagged_course, lateral_slip, rolled_distance, with_pauses

if TYPE_CHECKING:
    import pandas as pd

FloatArray = npt.NDArray[np.float64]


@dataclass(frozen=True)
class Conventions:
    """Conventions of a table and of the evaluation; `Tire.evaluate` documents each."""

    signs: str = "iso"
    convention: str = "tno"
    slip_angle: str = "tan"
    limits: bool = False
    mirror: bool = False
    steady: bool = False
    hold: bool = False

    @property
    def formula(self) -> str:
        """The convention in which the plain formula is evaluated."""
        reversed_columns(self.signs, "iso")  # an unknown convention is an error before anything is computed
        return "iso" if self.signs == "iso" else "adapted-sae"

    @property
    def options(self) -> dict[str, str]:
        """The options of the lines, by name."""
        return {
            "convention": self.convention,
            "slip_angle": self.slip_angle,
            "limits": "on" if self.limits else "off",
        }


def forces(tire: TireDefinition, inputs: Mapping[str, npt.ArrayLike], code: str = "auto") -> Forces:
    """Return forces and moments in the tire's own signs, in steady state; `Tire.forces` documents the parameters."""
    rows, shape = _broadcast(tire, inputs)
    chosen, parameters = _code(tire.symbolic_model, code, rows.shape[1]), tire.parameters()
    results = chosen.forces(equilibrium(tire.symbolic_model, chosen, rows, parameters, tire.states), parameters)
    return Forces({name: row.reshape(shape) for name, row in zip(tire.outputs, results, strict=True)})


def forces_over_time(
    tire: TireDefinition, t: FloatArray, inputs: Mapping[str, FloatArray], tolerance: float
) -> FloatArray:
    """Return the forces in the tire's own signs over times with lagged slips and states, shape (n_outputs, n).

    What `evaluate` does, in a tenth of its time and less exact: forces that drive states are linear between rows, and
    the states are iterated until they change by less than `tolerance`, as a share of their largest value.

    `t`, shape (n,): s; where it goes backward, a new recording begins. `inputs`, shape (n,): by name, SI.

    >>> from tirefmu.tires import published
    >>> t, slips = np.arange(3.0), {"alpha": np.array([0.0, 0.02, 0.04]), "Fz": np.full(3, 1000.0)}
    >>> forces_over_time(published("trento_hoosier"), t, slips, 1e-5)[1].round(-1).tolist()
    [90.0, 760.0, 1250.0]
    """
    rows, _ = _broadcast(tire, inputs)
    code, parameters = _code(tire.symbolic_model, "auto", rows.shape[1]), tire.parameters()
    if tire.lags or tire.states:
        slips = _lagging(tire, t, rows, parameters, code) if tire.lags else {}
        simulation = StateSimulation(tire.symbolic_model, code, t, rows, parameters, False, slips, tire.states)
        rows = simulation.acting_with_linear_forces({}, tolerance)
    return code.forces(rows, parameters)


def quantities(tire: TireDefinition, inputs: Mapping[str, npt.ArrayLike]) -> dict[str, FloatArray]:
    """Return the named quantities in the tire's own signs, in steady state, by name; `inputs` as for `forces`.

    >>> from tirefmu.tires import published
    >>> quantities(published("trento_hoosier"), {"Fz": [500.0, 1000.0]})["mu_y"].round(2)
    array([2.61, 2.42])
    """
    rows, shape = _broadcast(tire, inputs)
    code, parameters = _code(tire.symbolic_model, "auto", rows.shape[1]), tire.parameters()
    results = code.quantities(equilibrium(tire.symbolic_model, code, rows, parameters, tire.states), parameters)
    return {name: row.reshape(shape) for name, row in zip(code.quantities_names, results, strict=True)}


def _broadcast(tire: TireDefinition, inputs: Mapping[str, npt.ArrayLike]) -> tuple[FloatArray, tuple[int, ...]]:
    """Return rows of the model's inputs, without those that request an absent effect, and the shape of the inputs."""
    columns = [np.asarray(inputs.get(name, tire.nominal(name)), dtype=np.float64) for name in tire.inputs]
    shape = np.broadcast_shapes(*(column.shape for column in columns))
    rows = np.stack([np.broadcast_to(column, shape).ravel() for column in columns])
    return tire.effective_inputs(rows), shape


def evaluate(
    tire: TireDefinition, table: pd.DataFrame, conventions: Conventions, language: str = "auto"
) -> pd.DataFrame:
    """Return forces and named quantities for each row of a table, together with its input columns.

    `tire`: in any signs. `table`: input columns in SI units. `conventions`: signs of the table and options of the
    formula. `language`: which generated code evaluates; "auto": the fastest for the number of rows. Returns: with the
    table's index. Raises `DataError` if an input is NaN or infinite.
    """
    import pandas as pd  # here, because `forces` does not need it

    tire = tire.in_signs(conventions.formula)
    code = _code(tire.symbolic_model, language, len(table))
    parameters = tire.parameters(**conventions.options)
    columns, rows = _inputs(tire, table, conventions)
    rows = _turned(rows, tire.inputs, conventions.mirror)
    seen, lags = _acting(tire, table, rows, parameters, conventions, code)
    outputs = _turned(code.forces(seen, parameters), tire.outputs, conventions.mirror)
    back = dict(zip(tire.inputs, _turned(seen, tire.inputs, conventions.mirror), strict=True))
    columns |= {name: pd.Series(back[name], table.index) for name in tire.symbolic_model.states}
    quantities = dict(zip(code.quantities_names, code.quantities(seen, parameters), strict=True))
    given = table[[name for name in TABLE_INPUTS if name in table]]
    absent = {name: columns[name] for name in tire.inputs if name not in table or name in tire.symbolic_model.states}
    lag = {f"{name}_lagged": convert_signs(pd.DataFrame({name: back[name]}), conventions.formula, conventions.signs)
           [name].to_numpy() for name in lags}  # fmt: skip
    computed = {**absent, **dict(zip(tire.outputs, outputs, strict=True))}
    written = convert_signs(pd.DataFrame(computed, table.index), conventions.formula, conventions.signs)
    return pd.concat([given, written, pd.DataFrame({**lag, **quantities}, table.index)], axis=1)


def _code(model: Model, language: str, n_rows: int) -> Code:
    return fastest_code(model, n_rows) if language == "auto" else code_for(model, language)


def _inputs(
    tire: TireDefinition, table: pd.DataFrame, conventions: Conventions
) -> tuple[dict[str, pd.Series[float]], FloatArray]:
    """Return the model's inputs by name, and as finite rows without inputs that request an absent effect."""
    import pandas as pd

    given = convert_signs(table, conventions.signs, conventions.formula)
    if "distance" in tire.inputs and "distance" not in given and {"t", "V"} <= set(given):
        t, speed = _finite(given["t"], "t"), _finite(given["V"], "V")
        given = given.assign(distance=rolled_distance(t, speed, hold=conventions.hold))
    columns = {name: given.get(name, pd.Series(tire.nominal(name), table.index)) for name in tire.inputs}
    rows = tire.effective_inputs(np.stack([_finite(column, name) for name, column in columns.items()]))
    in_the_lines = any(option.name == "limits" for option in tire.symbolic_model.options)
    if conventions.limits and not in_the_lines:
        bounds = np.array([tire.ranges.get(name, (-np.inf, np.inf)) for name in tire.inputs])
        load = tire.inputs.index("Fz")
        lifted = rows[load] <= 0  # and remains so when clipped
        rows = np.clip(rows, bounds[:, :1], bounds[:, 1:])
        rows[load, lifted] = 0.0
    return columns, rows


def _acting(
    tire: TireDefinition,
    table: pd.DataFrame,
    rows: FloatArray,
    parameters: FloatArray,
    conventions: Conventions,
    code: Code,
) -> tuple[FloatArray, tuple[str, ...]]:
    """Return the acting inputs, with states and lagged slips, and the names of the slips that lag."""
    if "t" not in table or conventions.steady:
        return equilibrium(tire.symbolic_model, code, rows, parameters, tire.states), ()
    if not tire.lags and not tire.states:
        return rows, ()
    t, hold = _finite(table["t"], "t"), conventions.hold
    given = np.arange(len(t))
    if not hold and any(tire.symbolic_model.states[name].is_temperature for name in tire.states):
        t, rows, given = with_pauses(t, rows, [tire.inputs.index(name) for name in ("kappa", "alpha")])
    slips = _lagging(tire, t, rows, parameters, code, hold) if tire.lags else {}
    fitted = [name for name in tire.states if tire.symbolic_model.states[name].start_is_fitted and name in table]
    starts = {name: rows[tire.inputs.index(name)] for name in fitted}
    simulation = StateSimulation(tire.symbolic_model, code, t, rows, parameters, hold, slips, tire.states, starts)
    return simulation.acting()[:, given], tuple(slips)


def _lagging(
    tire: TireDefinition, t: FloatArray, rows: FloatArray, parameters: FloatArray, code: Code, hold: bool = False
) -> dict[str, Course]:
    """Return the time histories of the slips, by input."""
    named = dict(zip(tire.inputs, rows, strict=True))
    along, across = code.relaxation(rows, parameters)
    return {
        "kappa": lagged_course(t, named["kappa"], named["V"], along, hold=hold),
        "alpha": lagged_course(t, lateral_slip(named["alpha"]), named["V"], across, hold=hold),
    }


def _turned(rows: FloatArray, names: Collection[str], mirror: bool) -> FloatArray:
    """Return rows of inputs or outputs, mirrored in the wheel plane or unchanged."""
    sign = np.array([-1.0 if mirror and name in MIRRORED else 1.0 for name in names])
    return sign[:, None] * rows


def _finite(column: pd.Series[float], name: str) -> FloatArray:
    """Return an input column as an array, or report its first row without a finite number."""
    values = np.asarray(column, dtype=np.float64)
    bad = np.flatnonzero(~np.isfinite(values))
    if bad.size:
        what = "NaN" if np.isnan(values[bad[0]]) else "infinite"
        raise DataError(f"row {bad[0] + 1}: {name} is {what} ({bad.size} of {len(values)} rows)")
    return values
