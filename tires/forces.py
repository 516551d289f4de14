"""Forces and moments by name."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]


class Forces(Mapping[str, FloatArray]):
    """Forces and moments by name: ``forces["Fy"]`` and ``forces.Fy`` are the same.

    Examples
    --------
    >>> forces = Forces({"Fx": np.array(1.0), "Fy": np.array(2.0)})
    >>> float(forces.Fy), list(forces)
    (2.0, ['Fx', 'Fy'])
    """

    def __init__(self, values: Mapping[str, FloatArray]) -> None:
        self._values = dict(values)

    def __getitem__(self, name: str) -> FloatArray:
        return self._values[name]

    def __getattr__(self, name: str) -> FloatArray:
        values = self.__dict__.get("_values", {})
        if name not in values:
            raise AttributeError(f"this model has no output {name}")
        return values[name]  # type: ignore[no-any-return]

    def __iter__(self) -> Iterator[str]:
        return iter(self._values)

    def __len__(self) -> int:
        return len(self._values)

    def __repr__(self) -> str:
        return f"Forces({', '.join(f'{name}={value}' for name, value in self._values.items())})"
