"""Hostile archives: rejected with one line before much is written, and no file remains."""

from __future__ import annotations

import random
import stat
import struct
import zipfile

import pytest

from tirefmu.boundary.errors import FmuError
from tirefmu.fmu.simulation import archive
from tirefmu.fmu.simulation.archive import unpacked

DESCRIPTION = b'<?xml version="1.0"?><fmiModelDescription fmiVersion="2.0"/>'


@pytest.fixture
def temporary(tmp_path, monkeypatch):
    """Return the folder of temporary files; it is empty in the end."""
    folder = tmp_path / "temporary"
    folder.mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(folder))
    yield folder
    assert list(folder.iterdir()) == []


@pytest.fixture
def packed(tmp_path):
    """Return a function that packs entries, (name or ZipInfo, content), with a model description before them."""

    def pack(*entries, description=DESCRIPTION):
        path = tmp_path / "some.fmu"
        with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as file:
            if description is not None:
                file.writestr("modelDescription.xml", description)
            for entry, content in entries:
                file.writestr(entry, content)
        return path

    return pack


def refused(path, message):
    with pytest.raises(FmuError, match=message) as caught, unpacked(path):
        pass
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 1000


def test_files_and_folders_survive_a_round_trip(packed, temporary):
    path = packed(("binaries/", b""), ("binaries/linux64/a.so", b"code"), ("documentation/Größe (2).html", b""))
    with unpacked(path) as folder:
        assert folder.parent == temporary
        assert (folder / "modelDescription.xml").read_bytes() == DESCRIPTION
        assert (folder / "binaries" / "linux64" / "a.so").read_bytes() == b"code"
        assert (folder / "documentation" / "Größe (2).html").is_file()


@pytest.mark.parametrize(
    "name",
    [
        "../evil", "a/../../evil", "/evil", "C:/evil", "C:evil", "..\\evil", "a\\b", ".", "a/./b", "a//b", "", "a\n",
        "a\x1b[2J", "a" * 251, "a/..",
    ],
)  # fmt: skip
def test_a_name_outside_the_folder(packed, temporary, tmp_path, name):
    path = packed((zipfile.ZipInfo(name or "?"), b"evil"))
    if not name:
        path.write_bytes(path.read_bytes().replace(b"?", b"/"))
    before = sorted(tmp_path.rglob("*"))
    refused(path, r"some\.fmu: not a readable FMU \(the file name '.*' is not allowed\)")
    assert sorted(tmp_path.rglob("*")) == before


def test_a_name_with_a_zero_byte(packed, temporary):
    path = packed(("resources/harmless@evil", b""))
    path.write_bytes(path.read_bytes().replace(b"harmless@", b"harmless\0"))
    refused(path, r"'resources/harmless\\x00evil' is not allowed")


@pytest.mark.parametrize(
    ("names", "message"),
    [
        (["link"], "'link' is a link or a device"),
        (["link", "link/file"], "'link' is a link or a device"),
        (["link", "link"], "'link' is a link or a device"),
    ],
)
@pytest.mark.parametrize("kind", [stat.S_IFLNK, stat.S_IFIFO, stat.S_IFCHR])
@pytest.mark.filterwarnings("ignore:Duplicate name")
def test_links_and_devices(packed, temporary, kind, names, message):
    entry = zipfile.ZipInfo(names[0])
    entry.external_attr = (kind | 0o777) << 16
    refused(packed((entry, b"/etc"), *((name, b"") for name in names[1:])), message)


@pytest.mark.parametrize(
    "names",
    [
        ["a", "a"], ["resources/a", "resources/A"], ["resources/a", "Resources/b"], ["a", "a/b"], ["a/b", "a"],
        ["modeldescription.xml"], ["e\u0301", "\u00e9"], ["stra\u00dfe", "strasse"],
    ],
)  # fmt: skip
@pytest.mark.filterwarnings("ignore:Duplicate name")
def test_names_that_are_one_on_some_system(packed, temporary, names):
    refused(packed(*((name, b"") for name in names)), "is a duplicate, or differs from another name only by case")


def test_encrypted_entries_and_rare_compression(packed, temporary):
    path = packed(("secret", b"123"))
    content = bytearray(path.read_bytes())
    position = content.rindex(b"PK\x01\x02")
    content[position + 8] |= 1
    path.write_bytes(content)
    refused(path, "'secret' is encrypted")
    entry = zipfile.ZipInfo("packed")
    entry.compress_type = zipfile.ZIP_LZMA
    refused(packed((entry, b"123")), "'packed' is compressed by another method")


