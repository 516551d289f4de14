"""The recording of the content of a file, a DataFrame or a part of a large table."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np
import pandas as pd

from ...boundary.errors import DataError
from ...numerics.arrays import FloatArray
from ...symbolic.channels import CHANNELS, INPUTS, OUTPUTS
from ..column_names import check_names
from ..interpretation import NOT_READ, Interpretation
from ..recording import Recording
from ..thresholds import MAX_INCOMPLETE
from .columns.content import Content, names_of
from .columns.resolution import DEFINED, ColumnChoice, choices, common_clock, ignored_columns
from .ttc_channels import as_bench_table, completed, missing_channel


def recording_of(
    content: Content, source: str, name: str, signs: str | None, interpretation: Interpretation
) -> Recording:
    """Return the recording of the content of a file, in SI units.

    `source`, `name`: of the file, in messages and in the recording. `signs`: those that the user states. Raises
    `DataError` if no column is a channel, a name resembles a channel that the table lacks, a cell is not a number, a
    unit is unknown or another quantity's, or too many values of an input are NaN.
    """
    content = as_bench_table(content, name)
    chosen = choices(content, CHANNELS, source, interpretation.columns, interpretation.units)
    _check_present(content, chosen, source)
    table = channel_table(content, chosen, source)
    if not len(table):
        raise DataError(f"{source}: no rows")
    for channel in CHANNELS:
        if channel in table:
            header = f"{chosen[channel].column.header}: " if content.format in DEFINED and channel in chosen else ""
            check_finite(table[channel].to_numpy(), channel, source, _placed(content, header))
    declared = [channel for channel in table if channel in chosen and chosen[channel].declared]
    about = {**content.about, "declared": " ".join(declared)}
    about |= {f"unit of {channel}": choice.unit for channel, choice in chosen.items() if choice.unit}
    asserted = [channel for channel, choice in chosen.items() if choice.stated]
    about |= {"asserted": " ".join(asserted)} if asserted else {}
    outputs = [name for name in OUTPUTS if name in table]
    empty = [name for name in outputs if table[name].isna().all()]
    without = f"{', '.join(empty)} without a value" if 0 < len(empty) < len(outputs) else ""
    ignored = "; ".join(filter(None, [ignored_columns(content, chosen), without]))
    about |= {"ignored": ignored} if ignored else {}
    if content.format == "ttc":
        table, more = completed(content, chosen, table, source)
        table = table.drop(
            columns=[
                channel for channel, column in interpretation.columns.items() if column == NOT_READ and channel in table
            ]
        )
        about |= more
    return Recording(table, signs or content.signs or "iso", name, about)


def channel_table(content: Content, chosen: Mapping[str, ColumnChoice], source: str) -> pd.DataFrame:
    """Return the channels in SI units, and in a table the other columns as they are.

    Raises `DataError` if columns of channels have different lengths, or a cell is not a number.
    """
    clock = common_clock(chosen, source)
    values = {name: choice.values(content, source) for name, choice in chosen.items()}
    if clock is not None and "t" not in values:
        values = {"t": clock, **values}
    _check_lengths(values, chosen, source)
    if content.format:
        return pd.DataFrame({name: values[name] for name in CHANNELS if name in values})
    rows = len(next(iter(values.values()), ()))
    channels = {id(choice.column): name for name, choice in reversed(list(chosen.items()))}
    ordered: dict[str, object] = {"t": values["t"]} if "t" in values and "t" not in chosen else {}
    for number, column in enumerate(content.columns, start=1):
        name = channels.get(id(column))
        header = column.header.strip() or f"column {number}"
        if name is not None:
            ordered[name] = values[name]
        elif len(column.cells) == rows and header not in ordered and header not in CHANNELS:
            ordered[header] = pd.Series(column.cells)
    return pd.DataFrame({**ordered, **{name: values[name] for name in values if name not in ordered}})


def check_finite(values: FloatArray, name: str, source: str, location: Callable[[int], str]) -> None:
    """Check that a channel has no infinities, and an input few NaN.

    Rows without an input are excluded later (`without_incomplete_rows`). `location`: as of `Content`.
    Raises `DataError` with the first location, the channel and the number of rows.
    """
    infinite, unknown = np.isinf(values), np.isnan(values) & (name in INPUTS)
    for bad, kind, most in ((infinite, "infinite", 0.0), (unknown, "NaN", MAX_INCOMPLETE)):
        if bad.mean() > most:
            first = location(int(np.flatnonzero(bad)[0]))
            limit = f": up to {100.0 * most:g} % are excluded" if most else ""
            raise DataError(f"{source}: {first}: {name} is {kind} ({bad.sum()} of {len(values)} rows){limit}")


def _placed(content: Content, header: str) -> Callable[[int], str]:
    return lambda row: f"{content.location(row)}: {header}".removesuffix(": ")


def _check_lengths(values: Mapping[str, FloatArray], chosen: Mapping[str, ColumnChoice], source: str) -> None:
    first = "t" if "t" in values else next(iter(values), "")
    for name, column in values.items():
        if len(column) != len(values[first]):
            headers = [chosen[channel].column.header if channel in chosen else channel for channel in (name, first)]
            raise DataError(
                f"{source}: channel {headers[0]} has {len(column)} rows, {headers[1]} has {len(values[first])}"
            )


def _check_present(content: Content, chosen: Mapping[str, ColumnChoice], source: str) -> None:
    """Raise if no column is a channel, or one of another name probably is."""
    if content.format == "ttc":
        missing_channel(content, chosen, source)
    for name, reason in content.lacking.items():
        if name not in chosen:
            raise DataError(f"{source}: {reason}")
    if content.format in DEFINED:
        return
    channels = {id(choice.column): name for name, choice in chosen.items()}
    check_names([channels.get(id(column), column.header.strip()) for column in content.columns], source)
    if not chosen:
        unread = f" (not read: {'; '.join(content.ignored)})" if content.ignored else ""
        what = f"{names_of(content)}{unread}; known are {', '.join(CHANNELS)}"
        raise DataError(f"{source}: no column is a channel: {what}")
