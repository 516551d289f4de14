"""A study: an FMU is simulated over manoeuvres with many values of its parameters. Its TOML file and its runs."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import product
from math import prod
from pathlib import Path
from typing import Annotated, Any

import numpy as np

from ...boundary.bounded_file import toml_file
from ...boundary.errors import FitError, path_from
from ...boundary.json_schema import document, object_schema, schema_of
from ...boundary.schema_check import check_content

#: Upper limit of the number of runs.
MAX_RUNS = 1_000_000
KEYS: Mapping[str, Any] = {
    "tables": Annotated[list[str], "manoeuvres", {"minItems": 1}], "signs": str, "outputs": list[str],
    "samples": int, "seed": int, "series": bool,
}  # fmt: skip
RANGE: Mapping[str, Any] = {"from": float, "to": float, "count": Annotated[int, {"minimum": 1, "maximum": MAX_RUNS}]}


@dataclass(frozen=True)
class Study:
    """A study.

    - `tables`: manoeuvres: recordings with the inputs of the FMU over time.
    - `signs`: convention of the tables.
    - `outputs`: outputs of the FMU to evaluate; all outputs of the tables' contract if empty.
    - `values`: parameters of each run of a manoeuvre.
    - `series`: whether the outputs over time are stored, not only their statistics.
    """

    tables: tuple[Path, ...]
    signs: str | None
    outputs: tuple[str, ...]
    values: tuple[Mapping[str, float], ...]
    series: bool = False


def read_study(path: str | Path) -> Study:
    r"""Return the study of a TOML file.

    `path`: with ``tables`` (relative to the file) and ``[parameters]``: of each a list of values or a range ``{from =
    0.5, to = 1.0, count = 6}``. All combinations are simulated; with ``samples`` a Latin hypercube of so many points in
    the ranges (``seed``). Raises `FitError` if the file cannot be read, has an unknown key or an invalid
    value, or the study has too many runs.

    >>> import tempfile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = Path(folder, "study.toml")
    ...     _ = file.write_text('tables = ["a.csv"]\n[parameters]\nLMUY = {from = 0.5, to = 1.0, count = 3}\n')
    ...     study = read_study(file)
    >>> study.values
    ({'LMUY': 0.5}, {'LMUY': 0.75}, {'LMUY': 1.0})
    """
    path = path_from(path)
    content = toml_file(path, FitError)
    check_content(content, study_schema(), str(path), FitError)
    location = f"{path}: parameters"
    parameters = content.get("parameters", {})
    samples = content.get("samples")
    if samples is None:
        lists = {name: _levels(given, f"{location}.{name}") for name, given in parameters.items()}
        runs = prod(map(len, lists.values()))
    else:
        runs = samples
    if not 1 <= runs * len(content["tables"]) <= MAX_RUNS:
        raise FitError(f"{path}: {runs * len(content['tables'])} runs, not 1 to {MAX_RUNS}")
    values = (
        [dict(zip(lists, combination, strict=True)) for combination in product(*lists.values())]
        if samples is None
        else _sampled(parameters, samples, content.get("seed", 0), location)
    )
    tables = tuple(path.parent / table for table in content["tables"])
    return Study(
        tables, content.get("signs"), tuple(content.get("outputs", ())), tuple(values), content.get("series", False)
    )


def study_schema() -> dict[str, Any]:
    """Return the JSON Schema of a study."""
    values = {"anyOf": [{**schema_of(list[float]), "minItems": 1}, object_schema(RANGE, ["from", "to"])]}
    content = {**KEYS, "parameters": {"type": "object", "additionalProperties": values}}
    return document("study", "1.0", "Study of an FMU", object_schema(content, ["tables"]))


def _levels(given: Any, location: str) -> list[float]:
    """Return the values of a parameter, from a list or a range."""
    if isinstance(given, list):
        return [float(value) for value in given]
    if "count" not in given:
        raise FitError(f"{location}: count is missing: a range has a count, or the study has samples")
    return [float(value) for value in np.linspace(given["from"], given["to"], given["count"])]


def _sampled(parameters: Mapping[str, Any], count: int, seed: int, location: str) -> list[dict[str, float]]:
    """Return the points of a Latin hypercube in the ranges of the parameters."""
    for name, given in parameters.items():
        if isinstance(given, list):
            raise FitError(f"{location}.{name} is a list: samples need ranges {{from, to}}")
    if not parameters:
        raise FitError(f"{location}: samples needs at least one range")
    rng, shape = np.random.default_rng(abs(seed)), (count, len(parameters))
    strata = rng.permuted(np.tile(np.arange(count)[:, None], (1, len(parameters))), axis=0)
    points = (strata + rng.random(shape)) / count
    lower, upper = np.array([(given["from"], given["to"]) for given in parameters.values()]).T
    return [dict(zip(parameters, row, strict=True)) for row in (lower + points * (upper - lower)).tolist()]