def test_a_bomb_is_refused_before_anything_is_written(packed, temporary, monkeypatch):
    monkeypatch.setattr(archive, "_unpack", lambda *_: pytest.fail("unpacked"))
    path = packed(("bomb", b""))
    content = bytearray(path.read_bytes())
    position = content.rindex(b"PK\x01\x02")
    struct.pack_into("<I", content, position + 24, 1_000_000_000)
    path.write_bytes(content)
    refused(path, r"'bomb' has 1,000 MB when unpacked; at most 100 MB")
    many = [(f"resources/{i}", b"") for i in range(3)]
    content = bytearray(packed(*many).read_bytes())
    position = content.index(b"PK\x01\x02")
    while (position := content.find(b"PK\x01\x02", position + 1)) > 0:
        struct.pack_into("<I", content, position + 24, 90_000_000)
    path.write_bytes(content)
    refused(path, r"more than 200 MB when unpacked")


def test_a_false_size(packed, temporary, monkeypatch):
    """The entry declares 10 bytes and has 100,000: no more than declared is written."""
    path = packed(("liar", bytes(100_000)))
    content = bytearray(path.read_bytes())
    position = content.rindex(b"PK\x01\x02")
    struct.pack_into("<I", content, position + 24, 10)
    path.write_bytes(content)
    refused(path, "Bad CRC-32")


def test_unpacked_bytes_are_counted(packed, temporary, monkeypatch):
    path = packed(("large", bytes(100_000)))
    monkeypatch.setattr(archive, "_check", lambda _: None)
    monkeypatch.setattr(archive, "MAX_BYTES", 50_000)
    refused(path, "it has more than 0 MB when unpacked")


def test_too_many_files(packed, temporary, monkeypatch):
    path = packed(*((str(i), b"") for i in range(10)))
    monkeypatch.setattr(archive, "MAX_ENTRIES", 11)
    with unpacked(path):
        pass
    monkeypatch.setattr(archive, "MAX_ENTRIES", 10)
    monkeypatch.setattr(archive.zipfile, "ZipFile", lambda *_: pytest.fail("read"))
    refused(path, r"some\.fmu: more than 10 files")


def test_too_large_a_file(packed, temporary, monkeypatch):
    path = packed()
    monkeypatch.setattr(archive, "MAX_BYTES", path.stat().st_size - 1)
    refused(path, r"some\.fmu: cannot be read \(larger than \S+ MB\)")


LAUGHS = "".join(f'<!ENTITY l{i + 1} "{f"&l{i};" * 10}">' for i in range(9))


@pytest.mark.parametrize(
    ("description", "message"),
    [
        (None, "it has no modelDescription.xml"),
        (b"", "no element found"),
        (b"\x00\x01", "not well-formed"),
        (f'<!DOCTYPE a [<!ENTITY l0 "ha">{LAUGHS}]><a>&l9;</a>'.encode(), r"has a document type \(DOCTYPE\)"),
        (f'<!DOCTYPE a [<!ENTITY l0 "ha">{LAUGHS}]><a>&l9;</a>'.encode("utf-16"), r"has a document type \(DOCTYPE\)"),
        (b'<!DOCTYPE a SYSTEM "file:///etc/passwd"><a/>', r"has a document type \(DOCTYPE\)"),
    ],
)
def test_a_broken_model_description(packed, temporary, description, message):
    refused(packed(description=description), message)


def test_a_huge_model_description(packed, temporary, monkeypatch):
    monkeypatch.setattr(archive, "LARGEST_DESCRIPTION", 50)
    refused(packed(), r"'modelDescription\.xml' has 0 MB when unpacked")


def test_a_file_that_cannot_be_read(packed, temporary, monkeypatch):
    def broken(*_):
        raise OSError(5, "Input/output error")

    path = packed()
    monkeypatch.setattr(type(path), "open", broken)
    refused(path, r"some\.fmu: cannot be read \(Input/output error\)")


def test_any_damage_is_one_line(packed, temporary):
    code = random.Random(1).randbytes(300)
    path = packed(("binaries/linux64/a.so", code), ("resources/", b""), ("resources/b", b"1" * 999))
    content, errors = path.read_bytes(), []
    for seed in range(400):
        draw = random.Random(seed)
        damaged = bytearray(content)
        for _ in range(draw.choice([1, 2, 5])):
            damaged[draw.randrange(len(damaged))] = draw.randrange(256)
        if draw.random() < 0.2:
            del damaged[draw.randrange(len(damaged)) :]
        path.write_bytes(damaged)
        try:
            with unpacked(path):
                pass
        except FmuError as error:
            errors.append(str(error))
    assert 0 < len(errors) < 400
    assert all(error.isprintable() for error in errors)
