"""What pages hold in memory, given back when nobody looks at them any more."""

from __future__ import annotations

import asyncio
import ctypes
import gc
import sys
from contextlib import suppress

from nicegui import Client

MOST_WAITING = 8
"""Pages that no browser has connected to yet, at most."""
PAUSE = 1.0
"""Seconds from the end of a page to when its memory is given back, once for all until then."""


def make_room() -> None:
    """Let go of the oldest pages to which no browser has connected, before there are too many."""
    every = (one for one in Client.instances.values() if one._response_built)
    waiting = [one for one in every if not one.has_socket_connection and not one._delete_tasks]
    for one in sorted(waiting, key=lambda client: client.created)[:-MOST_WAITING]:
        one.delete()


class Sweep:
    """Gives the memory of ended pages back to the system."""

    def __init__(self) -> None:
        self.due = False
        # what is there already stays, and need not be looked through each time
        gc.freeze()

    def soon(self) -> None:
        """Do so in a moment."""
        if not self.due:
            self.due = True
            asyncio.get_running_loop().call_later(PAUSE, self._now)

    def _now(self) -> None:
        self.due = False
        # a page's elements and handlers refer to each other
        gc.collect()
        if sys.platform == "linux":
            # what was freed in small pieces stays with the process otherwise; only glibc has this
            with suppress(AttributeError):
                ctypes.CDLL(None).malloc_trim(0)
