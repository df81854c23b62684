"""Serves the page on this machine only."""

from __future__ import annotations

import functools
import inspect
import logging
import os
import signal
import socket
import threading
import webbrowser
from collections.abc import Callable
from contextlib import suppress
from types import FrameType

from squama.errors import InputError, refuse
from squama.web import aside
from squama.web.state import State

HOST = "127.0.0.1"
TITLE = "squama explorer"


def free_port(port: int | None) -> int:
    """Return a free port: the given one, or any.

    Raises InputError where the given port is taken or not permitted.
    """
    with socket.socket() as trial:
        # a port that was closed a moment ago is free
        trial.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            trial.bind((HOST, port or 0))
        except OSError:
            remedy = "give another one, or none for any that is free"
            refuse(f"--port {port}", "", "is taken or may not be used", remedy)
        return int(trial.getsockname()[1])


def serve(start: State, port: int, *, browser: bool, ready: Callable[[str], None]) -> None:
    """Serve the page at a port (see `free_port`) until it is interrupted; ``start``: state without a link.

    ``browser``: whether to open a browser; ``ready`` is called with the address, its secret included, once it can be
    opened.
    """
    import uvicorn
    from fastapi import FastAPI
    from fastapi.responses import PlainTextResponse
    from nicegui import app, core, ui
    from threadpoolctl import threadpool_limits

    from squama.web import map  # noqa: A004 - the module is named after what it draws
    from squama.web.guard import MOST, TOKEN, Guard, Patient
    from squama.web.memory import Sweep, make_room
    from squama.web.page import LINKING, Explorer

    async def page() -> None:
        make_room()
        state, notice = start, ""
        if query := ui.context.client.request.url.query:
            try:
                state = await LINKING(query)
            except (InputError, TimeoutError) as error:
                why = str(error) if isinstance(error, InputError) else f"reading it took longer than {LINKING.limit} s"
                notice = f"The link cannot be used, so the first design is shown.\n{why}"
        Explorer(state, notice)

    ui.page("/", title=TITLE, response_timeout=20)(page)
    # NiceGUI's own would be a page that stays in memory
    app.add_exception_handler(404, lambda *_: PlainTextResponse("There is nothing here.\n", 404))
    outer = FastAPI(openapi_url=None)
    guard = Guard(outer, port)
    address = f"http://{HOST}:{port}/?{TOKEN}={guard.secret}"

    app.on_startup(map.warm_up)
    # unreadable messages of socket.io or NiceGUI are dropped, because each would print a traceback
    logging.getLogger("engineio.server").setLevel(logging.CRITICAL)
    handlers = core.sio.handlers["/"]
    # a connection is refused by an exception
    handlers |= {name: _borne(handlers[name]) for name in handlers.keys() - {"connect"}}
    app.on_delete(Sweep().soon)
    ui.run_with(
        outer, title=TITLE, favicon=ICON, tailwind=False, show_welcome_message=False, dark=None, language="en-US"
    )

    class Server(uvicorn.Server):
        """Tells when it listens, and ends soon after it is asked to, whatever is computed."""

        async def startup(self, sockets: list[socket.socket] | None = None) -> None:
            await super().startup(sockets)
            ready(address)
            if browser:
                threading.Thread(target=webbrowser.open, args=[address], daemon=True).start()

        def handle_exit(self, sig: int, frame: FrameType | None) -> None:
            super().handle_exit(sig, frame)
            last = threading.Timer(5.0, os._exit, [128 + sig])
            last.daemon = True
            last.start()

    config = uvicorn.Config(
        guard,
        host=HOST,
        port=port,
        http=Patient,
        ws="wsproto",
        # bytes of a request's head and of a message, connections, seconds for running requests at the end
        h11_max_incomplete_event_size=2**16,
        ws_max_size=2**20,
        limit_concurrency=MOST,
        timeout_graceful_shutdown=1,
        proxy_headers=False,
        server_header=False,
        # invalid requests must not fill the terminal
        log_level="error",
    )
    try:
        # the browser uses the other cores: waiting for a second thread of BLAS takes longer than the work
        with threadpool_limits(1, user_api="blas"):
            Server(config).run()
    finally:
        if aside.busy():
            # a running thread in compiled code would make the interpreter abort at its end
            os._exit(128 + signal.SIGINT)


def _borne(handler: Callable[..., object]) -> Callable[..., object]:
    """Return a message handler that ignores its exceptions; actions of the user have their own handlers inside."""

    @functools.wraps(handler)
    async def bear_it(*given: object) -> object:
        with suppress(Exception):
            found = handler(*given)
            return await found if inspect.isawaitable(found) else found
        return None

    return bear_it


ICON = (
    '<svg viewBox="0 0 16 16" xmlns="http://www.w3.org/2000/svg"><path d="M1 13h14" stroke="#7a7a7a" stroke-width="3"/>'
    '<path d="M2 11 9 4M6 11l7-7M10 11l5-5" stroke="#0b62a8" stroke-width="2"/></svg>'
)
