"""The project file of the window: changes are in the file, can be undone, and are refused if stale or wrong."""

from __future__ import annotations

import pytest

from tirefmu.boundary.errors import TirefmuError
from tirefmu.commands.cli import main

pytest.importorskip("tomlkit", reason="the extra studio is not installed")
from tirefmu.applications.studio import ProjectState, Stale


@pytest.fixture
def state(project):
    return ProjectState(project)


def changed(state, section, key, value):
    state.set_value(state.version(), section, key, value)


def test_a_change_is_a_line_of_the_file_and_undo_restores_the_text(state):
    texts = [state.text()]
    for section, key, value in (
        ("fit", "effects", ["load_friction", "camber_thrust"]),
        ("data", "exclude", ['file == "run.csv" and sample in 3..9']),
        ("fit", "nominal", {"Fz0": 650.5, "R0": 0.23}),
        ("check", "tolerance", 0.05),
        ("fit", "effects", None),
    ):
        changed(state, section, key, value)
        assert state.project().get(section, key) == value
        texts.append(state.text())
    assert "# tirefmu run: inspects" in texts[-1]  # remarks remain
    again = ProjectState(state.path)
    for text in reversed(texts[:-1]):
        again.undo(again.version())
        assert again.text() == text
    with pytest.raises(TirefmuError, match="no earlier change"):
        again.undo(again.version())


def test_undo_ignores_a_change_that_was_not_written(state):
    """The program may end between the earlier text and the new one."""
    first = state.text()
    changed(state, "fit", "model", "mf61")
    (state.history / "000002.toml").write_text(state.text())
    state.undo(state.version())
    assert state.text() == first


def test_a_stale_change_is_refused(state):
    version = state.version()
    changed(state, "fit", "model", "mf61")
    text = state.text()
    for change in (lambda: state.set_value(version, "fit", "model", "mf52"), lambda: state.undo(version),
                   lambda: state.set_tables(version, [])):  # fmt: skip
        with pytest.raises(Stale, match="present state"):
            change()
    assert state.text() == text


@pytest.mark.parametrize(
    ("section", "key", "value"),
    [
        ("fit", "effects", "load_friction"),
        ("fit", "nominal", {"Fz0": "a"}),
        ("fit", "nominal", {"Fz0": float("nan")}),
        ("data", "exclude", ["sample in"]),
        ("data", "exclude", [3]),
        ("fit", "model", 3),
        ("fit", "model", "a\0b"),
        ("output", "folder", "/tmp"),
        ("data", "tables", ["/etc/passwd"]),
        ("fit", "start", "/etc/passwd"),
        ("fit", "recipe", "../outside.toml"),
        ("data", "where", "../outside.toml"),
        ("export", "proof", "../outside.toml"),
        ("fit", "effects", [[[[["deep"]]]]]),
        ("fit", "loss", {"a": {"b": [None]}}),
    ],
)
def test_a_wrong_change_leaves_the_file_as_it_is(state, section, key, value):
    (state.folder.parent / "outside.toml").write_text("secret")
    text = state.text()
    with pytest.raises(TirefmuError):
        changed(state, section, key, value)
    assert state.text() == text
    assert state.undoable() == 0


def test_unknown_keys_have_the_nearest_name(state):
    with pytest.raises(TirefmuError, match="did you mean effects"):
        changed(state, "fit", "efects", [])
    with pytest.raises(TirefmuError, match="did you mean fit"):
        changed(state, "fitt", "effects", [])


def test_tables_outside_the_folder_are_those_that_the_user_named(state, bench_file):
    with pytest.raises(TirefmuError, match="outside"):
        state.set_tables(state.version(), ["run.csv", str(bench_file)])
    state.add_named([str(bench_file)])
    assert state.project().get("data", "tables") == ["run.csv", str(bench_file)]
    state.set_tables(state.version(), [str(bench_file)])
    assert state.project().get("data", "tables") == [str(bench_file)]


def test_a_new_project_has_no_table_and_its_schema_beside_it(tmp_path, bench_file, monkeypatch):
    """The first line of the file, and the schema, are those that `tirefmu init` writes."""
    served = []
    monkeypatch.setattr("tirefmu.applications.studio.serve.serve", lambda state, opened: served.append(state))
    for name in ("window", "command"):
        (tmp_path / name).mkdir()
    monkeypatch.chdir(tmp_path / "window")
    assert main(["studio", "--no-browser"]) == 0
    assert served[0].project().get("data", "tables") == []
    assert main(["init", str(bench_file), "-o", str(tmp_path / "command" / "tirefmu.toml"), "--quiet"]) == 0
    names = ("tirefmu-project.schema.json", "tirefmu.toml")
    new, init = ([(tmp_path / folder / name).read_text() for name in names] for folder in ("window", "command"))
    assert new[0] == init[0]
    assert new[1].splitlines()[0] == init[1].splitlines()[0] == "#:schema ./tirefmu-project.schema.json"
    text = served[0].text()
    assert main(["studio", "--no-browser"]) == 0
    assert served[1].text() == text
