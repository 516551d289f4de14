"""Logs that claim more than they have are refused with one clear line and little memory."""

from __future__ import annotations

import json
import os
import struct
import subprocess
import sys
from pathlib import Path

import pytest

from tirefmu.boundary.errors import DataError
from tirefmu.measurements.files import native_reader
from tirefmu.measurements.files.formats import FORMATS
from tirefmu.measurements.files.reading import read_content

ROOT = Path(__file__).parents[2]
#: KiB: largest memory of the process that reads all these files, and of the process of the libraries.
MEMORY = 500_000
GIGABYTES = 10 << 30
#: First bytes by extension, so that a file is taken for one of its format.
HEADS = {
    ".mat": b"MATLAB 5.0 MAT-file".ljust(124) + b"\x00\x01IM",
    ".mf4": b"MDF     4.10    ",
    ".tdms": b"TDSm",
    ".ulg": b"ULog\x01\x12\x35\x01" + bytes(8),
    ".bag": b"#ROSBAG V2.0\n",
    ".db3": b"SQLite format 3\0",
    ".mcap": b"\x89MCAP0\r\n",
    ".vbo": b"[column names]\ntime v\n[data]\n",
    ".tdx": b"**HEADER\n",
    ".csv": b"t,steer\n0,0\n",
    ".dat": b"title\nET SA IA FZ\n",
    ".parquet": b"PAR1",
    ".xlsx": b"PK\x03\x04",
}

READING = """
import json, resource, sys
from pathlib import Path
from tirefmu.measurements.files import native_reader
from tirefmu.measurements.files.reading import read_content
from tirefmu.boundary.errors import TirefmuError
answers = {}
for path in sorted(Path(sys.argv[1]).iterdir()):
    try:
        read_content(path)
        answers[path.name] = "read"
    except TirefmuError as error:
        answers[path.name] = str(error)
native_reader.close()
# The largest memory of the process itself: getrusage counts that of the process that started it.
own = next(line for line in Path("/proc/self/status").read_text().splitlines() if line.startswith("VmHWM"))
usage = [int(own.split()[1]), resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss]
print(json.dumps([answers, usage]))
"""


def px4(form: bytes, data: bytes, claimed: int) -> bytes:
    """Return a log of PX4 with one topic; `claimed`: the stated length of its message."""
    head = HEADS[".ulg"]
    parts = ((b"F", form), (b"A", b"\0\0\0a"))
    messages = b"".join(struct.pack("<Hc", len(body), kind) + body for kind, body in parts)
    return head + messages + struct.pack("<Hc", claimed, b"D") + b"\0\0" + data


def tdms(samples: int) -> bytes:
    """Return a TDMS file whose channel claims so many samples."""
    path = b"/'g'/'c'"
    objects = struct.pack("<II4sII", 2, 4, b"/'g'", 0xFFFFFFFF, 0) + struct.pack("<I", len(path)) + path
    objects += struct.pack("<IIIQI", 20, 10, 1, samples, 0)
    return b"TDSm" + struct.pack("<IIQQ", 14, 4713, len(objects) + 8 * samples, len(objects)) + objects + bytes(64)


def mcap(*records: tuple[int, int, bytes]) -> bytes:
    """Return an MCAP file of records: kind, stated length, content."""
    magic = HEADS[".mcap"]
    return magic + b"".join(struct.pack("<BQ", kind, size) + body for kind, size, body in records) + magic


#: A chunk of 32 bytes that claims 35 TB.
CHUNK = struct.pack("<QQQI", 0, 1, 1 << 45, 0) + struct.pack("<I4sQ", 4, b"zstd", 16) + bytes(16)
CLAIMS = {
    "array.ulg": px4(b"a:uint64_t timestamp;float[1000000000] x;", bytes(8), 65535),
    "recursion.ulg": px4(b"a:uint64_t timestamp;a x;", bytes(8), 10),
    "samples.tdms": tdms(1 << 40),
    "chunk.mcap": mcap((1, 13, struct.pack("<I4sIc", 4, b"ros2", 1, b"x")), (6, len(CHUNK), CHUNK)),
    "record.mcap": mcap((6, 1 << 60, bytes(100))),
    "header.bag": b"#ROSBAG V2.0\n" + struct.pack("<I", 1 << 31) + bytes(4096),
    "blank.csv": b"t,steer,speed,ay\n" + b"\n" * 5_000_000,
    "wide.csv": b",".join(b"c%d" % i for i in range(500_000)) + b"\n1\n",
    "wide.vbo": b"[column names]\n" + b"a " * 1_000_000 + b"\n[data]\n1 1\n",
}


@pytest.mark.skipif(sys.platform != "linux", reason="only there a file of 10 GB needs no room, and memory is in KiB")
def test_a_log_that_claims_more_than_it_has_needs_little_memory(tmp_path):
    for suffix in FORMATS:
        with (tmp_path / f"absent{suffix}").open("wb") as file:
            file.write(HEADS.get(suffix, b""))
            file.truncate(GIGABYTES)
    for name, content in CLAIMS.items():
        (tmp_path / name).write_bytes(content)
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    run = subprocess.run(
        [sys.executable, "-W", "error", "-c", READING, str(tmp_path)], cwd=ROOT, env=environment, capture_output=True,
        text=True, check=False,
    )  # fmt: skip
    assert run.returncode == 0, run.stderr[-2000:]
    answers, usage = json.loads(run.stdout)
    assert max(usage) < MEMORY
    for name, answer in answers.items():
        # npTDMS reads the samples that are there, as after an aborted recording.
        assert answer.startswith(f"{tmp_path / name}: ") or (name, answer) == ("samples.tdms", "read"), (name, answer)
        assert answer.isprintable()


def test_work_without_end_is_ended_by_its_processor_time(tmp_path, monkeypatch):
    asammdf = pytest.importorskip("asammdf")
    pytest.importorskip("resource", reason="this system does not limit processor time")
    path = tmp_path / "loop.mf4"
    with asammdf.MDF(version="4.10") as file:
        file.append([asammdf.Signal([1.0, 2.0], [0.0, 1.0], name="steer")])
        file.save(path)
    content = bytearray(path.read_bytes())
    group = content.find(b"##DG")
    content[group + 24 : group + 32] = struct.pack("<Q", group)  # the next group is this one
    path.write_bytes(content)
    monkeypatch.setattr(native_reader, "PROCESSOR_SECONDS", 0.5)
    with pytest.raises(DataError, match=r"loop\.mf4: cannot be read as a \.mf4 log: reading takes too long"):
        read_content(path)
