"""The server of the window: on the loopback interface, with a random token in its address."""

from __future__ import annotations

import asyncio
import json
import os
import secrets
import socket
import tempfile
from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from importlib.resources import files
from pathlib import Path
from typing import Any

import uvicorn
from filelock import FileLock, Timeout
from starlette.applications import Starlette
from starlette.exceptions import HTTPException
from starlette.requests import Request
from starlette.responses import FileResponse, PlainTextResponse, Response
from starlette.routing import Route, WebSocketRoute
from starlette.websockets import WebSocket, WebSocketDisconnect

from ...boundary.errors import TirefmuError
from ...boundary.escaping import excerpt
from ...drawing.chart_library import LIBRARY_SCRIPT, LIBRARY_STYLE, library_file
from ...drawing.page import style_sheet
from .guard import LOOPBACK, REPORT_POLICY, Guard
from .project_state import FOLDER, ProjectState
from .window import Window

#: Upper limits of an uploaded file and of a message, bytes.
MAX_UPLOAD, MAX_MESSAGE = 500_000_000, 1_000_000
#: Scripts of the page in their order: those of the page with sliders come first.
EXPLORER_SCRIPTS = ("tire_state.js", "measured_rows.js", "curves.js", "charts.js", "controls.js")
SCRIPTS = (
    "connection.js", "time_chart.js", "curve_charts.js", "data_tab.js", "fit_tab.js", "compare_tab.js",
    "result_tabs.js", "studio.js",
)  # fmt: skip


class Server:
    """The routes of a window."""

    def __init__(self, state: ProjectState, token: str, port: int) -> None:
        self.window = Window(state, self._send)
        self._sockets: set[WebSocket] = set()
        routes = [
            Route("/{token}/", self._page),
            Route("/{token}/studio.js", self._script),
            Route("/{token}/studio.css", self._style),
            Route("/{token}/code/{digest}.js", self._code),
            Route("/{token}/results/{path:path}", self._result),
            Route("/{token}/upload/{name}", self._upload, methods=["POST"]),
            WebSocketRoute("/{token}/socket", self._socket),
        ]
        app = Starlette(routes=routes, lifespan=self._lifespan)
        self.app = Guard(app, token, port)

    @asynccontextmanager
    async def _lifespan(self, app: Starlette) -> AsyncIterator[None]:
        watching = asyncio.create_task(self.window.watch())
        await self.window.work.prepare()
        try:
            yield
        finally:
            watching.cancel()
            await self.window.work.close()

    async def _send(self, event: dict[str, Any]) -> None:
        text = json.dumps(event, allow_nan=False)
        for connection in list(self._sockets):
            try:
                await connection.send_text(text)
            except (RuntimeError, WebSocketDisconnect):  # closed meanwhile
                self._sockets.discard(connection)

    async def _socket(self, websocket: WebSocket) -> None:
        await websocket.accept()
        self._sockets.add(websocket)
        try:
            while True:
                message = await websocket.receive()
                if message["type"] == "websocket.disconnect":
                    return
                text = message.get("text")
                answer = await self.window.answer(text if text is not None else "")
                await websocket.send_text(answer)
        except (RuntimeError, WebSocketDisconnect):  # closed meanwhile
            return
        finally:
            self._sockets.discard(websocket)

    async def _page(self, request: Request) -> Response:
        return Response(_file("tirefmu.applications.studio", "page.html"), media_type="text/html")

    async def _script(self, request: Request) -> Response:
        parts = [
            library_file(LIBRARY_SCRIPT),
            *(_file("tirefmu.applications.explorer", name) for name in EXPLORER_SCRIPTS),
        ]
        return Response("\n".join([*parts, *(_file("tirefmu.applications.studio", name) for name in SCRIPTS)]),
                        media_type="text/javascript")  # fmt: skip

    async def _style(self, request: Request) -> Response:
        parts = [library_file(LIBRARY_STYLE), style_sheet(), _file("tirefmu.applications.explorer", "style.css")]
        return Response("\n".join([*parts, _file("tirefmu.applications.studio", "style.css")]), media_type="text/css")

    async def _code(self, request: Request) -> Response:
        module = self.window.tires.code.get(request.path_params["digest"])
        if module is None:
            raise HTTPException(404)
        return Response(module, media_type="text/javascript")

    async def _result(self, request: Request) -> Response:
        folder = Path(os.path.realpath(self.window.state.project().folder))
        try:
            path = Path(os.path.realpath(folder / request.path_params["path"]))
            inside = path.is_relative_to(folder) and path.is_file()
        except (OSError, ValueError):
            inside = False
        if not inside:
            raise HTTPException(404)
        if path.suffix == ".html":
            return FileResponse(path, headers={"content-security-policy": REPORT_POLICY})
        return FileResponse(path, media_type="application/octet-stream", filename=path.name)

    async def _upload(self, request: Request) -> Response:
        size = 0
        handle, name = tempfile.mkstemp(dir=self.window.state.folder / FOLDER, suffix=".part")
        try:
            with os.fdopen(handle, "wb") as file:
                async for chunk in request.stream():
                    size += len(chunk)
                    if size > MAX_UPLOAD:
                        raise TirefmuError(f"the file is larger than {MAX_UPLOAD / 1e6:g} MB")
                    file.write(chunk)
            added = await self.window.add_table(request.path_params["name"], Path(name))
        except (TirefmuError, OSError) as error:
            return PlainTextResponse(excerpt(error), status_code=400)
        finally:
            Path(name).unlink(missing_ok=True)
        return PlainTextResponse(added)


def serve(state: ProjectState, opened: Callable[[str], None]) -> None:
    """Serve the window of a project until it is interrupted.

    `opened`: called with the address when the server accepts connections. Raises `TirefmuError` if another window
    serves the project.
    """
    lock = FileLock(state.folder / FOLDER / "lock", timeout=0)
    try:
        lock.acquire()
    except Timeout:
        raise TirefmuError(f"{state.folder}: another tirefmu studio serves this project: use its address") from None
    with lock, socket.socket(socket.AF_INET, socket.SOCK_STREAM) as listener:
        listener.bind((LOOPBACK, 0))
        port, token = listener.getsockname()[1], secrets.token_urlsafe(24)
        config = uvicorn.Config(
            Server(state, token, port).app, log_level="warning", access_log=False, server_header=False,
            date_header=False, ws_max_size=MAX_MESSAGE, timeout_graceful_shutdown=2,
        )  # fmt: skip
        listener.listen()
        opened(f"http://{LOOPBACK}:{port}/{token}/")
        uvicorn.Server(config).run(sockets=[listener])


def _file(package: str, name: str) -> str:
    return (files(package) / "browser" / name).read_text(encoding="utf-8")
