"""Serves the page on this machine only."""

from __future__ import annotations

import asyncio
import socket
from collections.abc import Callable

from squama.errors import InputError, refuse
from squama.web.state import State, read

HOST = "127.0.0.1"
TITLE = "squama explorer"


def free_port(port: int | None) -> int:
    """Return a port that can be had: the asked one, or any.

    Raises InputError: the asked port is taken or may not be used.
    """
    with socket.socket() as trial:
        # a port whose last page was closed a moment ago is free
        trial.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            trial.bind((HOST, port or 0))
        except OSError:
            remedy = "give another one, or none for any that is free"
            refuse(f"--port {port}", "", "is taken or may not be used", remedy)
        return int(trial.getsockname()[1])


def serve(start: State, port: int, *, browser: bool, ready: Callable[[str], None]) -> None:
    """Show the page at a port (see `free_port`) until it is interrupted; ``start`` where its link says nothing else.

    ``browser``: whether to open one; ``ready`` is told the address when it can be opened.
    """
    from nicegui import app, background_tasks, ui

    from squama.web import map  # noqa: A004 - the module is named after what it draws
    from squama.web.page import Explorer

    def page() -> None:
        state, notice = start, ""
        query = ui.context.client.request.url.query
        if query:
            try:
                state = read(query)
            except InputError as error:
                notice = f"The link cannot be used, so the first design is shown.\n{error}"
        Explorer(state, notice)

    ui.page("/", title=TITLE)(page)

    async def announce() -> None:
        # the server listens a moment after it has started
        while True:
            try:
                _, writer = await asyncio.open_connection(HOST, port)
            except OSError:
                await asyncio.sleep(0.02)
                continue
            writer.close()
            ready(f"http://{HOST}:{port}/")
            return

    app.on_startup(lambda: background_tasks.create(announce()))
    app.on_startup(map.warm_up)
    ui.run(
        host=HOST,
        port=port,
        title=TITLE,
        favicon=ICON,
        show=browser,
        reload=False,
        tailwind=False,
        show_welcome_message=False,
        dark=None,
        language="en-US",
    )


ICON = (
    '<svg viewBox="0 0 16 16" xmlns="http://www.w3.org/2000/svg"><path d="M1 13h14" stroke="#7a7a7a" stroke-width="3"/>'
    '<path d="M2 11 9 4M6 11l7-7M10 11l5-5" stroke="#0b62a8" stroke-width="2"/></svg>'
)
