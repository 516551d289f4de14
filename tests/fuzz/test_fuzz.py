"""Mutated files: whatever is done to a .tir or CSV file, the outcome is a tire or a table, or one clear line.

``make fuzz`` draws 10,000 files, the tests a few hundred. A file's number is its seed; the last number that a failed
test printed is the file that failed.
"""

from __future__ import annotations

import math
import os
import random
import re

import numpy as np
import pandas as pd
import pytest

from tirefmu.measurements import read_recording
from tirefmu.symbolic.errors import TirefmuError
from tirefmu.tires import published, read_tir, write_tir
from tirefmu.tires.tir import tir_text
from tirefmu.tires.tir_units import UNITS, unit_factor

FILES = 50
BATCHES = int(os.environ.get("TIREFMU_FUZZ", "300")) // 2 // FILES

WORDS = [
    *b"nan inf -inf 1e308 -1e999 1e-999 0 -0.0 1.5D+03 1,5 mm 'mm' 'kN' 'degrees' kPa 'bar' 'in' = == $ ! , #".split(),
    *b"[ ] [[ [] [UNITS] [MODEL] [TIREFMU] [TIREFMU_ASSUMED] (((( { ' \" FITTYP=5 FITTYP=99 LENGTH='mm'".split(),
    *b"FITTYP = 62|TIREFMU_MODEL = 'mf61'|EFFECTS = 'camber_thrust'|alpha [deg]|Fz [kN]|p [psi]|\r\n|\n|\r".split(b"|"),
    *b"\x00|\xff\xfe|\xef\xbb\xbf|\t|\x0b|\x85|\xe2\x80\xa8|\xb0".split(b"|"),
    b"'\"'\"" * 50,
    b"9" * 400,
]


def cut(draw, data):
    """Leave out a piece, or all from somewhere on."""
    i, j = sorted((draw.randrange(len(data)), draw.randrange(len(data))))
    return data[:i] if draw.random() < 0.3 else data[:i] + data[min(j, i + draw.choice([1, 5, 50, 5000])) :]


def repeat(draw, data):
    """Say a piece twice, or many times, here or elsewhere."""
    i = draw.randrange(len(data))
    piece = data[i : i + draw.choice([1, 10, 200])] * draw.choice([1, 1, 2, 40])
    j = draw.choice([i, draw.randrange(len(data))])
    return data[:j] + piece + data[j:]


def swap(draw, data):
    """Let two bytes change places."""
    data = bytearray(data)
    i, j = draw.randrange(len(data)), draw.randrange(len(data))
    data[i], data[j] = data[j], data[i]
    return bytes(data)


def noise(draw, data):
    """Overwrite bytes with any bytes."""
    data = bytearray(data)
    for _ in range(draw.choice([1, 3, 30])):
        data[draw.randrange(len(data))] = draw.randrange(256)
    return bytes(data)


def insert(draw, data):
    """Put a word of mischief somewhere."""
    i = draw.randrange(len(data))
    return data[:i] + draw.choice(WORDS) + data[i:]


def replace_value(draw, data):
    """Put a word of mischief in the place of a value."""
    places = [m.span(1) for m in re.finditer(rb"(?:=|,|^) *([^\s,=$]+)", data, re.MULTILINE)]
    if not places:
        return insert(draw, data)
    i, j = draw.choice(places)
    return data[:i] + draw.choice(WORDS) + data[j:]


def change_sign(draw, data):
    """Turn the sign of a number."""
    numbers = [m.start() for m in re.finditer(rb"\d+\.?\d*", data)]
    i = draw.choice(numbers) if numbers else 0
    return data[:i] + b"-" + data[i:]


def change_unit(draw, data):
    """Declare another unit, known or nearly so."""
    key = draw.choice(sorted(UNITS))
    unit = draw.choice([*UNITS[key], "parsec", "", "m m", "meterr"])
    line = f"\n{key} = '{unit}'\n".encode()
    if draw.random() < 0.5:
        return re.sub(rb"(?im)^\s*" + key.encode() + rb"\s*=.*$", line.strip(), data)
    return data.replace(b"[UNITS]", b"[UNITS]" + line)


def drop_section(draw, data):
    """Leave out a section, or only its heading."""
    heads = [m.start() for m in re.finditer(rb"^\[", data, re.MULTILINE)] or [0]
    i = draw.choice(heads)
    end = min([h for h in heads if h > i] or [len(data)])
    return data[:i] + data[end:] if draw.random() < 0.6 else data[:i] + data[data.find(b"\n", i) + 1 :]


def shuffle_lines(draw, data):
    """Let some lines change places."""
    lines = data.split(b"\n")
    for _ in range(draw.choice([1, 5])):
        i, j = draw.randrange(len(lines)), draw.randrange(len(lines))
        lines[i], lines[j] = lines[j], lines[i]
    return b"\n".join(lines)


def line_ends(draw, data):
    """Write another system's line ends, or a mixture."""
    ends = draw.choice([[b"\r\n"], [b"\r"], [b"\n", b"\r\n", b"\r", b"\n\r"], [b"\x85"], [b"\r\r\n"]])
    return b"".join(line + draw.choice(ends) for line in data.split(b"\n"))


