"""Native code that reads a file may crash, hang or request all memory: one clear line, and the next file is read."""

import struct
import sys
import threading

import numpy as np
import pandas as pd
import pytest
from scipy.io import savemat

from tirefmu.boundary.errors import DataError
from tirefmu.measurements import read_recording
from tirefmu.measurements.files import native_reader

CHANNELS = ("ET", "SA", "IA", "FY", "SL")


@pytest.fixture
def good(tmp_path):
    path = tmp_path / "good.mat"
    numbers = {name: np.linspace(1.0, 2.0, 5)[:, None] for name in CHANNELS}
    savemat(path, {**numbers, "FZ": np.full((5, 1), -900.0)})
    return path


def refusal(path):
    with pytest.raises(DataError) as caught:
        read_recording(path)
    return str(caught.value)


def test_a_file_that_crashes_its_reader_is_refused_and_the_next_one_read(good, tmp_path):
    """Elements with a wrong type (matrix, compressed) crash scipy's reader; found by fuzzing."""
    content = bytearray(good.read_bytes())
    for kind in (14, 15):
        content[176:180] = kind.to_bytes(4, "little")
        (tmp_path / "bad.mat").write_bytes(content)
        assert "bad.mat: cannot be read as a MATLAB file: " in refusal(tmp_path / "bad.mat")
        assert len(read_recording(good)) == 5


@pytest.mark.parametrize(
    ("program", "seconds", "reason"),
    [
        ("import os, sys; sys.stdin.buffer.read(1); os.abort()", 60.0, "the file is damaged and crashes its reader"),
        ("import time; time.sleep(600)", 0.2, "reading takes too long"),
    ],
)
def test_a_process_that_dies_or_hangs_is_reported_and_replaced(good, tmp_path, monkeypatch, program, seconds, reason):
    (tmp_path / "fails.py").write_text(program, encoding="utf-8")
    monkeypatch.setattr(native_reader.reader_process, "__file__", str(tmp_path / "fails.py"))
    monkeypatch.setattr(native_reader, "SECONDS", seconds)
    native_reader.close()
    assert f"good.mat: cannot be read as a MATLAB file: {reason}" in refusal(good)
    monkeypatch.undo()
    assert len(read_recording(good)) == 5


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux enforces the memory limit in every case")
@pytest.mark.parametrize("rows", [2**29, 2**31 - 1])
def test_a_header_that_claims_gigabytes_allocates_none(tmp_path, rows):
    """A level 4 file declares its size in 20 bytes."""
    path = tmp_path / "big.mat"
    path.write_bytes(struct.pack("<5i", 0, rows, 8, 0, 3) + b"ET\0" + bytes(80))
    assert refusal(path).startswith(f"{path}: cannot be read as a MATLAB file: ")


def test_nothing_in_the_working_folder_is_imported(good, tmp_path, monkeypatch):
    """A file next to a recording may have the name of a module."""
    for name in ("scipy", "pickle", "pandas", "numpy"):
        (tmp_path / f"{name}.py").write_text("open('ran', 'w')\n", encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    native_reader.close()
    assert len(read_recording("good.mat")) == 5
    assert not (tmp_path / "ran").exists()


def test_threads_have_separate_results(good, tmp_path):
    pytest.importorskip("pyarrow")
    tables = [pd.DataFrame({"alpha": np.full(3 + n, 0.1), "Fz": 900.0, "Fy": float(n)}) for n in range(4)]
    for n, table in enumerate(tables):
        table.to_parquet(tmp_path / f"{n}.parquet")
    read = {}
    threads = [
        threading.Thread(target=lambda n=n: read.update({n: read_recording(tmp_path / f"{n}.parquet").table}))
        for n in range(4)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for n, table in enumerate(tables):
        pd.testing.assert_frame_equal(read[n], table)


def test_a_small_file_with_a_huge_content_is_rejected(tmp_path, monkeypatch):
    """A damaged HDF5 header expanded 7 KB to 700 MB of zeros; Parquet and zlib can declare as much."""
    path = tmp_path / "flat.mat"
    columns = {name: np.full((20_000, 1), 1.0) for name in CHANNELS}
    savemat(path, {**columns, "FZ": np.full((20_000, 1), -900.0)}, do_compression=True)
    assert len(read_recording(path)) == 20_000
    monkeypatch.setattr(native_reader, "CONTENT", 10_000)
    monkeypatch.setattr(native_reader, "CONTENT_PER_BYTE", 10)
    assert refusal(path).endswith("its content is far larger than a file of its size can contain")


def test_compressed_numbers_that_are_damaged(good, tmp_path):
    """The exceptions of zlib are not those of scipy; found by fuzzing."""
    element = b"\x0f\0\0\0" + (40).to_bytes(4, "little") + bytes(40)
    (tmp_path / "bad.mat").write_bytes(good.read_bytes()[:128] + element)
    assert "bad.mat: cannot be read as a MATLAB file: Error -3 while decompressing" in refusal(tmp_path / "bad.mat")
