"""Memory of pages without a connected browser."""

from __future__ import annotations

import asyncio
import ctypes
import gc
import sys
from contextlib import suppress

from nicegui import Client


def make_room() -> None:
    """Delete the oldest pages to which no browser has connected, beyond eight."""
    every = (one for one in Client.instances.values() if one._response_built)
    waiting = [one for one in every if not one.has_socket_connection and not one._delete_tasks]
    for one in sorted(waiting, key=lambda client: client.created)[:-8]:
        one.delete()


class Sweep:
    """Returns the memory of ended pages to the system."""

    def __init__(self) -> None:
        self.due = False
        # objects that exist now stay, and need not be scanned each time
        gc.freeze()

    def soon(self) -> None:
        """Schedule a collection in a second, once for all pages that end until then."""
        if not self.due:
            self.due = True
            asyncio.get_running_loop().call_later(1.0, self._now)

    def _now(self) -> None:
        self.due = False
        # a page's elements and handlers refer to each other
        gc.collect()
        if sys.platform == "linux":
            # otherwise memory freed in small pieces stays with the process; glibc only
            with suppress(AttributeError):
                ctypes.CDLL(None).malloc_trim(0)
