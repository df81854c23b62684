"""Background work off the event loop: few threads, a time limit, and no thread that delays the end of the process."""

from __future__ import annotations

import asyncio
import threading
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from typing import Generic, ParamSpec, TypeVar

P = ParamSpec("P")
T = TypeVar("T")
NAME = "aside"
"""Name of the threads."""


class Aside(Generic[P, T]):
    """A function that runs on its own threads, at most ``most`` at a time.

    The threads are daemons, unlike those of executors, so they do not delay the end of the process. A call is abandoned
    after ``limit`` seconds, waiting included; its thread keeps its place until it is done.
    """

    def __init__(self, work: Callable[P, T], most: int, limit: float | None = None) -> None:
        self.work, self.limit = work, limit
        self.places = asyncio.Semaphore(most)

    async def __call__(self, *given: P.args, **named: P.kwargs) -> T:
        """Return the result of the function. Raises its exceptions, and TimeoutError."""
        loop = asyncio.get_running_loop()
        answer: asyncio.Future[T] = loop.create_future()

        def leave(settle: Callable[[], None]) -> None:
            self.places.release()
            if not answer.done():
                settle()

        def run() -> None:
            try:
                settle = partial(answer.set_result, self.work(*given, **named))
            except Exception as error:
                settle = partial(answer.set_exception, error)
            # the event loop may have ended meanwhile
            with suppress(RuntimeError):
                loop.call_soon_threadsafe(leave, settle)

        async with asyncio.timeout(self.limit):
            await self.places.acquire()
            threading.Thread(target=run, name=NAME, daemon=True).start()
            return await answer


def busy() -> bool:
    """Return whether a background thread is still computing."""
    return any(thread.name == NAME for thread in threading.enumerate())
