"""Error messages."""

from __future__ import annotations

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tirefmu.boundary import errors
from tirefmu.boundary.errors import TirefmuError, UnknownName, nearest

MANY = [f"name_{number:02d}" for number in range(30)]


@pytest.mark.parametrize(
    ("name", "valid", "end"),
    [
        ("PDYI", ["PDY1", "PKX1"], ": did you mean PDY1? Known are PDY1, PKX1"),
        ("fz", ["Fx", "Fz"], ": did you mean Fz? Known are Fx, Fz"),
        ("fz", ["Fz"], ": did you mean Fz?"),
        ("nothing like it", ["a", "b"], ": known are a, b"),
        ("zz", MANY, f": known are {', '.join(MANY[: errors.FEW])}; 30 are known"),
        ("anything", [], ""),
    ],
)
def test_nearest_names(name, valid, end):
    assert nearest(name, valid) == end


@given(name=st.text(max_size=12), valid=st.lists(st.from_regex(r"[a-z]{1,8}", fullmatch=True), unique=True))
def test_a_message_has_every_known_name_or_their_number(name, valid):
    for listed_by in ("", "tirefmu list"):
        end = nearest(name, valid, listed_by)
        if len(valid) <= errors.FEW:
            assert all(re.search(rf"\b{candidate}\b", end) for candidate in valid)
        else:
            assert str(len(valid)) in end
            assert listed_by in end
    assert len(nearest(name, [candidate * 3 for candidate in valid] * 2)) < 40 * (errors.FEW + 2)


def test_an_unknown_name_has_its_attributes_and_what_lists_many():
    error = UnknownName("effect", "cambr", iter(["camber"]))
    assert (error.kind, error.name, error.known) == ("effect", "cambr", ("camber",))
    assert str(error) == "unknown effect 'cambr': did you mean camber?"
    many = [f"PDY{i}" for i in range(20)]
    message = str(UnknownName("coefficient of mf96", "PDYI", many))
    assert message.startswith("unknown coefficient of mf96 'PDYI': did you mean PDY")
    assert message.count("PDY") == 5  # the name as given and the four nearest
    assert message.endswith("; tirefmu info TIRE --all lists all 20")
    assert str(UnknownName("effect", "zzz", many)) == "unknown effect 'zzz': tirefmu effects lists all 20"


def test_every_error_is_a_misuse_of_tirefmu():
    kinds = [kind for kind in vars(errors).values() if isinstance(kind, type) and issubclass(kind, Exception)]
    kinds = [kind for kind in kinds if not issubclass(kind, Warning)]
    assert len(kinds) >= 7
    assert all(issubclass(kind, TirefmuError) for kind in kinds)
