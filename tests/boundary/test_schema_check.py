"""The check of files by their schemas: which values are refused, and the one line that says why."""

from __future__ import annotations

import pytest

from tirefmu.boundary.errors import DataError
from tirefmu.boundary.json_schema import document, list_schema, object_schema, one_of
from tirefmu.boundary.schema_check import check_content

SCHEMA = document("made", "1.0", "Made", object_schema({
    "rows": {"type": "integer", "minimum": 1, "maximum": 9},
    "share": float,
    "name": str,
    "signs": one_of(["iso", "sae"]),
    "jobs": list_schema(object_schema({"name": str, "sizes": dict[str, float]}, ["name"]), 1, 3),
    "value": float | list[str],
}))  # fmt: skip


@pytest.mark.parametrize("content", [
    {}, {"rows": 1, "share": 2, "signs": "sae", "value": ["a"]}, {"jobs": [{"name": "a", "sizes": {"b": 1.0}}]},
])  # fmt: skip
def test_valid_contents_pass(content):
    check_content(content, SCHEMA, "a.toml", DataError)


@pytest.mark.parametrize(("content", "message"), [
    ({"row": 1}, "a.toml: unknown key 'row': did you mean rows? "),
    ({"jobs": [{"nam": "a"}]}, "a.toml: unknown key 'nam' in jobs[1]: did you mean name? "),
    ({"jobs": [{}]}, "a.toml: name is missing in jobs[1]: it is a text"),
    ({"jobs": []}, "a.toml: jobs is []: expected a list of 1 to 3 tables"),
    ({"jobs": [{"name": "a", "sizes": {"x": True}}]}, "a.toml: jobs[1].sizes.x is true: expected a number"),
    ({"rows": 0}, "a.toml: rows is 0: expected a whole number of at least 1 and of at most 9"),
    ({"rows": 2.0}, "a.toml: rows is 2.0: expected a whole number"),
    ({"rows": True}, "a.toml: rows is true: expected a whole number"),
    ({"share": float("nan")}, "a.toml: share is nan: expected a number"),
    ({"share": float("-inf")}, "a.toml: share is -inf: expected a number"),
    ({"share": 10**400}, "a.toml: share is 1000"),
    ({"name": "a\0"}, "a.toml: name is 'a\\x00': expected a text"),
    ({"signs": "isso"}, "a.toml: unknown word 'isso' in signs: did you mean iso?"),
    ({"signs": 3}, "a.toml: signs is 3: expected one of iso, sae"),
    ({"value": {"a": 1}}, "a.toml: value is {a = 1}: expected a number or a list of texts"),
    ({"value": [1]}, "a.toml: value[1] is 1: expected a text"),
    ({"\x1b[2J\n": 1}, "a.toml: unknown key '\\x1b[2J\\x0a'"),
    ({"name": ["x" * 10**6] * 10}, "a.toml: name is ['xxx"),
])  # fmt: skip
def test_an_invalid_content_is_one_short_line(content, message):
    with pytest.raises(DataError) as caught:
        check_content(content, SCHEMA, "a.toml", DataError)
    assert str(caught.value).startswith(message)
    assert str(caught.value).isprintable()
    assert len(str(caught.value)) < 300
