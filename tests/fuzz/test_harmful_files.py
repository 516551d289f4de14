"""Files made to harm are refused with one clear line, or read, with little memory and without effects elsewhere."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from tirefmu.boundary.bounded_file import write_whole
from tirefmu.boundary.errors import DataError
from tirefmu.measurements import read_recording

from .harmful import HARMFUL, READ
from .kinds import KINDS

ROOT = Path(__file__).parents[2]
#: Memory of a process that reads such files, beyond what it has before, in bytes; the files have up to 20 MB.
MEMORY = 400_000_000
#: Kinds of files that take many seconds to make and to read.
SLOW = ("tydex", "parquet")
#: Memory of the process that reads Parquet and MATLAB files, in KiB.
READER_MEMORY = 1_000_000

#: Reads the files of a folder; prints what happened to each as JSON. Only Linux states the memory of a process.
READING = f"""
import json, resource, sys
from pathlib import Path
from tests.fuzz.kinds import KINDS
from tirefmu.measurements.files import native_reader
from tirefmu.boundary.errors import TirefmuError
kind, folder = KINDS[sys.argv[1]], Path(sys.argv[2])
size = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
resource.setrlimit(resource.RLIMIT_AS, (size + {MEMORY}, resource.RLIM_INFINITY))
answers = {{}}
for path in sorted(folder.iterdir()):
    try:
        kind.read(path)
        answers[path.name] = "{READ}"
    except TirefmuError as error:
        answers[path.name] = str(error)
native_reader.close()
answers["memory of readers"] = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss
print(json.dumps(answers))
"""


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux enforces the memory limit in every case")
@pytest.mark.parametrize(
    "kind", [pytest.param(kind, marks=pytest.mark.slow) if kind in SLOW else kind for kind in HARMFUL]
)
def test_a_harmful_file_needs_little_memory(kind, tmp_path):
    if kind == "parquet":
        pytest.importorskip("pyarrow")
    suffix, files = KINDS[kind].suffix, HARMFUL[kind]
    for name, (make, _) in files.items():
        (tmp_path / f"{name}{suffix}").write_bytes(make())
    before = sorted(tmp_path.iterdir())
    environment = {**os.environ, "PYTHONPATH": str(ROOT), "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    command = [sys.executable, "-W", "error", "-c", READING, kind, str(tmp_path)]
    run = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stderr[-2000:]
    assert run.stdout.count("\n") == 1  # nothing was run
    answers = json.loads(run.stdout)
    assert answers.pop("memory of readers") < READER_MEMORY
    for name, (_, message) in files.items():
        answer = answers[f"{name}{suffix}"]
        assert message in answer, (name, answer)
        assert answer == READ or (answer.isprintable() and f"{name}{suffix}" in answer)
    assert sorted(tmp_path.iterdir()) == before


@pytest.mark.skipif(sys.platform == "win32", reason="devices are files there")
@pytest.mark.parametrize("suffix", [".csv", ".tdx", ".dat", ".mat", ".parquet"])
def test_a_link_to_a_device_is_not_read(tmp_path, suffix):
    (tmp_path / f"run{suffix}").symlink_to("/dev/zero")
    with pytest.raises(DataError, match="neither a file nor a folder"):
        read_recording(tmp_path / f"run{suffix}")


def test_a_link_with_the_name_of_a_part_is_not_followed(tmp_path):
    """Files are written under this name first; who delivers a folder could place a link there."""
    other, path = tmp_path / "other", tmp_path / "tire.json"
    other.write_text("mine")
    for name in (path.name, f".{path.name}.part"):
        (tmp_path / name).symlink_to(other)
    write_whole(path, b"content")
    assert other.read_text() == "mine"
    assert not path.is_symlink()
    assert sorted(file.name for file in tmp_path.iterdir()) == ["other", path.name]
