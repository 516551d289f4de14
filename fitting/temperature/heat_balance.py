"""The heat balance of a tire over a recording: its states as a linear system, and their time histories.

The derivative of the temperatures is A x + b: conductances and heat capacities are in A, heat and surroundings in b.
The generated code of the states gives both, so their formulas exist in the effect file only. Forces do not depend on
temperatures that are predicted here (`unaffected`). Rows are averaged over `BLOCK`: b, with the product of force and
sliding speed, is averaged itself, as the mean of a product is not the product of means.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from ...measurements import Recording
from ...numerics.arrays import FloatArray, IndexArray
from ...tires.code import fastest_code
from ...tires.states.transient import exchange, held_system, vector_recursion, with_pauses
from ...tires.tire import Tire
from ..problem.rows import inputs_of

#: Prior mean and standard deviation of the delay of the sensor, s.
DELAY, DELAY_SPREAD = 0.1, 0.1
#: The effect whose states are temperatures.
EFFECT = "temperature"
#: Its heat capacities, in the order of the states.
CAPACITIES = ("THCAPS", "THCAPB", "THCAPC", "THCAPG")
#: Duration of a block, and the longest step in a pause, s.
BLOCK, PAUSE_STEP = 0.1, 0.5
#: Rows of a block at which heat is computed.
BLOCK_ROWS = 5
ZERO_CELSIUS = 273.15


def unaffected(tire: Tire) -> Tire:
    """Return the tire with forces that do not depend on the predicted temperature."""
    return tire.with_values(THACT=0.0) if tire.values["THACT"] else tire


@dataclass(frozen=True)
class HeatBalance:
    """The inputs of a heat balance over a recording.

    - `tire`: with the effect `temperature`, in adapted SAE signs.
    - `t`, shape (n,): time of the nodes: the blocks, and steps in pauses, s.
    - `rows`, shape (n_inputs, n_rows): recorded inputs; `block`, shape (n_rows,): the node of each.
    - `inputs`, shape (n_inputs, n): inputs at nodes; in a pause the tire rolls without slip.
    - `measured`, shape (n,): mean recorded temperature, K; NaN in pauses.
    - `source`: name of the recording.
    """

    tire: Tire
    t: FloatArray
    rows: FloatArray
    block: IndexArray
    inputs: FloatArray
    measured: FloatArray
    source: str

    @classmethod
    def of(cls, tire: Tire, recording: Recording, column: str) -> HeatBalance:
        """Return the heat balance of a recording with time and a recorded temperature in deg C."""
        tire = unaffected(tire).in_signs("adapted-sae")
        table = recording.with_signs("adapted-sae").table
        complete = table[[name for name in ("t", column, *tire.inputs) if name in table]].notna().all(axis=1)
        table = table[complete & (table["t"].diff().fillna(1.0) > 0.0)]
        rows = inputs_of(table, tire)
        slips = [tire.inputs.index(name) for name in ("kappa", "alpha")]
        time, rows, given = with_pauses(table["t"].to_numpy(dtype=np.float64), rows, slips)
        recorded = np.full(len(time), np.nan)
        recorded[given] = table[column].to_numpy(dtype=np.float64) + ZERO_CELSIUS
        # The rows at the ends of a pause are nodes of their own, since heat jumps there.
        jump = np.diff(np.isnan(recorded)) | (np.diff(time) > PAUSE_STEP)
        edge = jump | np.append(jump[1:], False) | np.insert(jump[:-1], 0, False)
        number = np.cumsum(np.concatenate([[True], edge | (np.diff(np.floor(time / BLOCK)) != 0)])) - 1
        count = np.bincount(number)

        def mean(values: FloatArray) -> FloatArray:
            return np.asarray(np.bincount(number, values) / count)

        t, blocks = mean(time), np.stack([mean(row) for row in rows])
        steps = np.maximum(1, np.ceil(np.diff(t) / PAUSE_STEP)).astype(int)
        node = np.concatenate([[0], np.cumsum(steps)])
        nodes = np.interp(np.arange(node[-1] + 1), node, t)
        inputs = np.stack([np.interp(nodes, t, row) for row in blocks])
        measured = np.full(len(nodes), np.nan)
        measured[node] = mean(recorded)
        first = np.cumsum(count) - count
        chosen = (np.arange(len(number)) - first[number]) % max(1, int(np.median(count)) // BLOCK_ROWS) == 0
        return cls(tire, nodes, rows[:, chosen], node[number][chosen], inputs, measured, recording.source)

    @classmethod
    def of_all(cls, tire: Tire, recordings: Iterable[Recording], column: str) -> list[HeatBalance]:
        """Return the heat balances of recordings; where time goes backward, another one begins."""
        parts = (
            replace(recording, table=table)
            for recording in recordings
            for _, table in recording.table.groupby((recording.table["t"].diff() < 0.0).cumsum())
            if len(table) > 1 and table[column].notna().any()
        )
        return [cls.of(tire, part, column) for part in parts]

    @cached_property
    def states(self) -> tuple[str, ...]:
        """The names of the temperatures, the recorded one first."""
        return tuple(state.name for effect in self.tire.added if effect.name == EFFECT for state in effect.states)

    @cached_property
    def _parameters(self) -> FloatArray:
        return self.tire.parameters()

    def system(self, values: Mapping[str, float]) -> tuple[FloatArray, FloatArray]:
        """Return A, shape (n, m, m), and b, shape (n, m), at the nodes, for values of coefficients."""
        model, parameters = self.tire.symbolic_model, self._parameters.copy()
        parameters[[model.parameters.index(name) for name in values]] = list(values.values())
        at = [self.tire.inputs.index(name) for name in self.states]

        def lines_at(rows: FloatArray) -> tuple[dict[str, FloatArray], FloatArray]:
            """Return the lines of the states at temperatures of 0 K, and the heat that does not depend on them."""
            rows = rows.copy()
            rows[at] = 0.0
            lines = dict(
                zip(model.state_lines, fastest_code(model, rows.shape[1]).state_lines(rows, parameters), strict=True)
            )
            return lines, np.stack([lines[f"{name}_target"] * lines[f"{name}_rate"] for name in self.states])

        lines, supply = lines_at(self.inputs)
        _, exact = lines_at(self.rows)
        counts = np.bincount(self.block, minlength=len(self.t))
        for of_node, of_rows in zip(supply, exact, strict=True):
            of_node[counts > 0] = (np.bincount(self.block, of_rows, len(self.t)) / np.maximum(counts, 1))[counts > 0]
        return exchange(lines, self.states), supply.T

    def temperatures(self, values: Mapping[str, float], start: FloatArray) -> FloatArray:
        """Return the temperatures at the nodes, shape (n, m), K, from a start, shape (m,)."""
        return integrated(self.t, *self.system(values), start)

    def energy(self, values: Mapping[str, float], course: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return the heat that sliding and rolling have supplied and the heat that is stored, J, since the start.

        `course`, shape (n, m): `temperatures`. The difference, shape (n,) as the two, went to road and air.
        """
        cold = replace(self, inputs=self.inputs.copy(), rows=self.rows.copy())
        surroundings = [self.tire.inputs.index(name) for name in ("T_ambient", "T_road")]
        cold.inputs[surroundings] = cold.rows[surroundings] = 0.0
        capacity = np.array([values.get(name, self.tire.values[name]) for name in CAPACITIES])
        power = cold.system(values)[1] @ capacity
        supplied = np.concatenate([[0.0], np.cumsum(np.diff(self.t) * (power[1:] + power[:-1]) / 2.0)])
        return supplied, (course - course[0]) @ capacity


def integrated(t: FloatArray, matrix: FloatArray, supply: FloatArray, start: FloatArray) -> FloatArray:
    """Return the solution of x' = A x + b at the nodes, shape (n, m), with the mean of A and b in each step.

    `t`, shape (n,). `matrix`, shape (n, m, m). `supply`, shape (n, m). `start`, shape (m,).

    >>> t = np.linspace(0.0, 1.0, 101)
    >>> cooled = integrated(t, -np.ones((101, 1, 1)), np.zeros((101, 1)), np.ones(1))
    >>> round(float(cooled[-1, 0]), 4)
    0.3679
    """
    decay, gain = held_system((matrix[1:] + matrix[:-1]) / 2.0, np.diff(t))
    return vector_recursion(start, decay, (gain @ (supply[1:] + supply[:-1])[:, :, None])[:, :, 0] / 2.0)