def encode(draw, data):
    """Write another encoding, or lie about it."""
    text = data.decode("latin-1")
    encoding = draw.choice(["utf-16", "utf-16-le", "utf-8-sig", "utf-32", "latin-1"])
    return draw.choice([b"", b"\xff\xfe", b"\xef\xbb\xbf"]) + text.encode(encoding)


MUTATIONS = (
    cut, repeat, swap, noise, insert, replace_value, change_sign, change_unit, drop_section, shuffle_lines, line_ends,
    encode,
)  # fmt: skip


def mutated(seed, originals):
    """Return one of the files with one to four mutations, always the same for a seed."""
    draw = random.Random(seed)
    data = draw.choice(originals)
    for _ in range(draw.choice([1, 1, 1, 2, 4])):
        data = draw.choice(MUTATIONS)(draw, data) or b" "
    return data


@pytest.fixture(scope="module")
def tir_files(golden):
    files = [(golden / f"MagicFormula{n}_Parameters.tir").read_bytes() for n in (52, 61, 62)]
    return [*files, tir_text(published("trento_hoosier")).encode()]


@pytest.fixture(scope="module")
def csv_files():
    t = np.arange(12) / 10
    table = pd.DataFrame({"t": t, "kappa": t / 10 - 0.05, "alpha": 0.2 - t / 5, "Fz": 900 + t, "p": 8e4, "Fy": 50 - t})
    headers = {"alpha": "alpha [deg]", "Fz": "Fz [kN]", "p": "p [psi]"}
    scaled = table.assign(alpha=np.degrees(table["alpha"]), Fz=table["Fz"] / 1e3, p=12.0).rename(columns=headers)
    return [
        table.to_csv(index=False).encode(),
        scaled.to_csv(index=False, sep=";").encode(),
        b"# a table\n" + table.to_csv(index=False).encode(),
    ]


def said_in_one_line(error, path):
    message = str(error)
    assert message.strip()
    assert "\n" not in message.replace("\r", "\n"), repr(message)
    assert path.name in message, message


def declared(text):
    """Return the unit of length and the radius as a plain look at the file finds them; None where not once."""
    text = re.sub(r"[$!].*", "", text)
    units = re.findall(r"(?im)^\s*LENGTH\s*=\s*'?([\w ]*)'?\s*$", text)
    radii = re.findall(r"(?im)^\s*UNLOADED_RADIUS\s*=\s*(\S+)\s*$", text)
    return (units[0], radii[0]) if len(units) == 1 == len(radii) else None


@pytest.mark.parametrize("batch", range(BATCHES), ids=lambda i: f"tir-{i * FILES}..{(i + 1) * FILES - 1}")
def test_a_mutated_tir_file_is_a_tire_or_one_clear_line(batch, tir_files, tmp_path):
    path = tmp_path / "mutated.tir"
    for seed in range(batch * FILES, (batch + 1) * FILES):
        print(f"file {seed}")
        data = mutated(seed, tir_files)
        path.write_bytes(data)
        try:
            tire = read_tir(path)
        except TirefmuError as error:
            said_in_one_line(error, path)
            continue
        assert all(math.isfinite(value) for value in tire.values.values()), seed
        look = declared(data.decode("latin-1")) if b"\x00" not in data and b"\x85" not in data else None
        if look:  # never a unit that is overlooked
            unit = unit_factor("LENGTH", look[0])
            expected = float(look[1].strip("'\"").lower().replace("d", "e")) * (unit or math.nan)
            assert tire.values["UNLOADED_RADIUS"] == pytest.approx(expected, rel=1e-12), seed
        write_tir(tire, path)
        again = read_tir(path)
        assert again == tire, seed
        assert [v.hex() for v in again.values.values()] == [v.hex() for v in tire.values.values()], seed


@pytest.mark.parametrize("batch", range(BATCHES), ids=lambda i: f"csv-{i * FILES}..{(i + 1) * FILES - 1}")
def test_a_mutated_csv_file_is_a_table_or_one_clear_line(batch, csv_files, tmp_path):
    path = tmp_path / "mutated.csv"
    for seed in range(batch * FILES, (batch + 1) * FILES):
        print(f"file {seed}")
        path.write_bytes(mutated(seed, csv_files))
        try:
            recording = read_recording(path)
        except TirefmuError as error:
            said_in_one_line(error, path)
            continue
        inputs = [name for name in ("t", "kappa", "alpha", "Fz", "p") if name in recording.table]
        assert np.isfinite(recording.table[inputs].to_numpy(dtype=float)).all(), seed


def test_mutations_change_files_and_some_are_still_read(tir_files, csv_files, tmp_path):
    """The fuzzing is worth its time only where both outcomes come about."""
    read = refused = 0
    for seed in range(60):
        assert mutated(seed, tir_files) == mutated(seed, tir_files)
        path = tmp_path / "mutated.tir"
        path.write_bytes(mutated(seed, tir_files))
        try:
            read_tir(path)
            read += 1
        except TirefmuError:
            refused += 1
    assert min(read, refused) >= 10
    assert {len({mutated(seed, files) for seed in range(60)}) > 50 for files in (tir_files, csv_files)} == {True}
