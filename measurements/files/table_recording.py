"""The recording of a table of any format, with the names of the contract or those of FSAE TTC files."""

from __future__ import annotations

from collections.abc import Callable, Collection
from pathlib import Path

import numpy as np
import pandas as pd

from ..channels import CHANNELS
from ..interpretation import Interpretation
from ..recording import Recording
from .columns import LONGEST_HEADER, channels_in_si, name_and_unit, numbers, parse_header
from .ttc_channels import MANDATORY, bench_recording


def is_bench_table(headers: Collection[str]) -> bool:
    """Return whether the headers are those of an FSAE TTC file: it has ET, SA, IA and FZ, and no slip angle ``alpha``.

    >>> is_bench_table(["ET", "SA", "IA", "FZ [N]", "FY"]), is_bench_table(["ET", "alpha", "FZ"])
    (True, False)
    """
    names = {name_and_unit(header)[0] for header in headers if len(header) <= LONGEST_HEADER}
    return set(MANDATORY) <= names and not {"alpha", "gamma", "Fz"} & names


def table_recording(
    path: Path, table: pd.DataFrame, signs: str, interpretation: Interpretation, location: Callable[[int], str]
) -> Recording:
    """Return the recording of a table whose columns are named by their headers.

    A table with the names of FSAE TTC files has their units (`assumed_units`, unless headers declare them) and signs.
    `location`: as for `channels_in_si`. Raises what `parse_header`, `channels_in_si` and `bench_recording` raise.
    """
    source, headers = str(path), [str(name) for name in table.columns]
    if not is_bench_table(headers):
        columns = parse_header(headers, source, interpretation)
        converted, about = channels_in_si(table, columns, source, location)
        return Recording(converted, signs, path.name, about)
    named = [name_and_unit(header) for header in headers]
    channels = {name for channel in CHANNELS.values() for name in channel.bench_names}
    used = channels | {"RL", "N", *interpretation.renamed}
    vectors = {
        name: numbers(table.iloc[:, number].rename(name), source, location) if name in used else np.empty(0)
        for number, (name, _) in enumerate(named)
    }
    units = {name: unit for name, unit in named if unit}
    about = {"tireid": "", "testid": "", "credit": "", "signs": "sae"}
    return bench_recording(path, vectors, units, signs, about, location, interpretation)
