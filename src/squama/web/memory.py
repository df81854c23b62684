"""The memory of pages that nobody looks at."""

from __future__ import annotations

import asyncio
import ctypes
import gc
import sys
from contextlib import suppress

from nicegui import Client


def make_room() -> None:
    """Let go of the oldest pages to which no browser has connected: at most eight wait."""
    every = (one for one in Client.instances.values() if one._response_built)
    waiting = [one for one in every if not one.has_socket_connection and not one._delete_tasks]
    for one in sorted(waiting, key=lambda client: client.created)[:-8]:
        one.delete()


class Sweep:
    """Gives the memory of ended pages back to the system."""

    def __init__(self) -> None:
        self.due = False
        # what is there already stays, and need not be looked through each time
        gc.freeze()

    def soon(self) -> None:
        """Do so in a second, once for all pages that end until then."""
        if not self.due:
            self.due = True
            asyncio.get_running_loop().call_later(1.0, self._now)

    def _now(self) -> None:
        self.due = False
        # a page's elements and handlers refer to each other
        gc.collect()
        if sys.platform == "linux":
            # what was freed in small pieces stays with the process otherwise; only glibc has this
            with suppress(AttributeError):
                ctypes.CDLL(None).malloc_trim(0)
