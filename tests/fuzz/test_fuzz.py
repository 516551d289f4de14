"""Mutated files of every kind are read, or rejected with one clear line.

``make fuzz`` draws 10,000 files, the tests a few hundred. A file's number is its seed; the last number that a failed
test printed is the file that failed.
"""

from __future__ import annotations

import os
import sys

import pytest

from tirefmu.boundary.errors import LONGEST, TirefmuError

from .kinds import KINDS

FILES = int(os.environ.get("TIREFMU_FUZZ", "260"))
BATCH = 50
#: Memory that reading small files may take in this process, in KiB.
MEMORY = 300_000


def batches():
    """Yield kinds and ranges of seeds, with the files distributed over the kinds."""
    for index, kind in enumerate(KINDS):
        count = FILES // len(KINDS) + (index < FILES % len(KINDS))
        for first in range(0, count, BATCH):
            seeds = range(first, min(first + BATCH, count))
            yield pytest.param(kind, seeds, id=f"{kind.replace(' ', '')}-{seeds[0]}..{seeds[-1]}")


@pytest.fixture(scope="session")
def whole_files(tmp_path_factory):
    """Return the function that makes the unmodified files of a kind, once."""
    made = {}

    def make(kind):
        if kind not in made:
            with pytest.MonkeyPatch.context() as patch:
                patch.chdir(tmp_path_factory.mktemp("seeds"))
                made[kind] = KINDS[kind].seeds()
        return made[kind]

    return make


def peak_memory():
    """Return the peak memory of this process in KiB; 0 if the system does not report it."""
    if sys.platform != "linux":
        return 0
    import resource

    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


def outcome(kind, path):
    """Read a file; return whether it was read, and check that an error is one clear line."""
    try:
        KINDS[kind].read(path)
    except TirefmuError as error:
        message = str(error)
        assert message.isprintable()
        assert message.strip()
        assert len(message) <= 6 * LONGEST
        assert path.name in message, message
        return False
    return True


@pytest.mark.parametrize(("kind", "seeds"), list(batches()))
def test_a_mutated_file_is_read_or_refused_in_one_line(
    kind, seeds, whole_files, tmp_path, monkeypatch, record_property
):
    monkeypatch.chdir(tmp_path)
    path = tmp_path / f"mutated{KINDS[kind].suffix}"
    originals, before, read = whole_files(kind), peak_memory(), 0
    for seed in seeds:
        print(f"{kind} file {seed}")
        path.write_bytes(KINDS[kind].change(seed, originals))
        read += outcome(kind, path)
        assert [file.name for file in tmp_path.iterdir()] == [path.name]
    assert peak_memory() - before < MEMORY
    record_property("fuzz", [kind, len(seeds), read])


@pytest.mark.parametrize("kind", KINDS)
def test_the_whole_files_are_read(kind, whole_files, tmp_path):
    path = tmp_path / f"whole{KINDS[kind].suffix}"
    for content in whole_files(kind):
        path.write_bytes(content)
        assert outcome(kind, path)


@pytest.mark.parametrize("kind", KINDS)
def test_mutations_are_repeatable_and_change_files(kind, whole_files):
    originals = whole_files(kind)
    files = {KINDS[kind].change(seed, originals) for seed in range(20)}
    assert files == {KINDS[kind].change(seed, originals) for seed in range(20)}
    assert len(files - set(originals)) > 15
