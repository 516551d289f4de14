"""The cache: damaged or third-party entries are not used, entries are stored atomically, and the cache is optional."""

from __future__ import annotations

import errno
import os
import sys
import threading
import time
from pathlib import Path

import pytest

from tirefmu.symbolic.models import model_named, with_library
from tirefmu.tires.code import build_cache, modules, printed
from tirefmu.tires.code.build_cache import RECORD, cache_folder, cached

unix = pytest.mark.skipif(not hasattr(os, "geteuid"), reason="this system has no owners and permissions of this kind")
root = pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() != 0, reason="only root can give files away")
STRANGER = 54321


@pytest.fixture(autouse=True)
def nothing_yet(tmp_path, monkeypatch):
    """Give each test a separate cache, and clear the record of used entries and warnings of this process."""
    monkeypatch.setenv("TIREFMU_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr(build_cache, "_used", set())
    monkeypatch.setattr(build_cache, "_private", [])
    build_cache._warn_once.cache_clear()


@pytest.fixture
def cache(tmp_path):
    return tmp_path / "cache"


class Maker:
    """Write two files, and count the calls."""

    def __init__(self, content="content"):
        self.content, self.made = content, 0

    def __call__(self, folder):
        self.made += 1
        (folder / "below").mkdir()
        (folder / "below" / "file").write_text(self.content, encoding="ascii")
        (folder / "other").write_bytes(bytes(range(256)))


def content_of(entry):
    return (entry / "below" / "file").read_text(encoding="ascii")


def names(folder):
    return sorted(path.name for path in folder.iterdir())


def test_an_entry_is_made_once(cache):
    make = Maker()
    first = cached("entry", make)
    assert cached("entry", make) == first == cache / "entry"
    assert make.made == 1
    assert content_of(first) == "content"
    assert names(cache) == ["entry"]
    assert names(first) == ["below", "other", RECORD]
    assert cached("entry", make, rebuild=True) == first
    assert make.made == 2


@unix
def test_only_the_user_can_enter_it(cache):
    entry = cached("entry", Maker())
    assert cache.stat().st_mode & 0o777 == 0o700
    assert {path.stat().st_mode & 0o077 for path in (entry, *entry.rglob("*"))} == {0}


@unix
@pytest.mark.parametrize("part", [".", "below", "other", "below/file", RECORD])
def test_an_entry_that_others_can_write_is_built_again(cache, part):
    make = Maker()
    (cached("entry", make) / part).chmod(0o777)
    assert content_of(cached("entry", make)) == "content"
    assert make.made == 2


@root
@pytest.mark.parametrize("part", [".", "other", "below/file"])
def test_an_entry_of_another_user_is_built_again(cache, part):
    make = Maker()
    os.chown(cached("entry", make) / part, STRANGER, STRANGER)
    cached("entry", make)
    assert make.made == 2
    assert (cache / "entry" / part).stat().st_uid == os.geteuid()


def private(entry, cache, caplog):
    """Return whether an entry is in a temporary folder of this process, after one line with the reason."""
    (record,) = caplog.records
    assert record.name == "tirefmu"
    assert "\n" not in record.getMessage()
    return cache not in entry.parents and entry.parent.stat().st_mode & 0o077 == 0


@unix
@pytest.mark.parametrize("shared", [".", ".."])
def test_a_folder_that_others_can_write_is_not_used(tmp_path, monkeypatch, caplog, shared):
    folder = tmp_path / "shared" / "cache"
    folder.mkdir(parents=True)
    (folder / shared).chmod(0o777)
    monkeypatch.setenv("TIREFMU_CACHE", str(folder))
    make = Maker()
    entry = cached("entry", make)
    assert private(entry, folder, caplog)
    assert "other users can write into it" in caplog.text
    assert cached("entry", make) == entry
    assert make.made == 1
    assert names(folder) == []
    if shared == "..":  # as in /tmp: no other user can replace the folder
        (folder / shared).chmod(0o1777)
        assert cached("other", make) == folder / "other"


@unix
def test_a_folder_of_another_user_is_not_used(cache, caplog, monkeypatch):
    cache.mkdir()
    make = Maker()
    cached("entry", make)
    monkeypatch.setattr(build_cache.os, "geteuid", lambda: STRANGER)
    if cache.stat().st_uid == 0:
        os.chown(cache, STRANGER + 1, STRANGER + 1)
    entry = cached("entry", make)
    assert private(entry, cache, caplog)
    assert "belongs to another user" in caplog.text
    assert make.made == 2


@pytest.mark.parametrize("what", ["a file", "below a file"])
def test_a_cache_that_is_no_folder(cache, caplog, monkeypatch, what):
    cache.write_text("", encoding="ascii")
    if what == "below a file":
        monkeypatch.setenv("TIREFMU_CACHE", str(cache / "below"))
    assert private(cached("entry", Maker()), cache, caplog)
    assert "cannot be used" in caplog.text


def full(monkeypatch, below):
    """Simulate a full disk below a folder."""
    write = Path.write_bytes

    def write_bytes(path, content):
        if below in path.parents:
            write(path, content[: len(content) // 2])
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(path))
        return write(path, content)

    monkeypatch.setattr(Path, "write_bytes", write_bytes)


def test_a_full_disk(cache, tmp_path, caplog, monkeypatch):
    (tmp_path / "temporary").mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "temporary"))
    make = Maker()
    full(monkeypatch, cache)
    entry = cached("entry", make)
    assert private(entry, cache, caplog)
    assert "No space left on device" in caplog.text
    assert make.made == 1
    assert names(cache) == []
    full(monkeypatch, tmp_path)
    with pytest.raises(OSError, match="No space left on device"):
        cached("other", make)
    assert names(tmp_path / "temporary") == [entry.parent.name]
    assert names(entry.parent) == ["entry"]


