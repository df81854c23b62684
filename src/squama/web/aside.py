"""Work beside the event loop: few at a time, in time, and none that holds up the end of the process."""

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
"""Of the threads."""


class Aside(Generic[P, T]):
    """A function, run on threads of its own, at most ``most`` at a time.

    The threads are daemons, which those of executors are not: whatever they compute, the process ends when it is to
    end. One that was given up after ``limit`` seconds (waiting for its turn included) keeps its place until it is done.
    """

    def __init__(self, work: Callable[P, T], most: int, limit: float | None = None) -> None:
        self.work, self.limit = work, limit
        self.places = asyncio.Semaphore(most)

    async def __call__(self, *given: P.args, **named: P.kwargs) -> T:
        """Return what the function gives. Raises what it raises, and TimeoutError."""
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
            # the loop may have ended meanwhile
            with suppress(RuntimeError):
                loop.call_soon_threadsafe(leave, settle)

        async with asyncio.timeout(self.limit):
            await self.places.acquire()
            threading.Thread(target=run, name=NAME, daemon=True).start()
            return await answer


def busy() -> bool:
    """Whether one of the threads computes still."""
    return any(thread.name == NAME for thread in threading.enumerate())
