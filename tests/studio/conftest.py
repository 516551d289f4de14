"""A project with a recording, and a window over it."""

from __future__ import annotations

import json
from types import SimpleNamespace

import pytest

from tirefmu.applications.project import project_text
from tirefmu.measurements import VirtualBench, alpha_sweeps, concatenate, kappa_sweeps, write_table
from tirefmu.tires import published

TOKEN, PORT = "token", 4567
ORIGIN = f"http://127.0.0.1:{PORT}"
SOCKET = f"ws://127.0.0.1:{PORT}/{TOKEN}/socket"


@pytest.fixture(scope="session")
def bench_file(tmp_path_factory):
    """Return a recording of sweeps at two loads, as a file."""
    program = concatenate([alpha_sweeps([440.0, 900.0], sample_rate=10.0), kappa_sweeps([700.0], sample_rate=10.0)])
    recording = VirtualBench(published("trento_hoosier"), seed=1).run(program).with_signs("iso")
    path = tmp_path_factory.mktemp("bench") / "run.csv"
    write_table(recording.table, path)
    return path


@pytest.fixture
def project(tmp_path, bench_file):
    """Return the path of a project file with a table in its folder."""
    folder = tmp_path / "work"
    folder.mkdir()
    (folder / "run.csv").write_bytes(bench_file.read_bytes())
    path = folder / "tirefmu.toml"
    path.write_text(project_text(["run.csv"], "mf96", {"Fz0": 700.0, "R0": 0.23}, None, None))
    return path


class Page:
    """Stands for a page: sends messages and returns their results."""

    def __init__(self, websocket):
        self.websocket, self.events = websocket, []

    def call(self, name, **content):
        """Return the whole answer; events before it are kept."""
        self.websocket.send_text(json.dumps({"do": name, "id": 1, **content}))
        while True:
            answer = self.websocket.receive_json()
            if "event" not in answer:
                return answer
            self.events.append(answer)

    def result(self, name, **content):
        answer = self.call(name, **content)
        assert "error" not in answer, answer
        return answer["result"]

    def edit(self, name, **content):
        return self.call(name, version=self.result("state")["version"], **content)


@pytest.fixture
def window(project):
    """Return a server over the project: `client`, `page`, `state`; its processes are not started."""
    client_of = pytest.importorskip("starlette.testclient", reason="the extra studio is not installed").TestClient
    from tirefmu.applications.studio import ProjectState, Server

    state = ProjectState(project)
    server = Server(state, TOKEN, PORT)
    client = client_of(server.app, base_url=ORIGIN)
    with client.websocket_connect(SOCKET, headers={"origin": ORIGIN}) as websocket:
        yield SimpleNamespace(client=client, page=Page(websocket), state=state, server=server)
