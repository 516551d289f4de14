"""The C compiler: a missing one gives one line, and libraries are built once."""

from __future__ import annotations

import ctypes
import hashlib
import shutil
import subprocess
import sys

import pytest

from tirefmu.tires.code.build_cache import RECORD
from tirefmu.tires.code.compiler import CompilerError, find_compiler, loaded_library, shared_library

needs_compiler = pytest.mark.skipif(
    not any(shutil.which(name) for name in ("cc", "gcc", "clang")), reason="no C compiler on this machine"
)


@pytest.fixture
def empty_cache(tmp_path, monkeypatch):
    folder = tmp_path / "cache" / "below"
    monkeypatch.setenv("TIREFMU_CACHE", str(folder))
    return folder


@pytest.fixture
def source(tmp_path):
    path = tmp_path / "answer.c"
    path.write_text('#include "answer.h"\nEXPORT int answer(void) { return ANSWER; }\n', encoding="ascii")
    write_header(path, 42)
    return path


def write_header(source, number):
    text = f'#define EXPORT __attribute__((visibility("default")))\n#define ANSWER {number}\nint answer(void);\n'
    source.with_suffix(".h").write_text(text, encoding="ascii")


def built(source, **options):
    return shared_library("answer", [source], headers=[source.with_suffix(".h")], **options)


@pytest.mark.parametrize("name", ["no-such-compiler", "no-such-compiler -O3", "'unclosed"])
def test_a_compiler_that_does_not_exist(monkeypatch, name):
    monkeypatch.setenv("CC", name)
    with pytest.raises(CompilerError) as caught:
        find_compiler()
    assert str(caught.value) == f"CC is {name!r}, which cannot be run"


@pytest.mark.parametrize("blank", ["", "  "])
@needs_compiler
def test_a_blank_name_is_none(monkeypatch, blank):
    monkeypatch.setenv("CC", blank)
    assert shutil.which(find_compiler()[0])


def test_no_compiler_at_all(monkeypatch, tmp_path):
    monkeypatch.delenv("CC", raising=False)
    monkeypatch.setenv("PATH", str(tmp_path))
    with pytest.raises(CompilerError, match=r"^no C compiler found: install gcc or clang, or set CC$"):
        find_compiler()


@needs_compiler
def test_a_compiler_named_with_options(monkeypatch, empty_cache, source):
    monkeypatch.setenv("CC", f"{find_compiler()[0]} -DUNUSED=1")
    assert find_compiler()[1:] == ["-DUNUSED=1"]
    assert ctypes.CDLL(str(built(source))).answer() == 42


@needs_compiler
def test_a_library_is_built_once(empty_cache, source, monkeypatch):
    path = built(source)
    assert path.parent.parent == empty_cache

    def never(*_):
        raise AssertionError("compiled again")

    monkeypatch.setattr(subprocess, "run", never)
    assert built(source) == path
    assert [entry.name for entry in empty_cache.iterdir()] == [path.parent.name]


@needs_compiler
def test_another_content_compiler_or_flag_is_another_library(empty_cache, source, monkeypatch):
    first = built(source)
    write_header(source, 43)
    second = built(source)
    assert first != second
    assert [ctypes.CDLL(str(path)).answer() for path in (first, second)] == [42, 43]
    third = built(source, flags=["-DUNUSED=1"])
    monkeypatch.setenv("CC", f"{find_compiler()[0]} -DUNUSED=2")
    assert len({first, second, third, built(source)}) == 4


@needs_compiler
def test_source_that_does_not_compile(empty_cache, source):
    source.write_text("int answer(void) { return }\n", encoding="ascii")
    with pytest.raises(CompilerError) as caught:
        built(source)
    assert "answer.c" in str(caught.value)
    assert "\n" not in str(caught.value)
    assert list(empty_cache.iterdir()) == []


@needs_compiler
@pytest.mark.skipif(not sys.platform.startswith("linux"), reason="only the linker of Linux can check this")
def test_an_undefined_function_is_found_when_linking(empty_cache, source):
    source.write_text("double missing(double); double answer(void) { return missing(1.0); }\n", encoding="ascii")
    with pytest.raises(CompilerError, match="missing"):
        built(source)


@needs_compiler
def test_the_errors_are_quoted_not_the_warnings_before_them(empty_cache, source):
    unused = "\n".join(f"static int unused_{i}(void) {{ return {i}; }}" for i in range(9))
    source.write_text(f"{unused}\nint answer(void) {{ return 42 }}\n", encoding="ascii")
    with pytest.raises(CompilerError, match=r"failed: .*error: expected .;.") as caught:
        built(source, flags=["-Wall"])
    assert "unused_0" not in str(caught.value)


def loaded(source):
    return loaded_library("answer", [source], headers=[source.with_suffix(".h")])


@needs_compiler
@pytest.mark.parametrize("damage", ["empty", "truncated", "changed", "link", "folder", "no record", "more"])
def test_a_damaged_library_is_built_again(empty_cache, source, tmp_path, damage):
    path = built(source)
    content = path.read_bytes()
    path.unlink()
    if damage == "empty":
        path.write_bytes(b"")
    elif damage == "truncated":
        path.write_bytes(content[: len(content) // 2])
    elif damage == "changed":
        path.write_bytes(content[:-1] + bytes([content[-1] ^ 1]))
    elif damage == "link":
        (tmp_path / "elsewhere").write_bytes(content)
        path.symlink_to(tmp_path / "elsewhere")
    elif damage == "folder":
        path.mkdir()
    else:
        path.write_bytes(content)
        record = path.with_name(RECORD)
        record.unlink() if damage == "no record" else path.with_name("more").write_bytes(b"")
    assert loaded(source).answer() == 42
    assert path.is_file()
    assert not path.is_symlink()
    assert path.read_bytes() == content
    assert [entry.name for entry in empty_cache.iterdir()] == [path.parent.name]


@needs_compiler
def test_a_library_that_cannot_be_loaded_is_built_again(empty_cache, source):
    path = built(source)
    content = b"as recorded, but for another machine"
    path.write_bytes(content)
    record = f"{hashlib.sha256(content).hexdigest()} {len(content)} {path.name}\n"
    path.with_name(RECORD).write_text(record, encoding="ascii")
    assert built(source).read_bytes() == content  # the cache cannot detect this
    assert loaded(source).answer() == 42


@needs_compiler
def test_a_library_that_never_loads_gives_one_line(empty_cache, source):
    with pytest.raises(CompilerError, match=r"answer\S* is built, but cannot be loaded: ") as caught:
        loaded_library("answer", [source], headers=[source.with_suffix(".h")], flags=["-c"])
    assert "\n" not in str(caught.value)
