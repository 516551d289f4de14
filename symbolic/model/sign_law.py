"""The sign law: one tire, written in ISO or in adapted SAE, has the same forces, with Fy, My and Mz reversed.

The two differ in the signs of the coefficients declared with `flips`, and in the option `signs` if the lines read it;
the inputs are the same. With a missing or wrong mark, a fit to a table in one convention would save a tire with a wrong
sign in the other. So the lines are computed in both for a few random tires and rows.

The same method checks whether Fx reverses with the speed, as the model declares.
"""

from __future__ import annotations

import math
import random
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass

from ...boundary.errors import ModelError
from ..declarations import Coefficient, Quantity
from ..options import signs
from ..quantities import V
from .definition import Model
from .lines import reaching
from .tape import run, taped

#: The columns that adapted SAE writes with the opposite sign of ISO.
REVERSED = frozenset({"Fy", "My", "Mz"})
#: Roles of quantities that are lengths in both.
LENGTHS = ("rolling_radius", "loaded_radius", "relaxation_x", "relaxation_y")
#: Random tires, one row each, with options at their first and at their second values.
ROWS = 12
#: With fewer finite rows an output is not checked.
MIN_ROWS = 3
#: Two numbers count as equal within this share of the larger one.
EQUAL = 1e-7

Values = Mapping[str, float]


def check_signs(model: Model) -> None:
    """Raise `ModelError` if a model violates the sign law, with the coefficients that are marked wrongly.

    >>> from tirefmu.symbolic.models import model_named
    >>> check_signs(model_named("mf96"))
    """
    check = _Check(model)
    marked = frozenset(name for name, declaration in model.coefficients.items() if declaration.flips)
    errors = check.errors(marked)
    for name, error in errors.items():
        if math.isinf(error):
            raise ModelError(f"{model.name}: {name} is no number at plausible coefficients and inputs")
    if not any(errors.values()):
        return
    outputs = " and ".join(name for name, error in errors.items() if error)
    broken = f"{model.name}: {outputs} in ISO and in adapted SAE are not those of one tire"
    mended = check.mended(marked)
    if mended is None:
        raise ModelError(f"{broken}: no marks of coefficients mend it; let a line read the option signs")
    wrong = [f"{name} {'must not flip' if name in marked else 'has to flip'}" for name in sorted(marked ^ mended)]
    raise ModelError(f"{broken}: {', '.join(wrong)}")


def check_reversal(model: Model) -> None:
    """Raise `ModelError` unless Fx agrees with the declaration `reverses` when V changes its sign.

    >>> from tirefmu.symbolic.models import model_named
    >>> check_reversal(model_named("fiala"))
    """
    tape = taped(reaching(model.lines(), ["Fx"]), [*(quantity.name for quantity in model.inputs), *model.parameters])
    reversed_rows = 0
    for seed in range(ROWS):
        row = _row(model, random.Random(seed), second=False)
        driven = {**row.coefficients, **row.given, "kappa": 0.3, "alpha": 0.0, signs.parameter: 1.0}
        forward, backward = (run(tape, {**driven, "V": speed})["Fx"] for speed in (V.typical, -V.typical))
        reversed_rows += forward * backward < 0.0
    if model.motion.reverses != (2 * reversed_rows > ROWS):
        how = "does not reverse" if model.motion.reverses else "reverses"
        raise ModelError(f"{model.name}: reverses is {model.motion.reverses}, but Fx {how} with V")


@dataclass(frozen=True)
class _Row:
    """One tire in adapted SAE and one row of inputs."""

    coefficients: Values
    given: Values


class _Check:
    """A model's lines at random tires and rows."""

    def __init__(self, model: Model) -> None:
        self._model = model
        self._outputs = [quantity.name for quantity in model.outputs]
        self._outputs += [name for name in map(model.quantity, LENGTHS) if name]
        lines = reaching(model.lines(), self._outputs)
        self._tape = taped(lines, [*(quantity.name for quantity in model.inputs), *model.parameters])
        self._rows = [_row(model, random.Random(seed), second=seed % 2 == 1) for seed in range(ROWS)]
        sae = [self._computed(row, frozenset(), 1.0) for row in self._rows]
        self._sae = {name: [values[name] for values in sae] for name in self._outputs}

    def errors(self, flipped: Collection[str]) -> dict[str, float]:
        """Return by output how far ISO misses adapted SAE with these coefficients reversed; infinity for no number."""
        iso = [self._computed(row, flipped, 0.0) for row in self._rows]
        return {name: self._error(name, [values[name] for values in iso]) for name in self._outputs}

    def mended(self, marked: frozenset[str]) -> frozenset[str] | None:
        """Return the marks nearest to the given ones that satisfy the law, or None; one is changed at a time."""
        best, error = marked, sum(self.errors(marked).values())
        while error:
            tried = [best ^ {name} for name in self._model.coefficients]
            errors = [sum(self.errors(marks).values()) for marks in tried]
            if min(errors) >= error:
                return None
            error = min(errors)
            best = tried[errors.index(error)]
        return best

    def _error(self, name: str, iso: Sequence[float]) -> float:
        sign = -1.0 if name in REVERSED else 1.0
        pairs = [(sign * a, b) for a, b in zip(iso, self._sae[name], strict=True)]
        missed = [abs(a - b) / max(abs(a), abs(b)) if a != b else 0.0
                  for a, b in pairs if math.isfinite(a) and math.isfinite(b)]  # fmt: skip
        if len(missed) < MIN_ROWS:
            return math.inf
        return sum(error for error in missed if error > EQUAL)

    def _computed(self, row: _Row, flipped: Collection[str], sae: float) -> Values:
        tire = {name: -value if name in flipped else value for name, value in row.coefficients.items()}
        return run(self._tape, {**row.given, **tire, signs.parameter: sae})


def _row(model: Model, draw: random.Random, *, second: bool) -> _Row:
    tire = {name: _drawn(declaration, draw) for name, declaration in model.coefficients.items()}
    inputs = {quantity.name: _input(quantity, tire, draw) for quantity in model.inputs}
    options = {option.parameter: float(second) for option in model.options}
    return _Row(tire, {**inputs, **options})


def _drawn(declaration: Coefficient, draw: random.Random) -> float:
    """Return a value off the neutral one and within the bounds."""
    size = max(0.3 * abs(declaration.generic), min(0.3, 0.3 * (declaration.upper - declaration.lower)))
    return min(max(declaration.generic + draw.uniform(-1.0, 1.0) * size, declaration.lower), declaration.upper)


def _input(quantity: Quantity, tire: Values, draw: random.Random) -> float:
    if isinstance(quantity.nominal, str):
        return tire.get(quantity.nominal, quantity.typical) * draw.uniform(0.6, 1.4)
    return quantity.nominal + quantity.typical * draw.uniform(-1.0, 1.0)
