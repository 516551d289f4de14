"""Who reaches the window: its own page with the token; no other page, name, host or path."""

from __future__ import annotations

import pytest

from .conftest import ORIGIN, PORT, SOCKET, TOKEN

pytest.importorskip("starlette", reason="the extra studio is not installed")
from starlette.websockets import WebSocketDisconnect

OTHER = [
    {"origin": "http://example.org"},
    {"origin": f"http://127.0.0.1:{PORT + 1}"},
    {"origin": f"http://localhost:{PORT}"},  # the page was opened by its number
    {"origin": f"https://127.0.0.1:{PORT}"},
    {"origin": "null"},
    {"origin": ORIGIN, "host": "example.org"},
    {"origin": ORIGIN, "host": f"127.0.0.1.example.org:{PORT}"},
    {"origin": ORIGIN, "host": "127.0.0.1"},
]


def test_the_page_is_served_with_a_strict_policy(window):
    answer = window.client.get(f"/{TOKEN}/")
    assert answer.status_code == 200
    policy = answer.headers["content-security-policy"]
    assert "default-src 'none'" in policy
    assert "unsafe" not in policy
    assert "frame-ancestors 'none'" in policy
    assert answer.headers["referrer-policy"] == "no-referrer"
    for name in ("studio.js", "studio.css"):
        assert window.client.get(f"/{TOKEN}/{name}").status_code == 200


@pytest.mark.parametrize("path", ["/", "/token", "/tokem/", "/other/", "//token/", "/%74oken/"])
def test_without_the_token_nothing_is_served(window, path):
    answer = window.client.request("GET", f"{ORIGIN}{path}")
    assert answer.status_code in (403, 404)
    assert "studio" not in answer.text


@pytest.mark.parametrize("headers", OTHER)
def test_other_origins_and_hosts_are_refused(window, headers):
    assert window.client.get(f"/{TOKEN}/", headers=headers).status_code == 403
    before = window.state.text()
    answer = window.client.post(f"/{TOKEN}/upload/a.csv", content=b"alpha\n0\n", headers=headers)
    assert answer.status_code == 403
    assert window.state.text() == before
    with (
        pytest.raises(WebSocketDisconnect),
        window.client.websocket_connect(SOCKET, headers=headers) as socket,
    ):
        socket.receive_text()


def test_what_changes_something_needs_an_origin(window):
    assert window.client.post(f"/{TOKEN}/upload/a.csv", content=b"x").status_code == 403
    with pytest.raises(WebSocketDisconnect), window.client.websocket_connect(SOCKET) as socket:
        socket.receive_text()


def test_only_results_are_served_and_reports_are_sandboxed(window):
    results = window.state.folder / "results"
    results.mkdir()
    (results / "fit.html").write_text("<p>report")
    (results / "run.json").write_text("{}")
    (window.state.folder / "secret.txt").write_text("secret")
    (results / "link.txt").symlink_to(window.state.folder / "secret.txt")
    answer = window.client.get(f"/{TOKEN}/results/fit.html")
    assert answer.headers["content-security-policy"].startswith("sandbox allow-scripts")
    assert "allow-same-origin" not in answer.headers["content-security-policy"]
    assert "attachment" in window.client.get(f"/{TOKEN}/results/run.json").headers["content-disposition"]
    for path in ("link.txt", "..%2Fsecret.txt", "../secret.txt", "%2Fetc%2Fpasswd", "nothing", "%00", "a" * 5000):
        answer = window.client.get(f"/{TOKEN}/results/{path}")
        assert answer.status_code in (403, 404), path
        assert "secret" not in answer.text
    assert window.client.get(f"/{TOKEN}/code/..%2Fx.js").status_code == 404
