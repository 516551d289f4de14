"""Files made to harm, by kind: huge declared sizes, bombs, numbers that overflow, links and pickles."""

from __future__ import annotations

import io
import json
import pickle
from collections.abc import Callable

import numpy as np

from .kinds import TYDEX

READ = "read"
NAMES = ",".join(["alpha", "Fz", "Fy", *(f"c{i}" for i in range(4990))])
MANY = 1_500_000


class Pickled:
    """Runs a command where it is unpickled."""

    def __reduce__(self):
        return (print, ("ran",))


def parquet(columns, **options):
    """Return a Parquet file of columns, written in so many groups of rows."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    file, groups, metadata = io.BytesIO(), options.get("groups", 1), options.get("metadata")
    table = pa.table(columns).replace_schema_metadata(metadata)
    with pq.ParquetWriter(file, table.schema, compression="zstd") as writer:
        for _ in range(groups):
            writer.write_table(table)
    return file.getvalue()


def zeros(count, *names):
    return {name: np.zeros(count) for name in ("alpha", "Fz", "Fy", *names)}


def nested(levels):
    import pyarrow as pa

    array = pa.array([1.0])
    for _ in range(levels):
        array = pa.StructArray.from_arrays([array], names=["a"])
    return {**zeros(1), "x": array}


def index_of(stop):
    """Return metadata of pandas with an index of so many rows."""
    index = {"kind": "range", "name": None, "start": 0, "stop": stop, "step": 1}
    return {b"pandas": json.dumps({"index_columns": [index], "column_indexes": [], "columns": []}).encode()}


#: By kind and name: what makes the file, and a part of the message, or `READ`.
HARMFUL: dict[str, dict[str, tuple[Callable[[], bytes], str]]] = {
    "csv": {
        "first row of many cells": (lambda: b"alpha,Fz,Fy\n" + b"1.5," * MANY, "line 2: more than 1000000"),
        "first row over many lines": (lambda: b'alpha,Fz,Fy\n"' + b'\n","' * MANY, "line 1500002: more cells"),
        "first row behind blanks": (lambda: b'alpha,Fz,Fy\n\n""\n' + b"," * MANY * 4, "line 4: more than 1000000"),
        "a quote in a comment": (lambda: b'# 5"\nalpha,Fz,Fy\n0.1,1,2\n' + b"1," * MANY, "line 4: more than 1000000"),
        "later row of many cells": (lambda: b"alpha,Fz,Fy\n1,2,3\n" + b"," * MANY * 4, "line 3: more than 1000000"),
        "many columns, short rows": (lambda: NAMES.encode() + b"\n" + b"1\n" * MANY, "far fewer cells"),
        "header of many cells": (lambda: b"a," * 400_000, "at most 20000 are read"),
        "long header": (lambda: b"a" * 6_000_000, "line 1: more than 1000000 characters"),
        "long cell": (lambda: b"alpha,Fz,Fy\n" + b"9" * 6_000_000, "line 2: more than 1000000"),
        "open quote": (lambda: b'alpha,Fz,Fy\n"' + b"x\n" * 60_000, "not a table: "),
        "open quote in the header": (lambda: b'"alpha,Fz,Fy\n1,2,3\n', "line 2: more cells than the header"),
    },
    "tydex": {
        "channel twice": (lambda: TYDEX.replace(b"SLIPANGL", b"FYW     "), "FYW occurs 2 times"),
        "many channels": (lambda: TYDEX.replace(b"**MEASURD", b"A b N 1\n" * 300_000 + b"**MEASURD"), "4 cells for"),
        "many cells": (lambda: TYDEX.replace(b"**END", b"1 " * MANY), "line 14: 1500000 cells for 4 channels"),
        "many rows": (lambda: TYDEX.replace(b"**END", b"1 1 1 1\n" * 600_000), READ),
        "many sections": (lambda: b"**A%d\nx\n" * 300_000 % tuple(range(300_000)) + TYDEX, READ),
        "factor that overflows": (lambda: TYDEX.replace(b"N    1    0", b"N    1e308 1e308"), "Fy is infinite"),
        "offsets without a number": (lambda: TYDEX.replace(b"deg  1", b"deg  nan"), "unknown unit 'nan'"),
        "long cell": (lambda: TYDEX.replace(b"-1800", b"9" * 6_000_000), "Fy is infinite"),
        "long unit": (lambda: TYDEX.replace(b"deg  1", b"d" * 3_000_000 + b"  1"), "unknown unit"),
        "long title": (lambda: TYDEX.replace(b"run 3", b"\x1b[2J" * MANY), READ),
    },
    "parquet": {
        "many equal rows": (lambda: parquet(zeros(1_000_000), groups=40), "far larger than a file of its size"),
        "many columns": (lambda: parquet(zeros(10, *map(str, range(20000)))), "at most 20000 are read"),
        "one long text": (lambda: parquet({**zeros(1000), "x": ["x" * 100_000] * 1000}), "far larger than a file"),
        "deep column": (lambda: parquet(nested(100)), "cannot be read as Parquet"),
        "index of many rows": (lambda: parquet(zeros(2), metadata=index_of(10**12)), READ),
        "index that is none": (lambda: parquet(zeros(2), metadata={b"pandas": b"[" * 100_000}), "cannot be read as"),
        "a pickle": (lambda: pickle.dumps(Pickled()), "cannot be read as Parquet"),
    },
}  # fmt: skip
