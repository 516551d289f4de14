"""Who may talk to the window: a request with its token, from its own page, on the loopback interface."""

from __future__ import annotations

from hmac import compare_digest
from typing import Any

from starlette.types import ASGIApp, Message, Receive, Scope, Send

#: Address of the loopback interface.
LOOPBACK = "127.0.0.1"
#: Methods that change nothing: a browser sends no origin with them.
READING = ("GET", "HEAD")
#: What the page may load: its own files, data images, nothing else. Reports of steps are sandboxed: their scripts have
#: no origin and reach neither the window nor another page.
POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src 'self' {socket}; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
REPORT_POLICY = (
    "sandbox allow-scripts allow-downloads; default-src 'none'; script-src 'unsafe-inline'; "
    "style-src 'unsafe-inline'; img-src data:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)


class Guard:
    """An application that passes on the requests of the window's own page and refuses all others.

    `token`: first part of every path. `port`: of the server; host and origin are compared with it, so that neither a
    page of another site nor a name that leads to the loopback interface (DNS rebinding) reaches the application.
    """

    def __init__(self, app: ASGIApp, token: str, port: int) -> None:
        self._app, self._start = app, f"/{token}/".encode()
        self._hosts = {f"{name}:{port}".encode() for name in (LOOPBACK, "localhost")}
        policy = POLICY.format(socket=" ".join(f"ws://{host.decode()}" for host in sorted(self._hosts)))
        self._headers = [
            (b"content-security-policy", policy.encode()),
            (b"x-content-type-options", b"nosniff"),
            (b"referrer-policy", b"no-referrer"),
            (b"cross-origin-resource-policy", b"same-origin"),
            (b"cross-origin-opener-policy", b"same-origin"),
            (b"cache-control", b"no-store"),
        ]

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Handle a request."""
        if scope["type"] == "websocket" and not self._permits(scope):
            await receive()
            await send({"type": "websocket.close", "code": 1008})
        elif scope["type"] == "http" and not self._permits(scope):
            await self._with_headers({"type": "http.response.start", "status": 403, "headers": []}, send)
            await send({"type": "http.response.body", "body": b"refused\n"})
        elif scope["type"] == "http":
            await self._app(scope, receive, lambda message: self._with_headers(message, send))
        else:
            await self._app(scope, receive, send)

    def _permits(self, scope: Scope) -> bool:
        hosts, origins = (_values(scope, name) for name in (b"host", b"origin"))
        if len(hosts) != 1 or hosts[0] not in self._hosts:
            return False
        reads = scope["type"] == "http" and scope["method"] in READING
        if origins != [b"http://" + hosts[0]] and not (reads and not origins):
            return False
        path: bytes = scope.get("raw_path") or b""
        return compare_digest(path[: len(self._start)], self._start)

    async def _with_headers(self, message: Message, send: Send) -> None:
        if message["type"] == "http.response.start":
            given = {name.lower() for name, _ in message["headers"]}
            message["headers"] = [*message["headers"], *(header for header in self._headers if header[0] not in given)]
        await send(message)


def _values(scope: Scope, name: bytes) -> list[Any]:
    return [value for key, value in scope["headers"] if key.lower() == name]