@unix
def test_a_folder_that_cannot_be_written(cache, caplog, monkeypatch):
    make = Maker()
    first = cached("entry", make)

    def refuse(suffix=None, prefix=None, dir=None):
        if dir is not None and Path(dir) == cache:
            raise PermissionError(errno.EACCES, "Permission denied", str(dir))
        return mkdtemp(suffix, prefix, dir)

    mkdtemp = build_cache.tempfile.mkdtemp
    monkeypatch.setattr(build_cache.tempfile, "mkdtemp", refuse)
    assert cached("entry", make) == first  # the existing entry can be used
    assert not caplog.records
    assert private(cached("other", make), cache, caplog)


def in_threads(n, make):
    """Return the entries that n threads get, each of which needs the same one."""
    entries = []
    threads = [threading.Thread(target=lambda: entries.append(cached("entry", make))) for _ in range(n)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return entries


@pytest.mark.parametrize("before", ["nothing", "damaged"])
def test_one_builds_and_the_others_wait(cache, caplog, before):
    if before == "damaged":
        (cached("entry", Maker()) / "other").write_bytes(b"")
    make = Maker()

    def slow(folder):
        time.sleep(0.2)  # the others arrive meanwhile
        make(folder)

    assert in_threads(8, slow) == [cache / "entry"] * 8
    assert make.made == 1
    assert names(cache) == ["entry"]
    assert not caplog.records


@pytest.mark.parametrize("before", ["nothing", "damaged"])
def test_concurrent_builds_without_a_lock(cache, caplog, monkeypatch, before):
    def refuse(path, timeout):
        raise NotImplementedError  # a file system without locks

    monkeypatch.setattr(build_cache.filelock, "FileLock", refuse)
    if before == "damaged":
        (cached("entry", Maker()) / "other").write_bytes(b"")
    barrier = threading.Barrier(8)

    def make(folder):
        barrier.wait(timeout=60.0)
        Maker()(folder)

    entries = in_threads(8, make)
    assert entries == [cache / "entry"] * 8
    assert content_of(entries[0]) == "content"
    assert names(cache) == ["entry"]
    assert not caplog.records


def test_an_entry_stored_by_another_process_is_preserved(cache, monkeypatch):
    monkeypatch.setattr(build_cache, "LONGEST_BUILD", 0.0)  # the other one does not wait

    def make(folder):
        Maker("ours")(folder)
        cached("entry", Maker("theirs"))

    assert content_of(cached("entry", make)) == "theirs"
    assert names(cache) == ["entry"]


def test_a_failed_build_leaves_no_files(cache):
    def make(folder):
        (folder / "half").write_text("half", encoding="ascii")
        raise ValueError("no further")

    with pytest.raises(ValueError, match="no further"):
        cached("entry", make)
    assert names(cache) == []


@pytest.fixture
def aged(cache, monkeypatch):
    """Return a function that stores an entry as another process would have, a number of days ago."""

    def store(name, days):
        path = cached(name, Maker())
        monkeypatch.setattr(build_cache, "_used", build_cache._used - {path})
        os.utime(path, (time.time() - days * 86_400.0,) * 2)
        return path

    return store


def test_the_cache_does_not_grow_without_limit(cache, aged, monkeypatch):
    for name, days in (("oldest", 9), ("old", 5), ("middle", 3), ("recent", 0.5)):
        aged(name, days)
    (cache / "not ours").mkdir()
    (cache / "not ours" / "letter").write_bytes(bytes(9999))
    os.utime(cache / "not ours", (0, 0))
    size = sum(path.stat().st_size for path in (cache / "old").rglob("*"))
    assert size < 9999
    used = cached("middle", Maker())  # by this process, however long ago
    os.utime(used, (time.time() - 3 * 86_400.0,) * 2)
    monkeypatch.setattr(build_cache, "MAX_BYTES", 4 * size)
    cached("new", Maker())
    assert names(cache) == ["middle", "new", "not ours", "old", "recent"]
    monkeypatch.setattr(build_cache, "MAX_BYTES", 0)
    cached("newer", Maker())
    assert names(cache) == ["middle", "new", "newer", "not ours", "recent"]  # may be in use, here and elsewhere


def test_the_default_cache_is_that_of_the_user(monkeypatch, tmp_path):
    monkeypatch.delenv("TIREFMU_CACHE")
    if sys.platform.startswith("linux"):
        monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
        assert cache_folder() == tmp_path / "tirefmu"
        monkeypatch.delenv("XDG_CACHE_HOME")
        assert cache_folder() == Path.home() / ".cache" / "tirefmu"
    assert cache_folder().name == "tirefmu"
    monkeypatch.setenv("TIREFMU_CACHE", str(tmp_path / "named"))
    assert cache_folder() == tmp_path / "named"


# ------------------------------------------------------------------ printed code


def test_modified_generated_code_is_not_run(cache, monkeypatch, tmp_path):
    symbolic_model = model_named("mf61", with_library("mf61", ["speed_friction"], ()))
    calls = []

    def rendered(symbolic_model):  # the real code takes long
        calls.append(symbolic_model)
        return {f"numpy/{symbolic_model.name}.py": "def forces():\n    return 42\n"}

    monkeypatch.setattr(printed, "_render", lambda symbolic_model, jacobians: rendered(symbolic_model))

    def fresh():
        modules._module.cache_clear()
        return modules._module(symbolic_model, symbolic_model.name)

    assert fresh().forces() == fresh().forces() == 42
    assert len(calls) == 1
    (entry,) = cache.iterdir()
    trap = tmp_path / "trap"
    for suffix in (".py", ".pyc"):
        (entry / "numpy" / f"{symbolic_model.name}{suffix}").write_text(f"open({str(trap)!r}, 'w')\n", encoding="ascii")
        assert fresh().forces() == 42
    assert len(calls) == 3
    assert not trap.exists()
    modules._module.cache_clear()
