"""Tires of the window: their code and data for the page, and their errors over the measured rows."""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from hashlib import sha256
from typing import Any

import numpy as np
import pandas as pd

from ...boundary.errors import TirefmuError
from ...fitting.options import FitOptions
from ...fitting.problem.influence import generic
from ...fitting.setup import Plan
from ...measurements import OUTPUTS
from ...measurements.nominal_values import NOMINAL
from ...tires import Tire
from ...tires.evaluation import forces as forces_at
from ..explorer.explore import lagged_slips, module_expression, program_for_page
from ..explorer.measured_rows import MeasuredRows, measured_rows, rows_data, sampled
from ..explorer.tire_data import switchable, tire_data
from ..project.project_file import Project
from .data_view import selected_recordings

#: Upper limit of the rows under the curves; of more, a random selection of each condition.
MAX_ROWS = 60_000


@dataclass
class PageTires:
    """Tires as the page takes them.

    - `code`: JavaScript modules by digest; tires of one model with the same effects share one.
    """

    code: dict[str, str] = field(default_factory=dict)

    def of(self, tire: Tire, name: str, intervals: Mapping[str, tuple[float, float]]) -> dict[str, Any]:
        """Return the data of a tire, with the digest of its code.

        `name`: where the tire has none. `intervals`: of its coefficients, in ISO-W.
        """
        tire = tire.in_signs("iso")
        program = program_for_page(switchable(tire))
        module = f"export default {module_expression(program)};\n"
        digest = sha256(module.encode()).hexdigest()[:24]
        self.code[digest] = module
        data = tire_data(tire, name, program.coefficients, intervals, lagged_slips(program))
        del data["file"]  # tires are written by Python
        return data | {"code": digest}


def initial_tire(project: Project) -> Tire:
    """Return the tire that the fit of a project starts from, before the data change it. Raises `TirefmuError`."""
    start = project.get("fit", "start")
    located = None if start is None else project.located(start)
    options = FitOptions(effects=project.get("fit", "effects"), without=project.get("fit", "without", ()))
    plan = Plan.of(project.get("fit", "model"), start if located is None or not located.is_file() else located, options)
    model, given = plan.symbolic_model, plan.start
    nominal = {NOMINAL[name]: value for name, value in project.get("fit", "nominal", {}).items() if name in NOMINAL}
    if given is not None:
        return given
    effects = model.default_effects if options.effects is None else model.known_effects(options.effects)
    values = {name: generic(declaration) for name, declaration in model.coefficients.items() if declaration.fitted}
    standard = {"FNOMIN": 1000.0, "UNLOADED_RADIUS": 0.3}
    return Tire(
        model.name, standard | values | nominal, effects=effects - model.known_effects(options.without),
        signs="adapted-sae", added=model.added,
    )  # fmt: skip


@dataclass(frozen=True)
class Measured:
    """The measured rows under the curves, in ISO-W, by operating condition."""

    conditions: tuple[MeasuredRows, ...]
    total: int
    table: pd.DataFrame

    @classmethod
    def of(cls, project: Project, inputs: Collection[str]) -> Measured:
        """Return the rows of a project's tables. Raises `TirefmuError`."""
        rows = measured_rows(selected_recordings(project, fitted=False), inputs)
        shown = sampled(rows, MAX_ROWS)
        table = pd.concat([condition.table for condition in shown], ignore_index=True) if shown else pd.DataFrame()
        return cls(tuple(shown), sum(len(part.table) for part in rows), table)

    def data(self) -> dict[str, Any]:
        """Return them as JSON values for the page."""
        return rows_data(self.conditions, len(self.table) + 1) | {"total": self.total}

    def errors(self, tire: Tire, condition: int) -> dict[str, Any]:
        """Return RMSE and R2 of each channel over all rows and at a condition, and the residuals at the condition.

        Each row is evaluated at its own inputs, in steady state. Residuals are measured minus computed, base64 texts of
        32-bit floats.
        """
        tire = tire.in_signs("iso")
        present = [name for name in tire.inputs if name in self.table]
        inputs: dict[str, Any] = {name: self.table[name].to_numpy(dtype=np.float64) for name in present}
        forces = forces_at(tire, inputs)
        ends = np.cumsum([0, *(len(condition.table) for condition in self.conditions)])
        selected = slice(*map(int, ends[condition : condition + 2])) if 0 <= condition < len(ends) - 1 else slice(0, 0)
        channels: dict[str, Any] = {}
        for name in (name for name in OUTPUTS if name in self.table and name in tire.outputs):
            measured = self.table[name].to_numpy(dtype=np.float64)
            residual = measured - np.broadcast_to(np.asarray(forces[name]), measured.shape)
            channels[name] = {
                "all": _quality(residual, measured),
                "condition": _quality(residual[selected], measured[selected]),
                "residuals": b64encode(residual[selected].astype("<f4").tobytes()).decode("ascii"),
            }
        return channels


def _quality(residual: np.ndarray[Any, Any], measured: np.ndarray[Any, Any]) -> dict[str, float | int | None]:
    """Return rows, RMSE and R2; None where there is no number."""
    present = np.isfinite(residual)
    squares = float(np.sum(residual[present] ** 2))
    rows = int(present.sum())
    spread = float(np.sum((measured[present] - measured[present].mean()) ** 2)) if rows else 0.0
    return {
        "rows": rows,
        "rmse": (squares / rows) ** 0.5 if rows else None,
        "r2": 1.0 - squares / spread if spread > 0 else None,
    }


def changed_tire(model: str, effects: Collection[str], values: Mapping[str, float], initial: Tire) -> Tire:
    """Return a tire with values of the page, in ISO-W. Raises `TirefmuError` for unknown names."""
    if model != initial.model:
        raise TirefmuError(f"model {initial.model} is shown, not {model!r}")
    return Tire(model, dict(values), effects=effects, signs="iso", added=initial.added)
