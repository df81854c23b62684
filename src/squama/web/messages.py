"""Messages that no page of the explorer sends: they are dropped without a word, and change nothing."""

from __future__ import annotations

import functools
import inspect
import logging
from collections.abc import Callable
from typing import Any

from nicegui import core


def bear() -> None:
    """Drop messages that socket.io or NiceGUI cannot read; each would print a traceback."""
    # of the packets below those messages: it tells of nothing else
    logging.getLogger("engineio.server").setLevel(logging.CRITICAL)
    handlers = core.sio.handlers["/"]
    # a connection is refused by an exception
    for name in handlers.keys() - {"connect"}:
        handlers[name] = borne(handlers[name])


def borne(handler: Callable[..., Any]) -> Callable[..., Any]:
    """Return a handler of messages that fails at none; what people do on the page has handlers of its own inside."""

    @functools.wraps(handler)
    async def bear_it(*given: object) -> object:
        try:
            found = handler(*given)
            return await found if inspect.isawaitable(found) else found
        except Exception:
            return None

    return bear_it
