"""Mutations of a file: bytes and numbers changed, pieces removed, repeated and moved, hostile words inserted."""

from __future__ import annotations

import io
import random
import re
import warnings
import zipfile
import zlib

from tirefmu.tires.property_file.units import UNITS

from ..hostile import HOSTILE

WORDS = [
    *b"nan inf -inf 1e308 -1e999 1e-999 0 -0.0 1.5D+03 1,5 mm 'mm' 'kN' 'degrees' kPa 'bar' 'in' = == $ ! , #".split(),
    *b"[ ] [[ [] [UNITS] [MODEL] [TIREFMU] [TIREFMU_ASSUMED] (((( { ' \" FITTYP=5 FITTYP=99 LENGTH='mm'".split(),
    *b"FITTYP = 62|TIREFMU_MODEL = 'mf61'|EFFECTS = 'camber_thrust'|alpha [deg]|Fz [kN]|p [psi]|\r\n|\n|\r".split(b"|"),
    *b"\x00|\xff\xfe|\xef\xbb\xbf|\t|\x0b|\x85|\xe2\x80\xa8|\xb0".split(b"|"),
    *b"**MEASURDATA **END true null [stage] [[stage]] [[acts]] <!DOCTYPE &a; </a> 1_000 0x7f 1979-05-27".split(),
    *(text.encode("utf-8", "surrogatepass") for text in HOSTILE),
    b"'\"'\"" * 50,
    b"9" * 400,
    b"[" * 3000,
]
#: Replacements of a size, a count or an offset in a binary header.
SIZES = [b"\xff" * 4, b"\xff\xff\xff\x7f", b"\0\0\0\x80", b"\0" * 4, b"\1\0\0\0", b"\x0e\0\0\0", b"\0\0\0\x40"]
#: Names of a file in an archive.
NAMES = ["../out", "/tmp/out", "a/../../out", "x" * 300, "modelDescription.xml/"]


def cut(draw, data):
    """Remove a piece, or everything after a random position."""
    i, j = sorted((draw.randrange(len(data)), draw.randrange(len(data))))
    return data[:i] if draw.random() < 0.3 else data[:i] + data[min(j, i + draw.choice([1, 5, 50, 5000])) :]


def repeat(draw, data):
    """Repeat a piece once or many times, at the same or another position."""
    i = draw.randrange(len(data))
    piece = data[i : i + draw.choice([1, 10, 200])] * draw.choice([1, 1, 2, 40])
    j = draw.choice([i, draw.randrange(len(data))])
    return data[:j] + piece + data[j:]


def swap(draw, data):
    """Swap two bytes."""
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
    """Insert a hostile word."""
    i = draw.randrange(len(data))
    return data[:i] + draw.choice(WORDS) + data[i:]


def replace_value(draw, data):
    """Replace a value by a hostile word."""
    positions = [m.span(1) for m in re.finditer(rb"(?:=|,|^) *([^\s,=$]+)", data, re.MULTILINE)]
    if not positions:
        return insert(draw, data)
    i, j = draw.choice(positions)
    return data[:i] + draw.choice(WORDS) + data[j:]


def change_sign(draw, data):
    """Change the sign of a number."""
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
    """Remove a section, or only its heading."""
    heads = [m.start() for m in re.finditer(rb"^\[", data, re.MULTILINE)] or [0]
    i = draw.choice(heads)
    end = min([h for h in heads if h > i] or [len(data)])
    return data[:i] + data[end:] if draw.random() < 0.6 else data[:i] + data[data.find(b"\n", i) + 1 :]


def shuffle_lines(draw, data):
    """Shuffle some lines."""
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
    """Write another encoding, or declare a wrong one."""
    text = data.decode("latin-1")
    encoding = draw.choice(["utf-16", "utf-16-le", "utf-8-sig", "utf-32", "latin-1"])
    return draw.choice([b"", b"\xff\xfe", b"\xef\xbb\xbf"]) + text.encode(encoding)


def sizes(draw, data):
    """Change numbers of a binary header: sizes, types, counts."""
    data = bytearray(data)
    for _ in range(draw.choice([1, 2, 4])):
        i = draw.randrange(len(data)) // 4 * 4
        size = draw.choice(SIZES)
        data[i : i + 4] = size if draw.random() < 0.7 else size[::-1]
    return bytes(data)


BINARY = (cut, repeat, swap, noise, sizes, insert)
TEXT = (
    cut, repeat, swap, noise, insert, replace_value, change_sign, change_unit, drop_section, shuffle_lines, line_ends,
    encode,
)  # fmt: skip


def mutated(seed, originals, ways=TEXT):
    """Return one of the files with one to four mutations, always the same for a seed."""
    draw = random.Random(seed)
    data = draw.choice(originals)
    for _ in range(draw.choice([1, 1, 1, 2, 4])):
        data = draw.choice(ways)(draw, data) or b" "
    return data


def compressed(seed, originals):
    """Return a MATLAB file of level 5 with mutated elements that are compressed only then, or with mutated bytes."""
    draw = random.Random(seed)
    data = draw.choice(originals)
    header, rest, packed = data[:128], data[128:], []
    hit = draw.randrange(8)
    while rest:
        size = 8 + int.from_bytes(rest[4:8], "little")
        element, rest = rest[:size], rest[size:]
        if len(packed) == hit:
            element = mutated(draw.random(), [element], BINARY)
        content = zlib.compress(element)
        packed.append(b"\x0f\0\0\0" + len(content).to_bytes(4, "little") + content)
    whole = header + b"".join(packed)
    return whole if draw.random() < 0.7 else mutated(draw.random(), [whole], BINARY)


def rezipped(seed, originals):
    """Return an archive of which a file or a name is mutated, or the bytes themselves."""
    draw = random.Random(seed)
    data = draw.choice(originals)
    if draw.random() < 0.3:
        return mutated(draw.random(), [data], BINARY)
    with zipfile.ZipFile(io.BytesIO(data)) as archive:
        files = [(name, archive.read(name)) for name in archive.namelist()]
    index = draw.randrange(len(files)) if draw.random() < 0.4 else 0
    name, content = files[index]
    if draw.random() < 0.85:
        files[index] = (name, mutated(draw.random(), [content]))
    else:
        files[index] = (draw.choice(NAMES), content)
    if draw.random() < 0.1:
        files.append(draw.choice(files))
    buffer = io.BytesIO()
    with warnings.catch_warnings(action="ignore"), zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in files:
            archive.writestr(zipfile.ZipInfo(name), content, zipfile.ZIP_DEFLATED)  # the same at any time of day
    return buffer.getvalue()
