"""Ctrl-C as a wish: long work ends at the next safe place and keeps what is done."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager


class Interrupted(KeyboardInterrupt):
    """Ctrl-C: what was under way was finished; the message says how to go on."""


@contextmanager
def kept(name: str, rest: str = "") -> Iterator[None]:
    """Say of what is done inside, when it is interrupted, whose it is and what is kept."""
    try:
        yield
    except KeyboardInterrupt as stop:
        message = f"{name}: {str(stop) or 'interrupted'}{rest}"
        raise Interrupted(message) from None


@contextmanager
def until_interrupted() -> Iterator[Callable[[], bool]]:
    """Turn the first Ctrl-C into a wish to stop; what is yielded says whether. The second one interrupts at once."""
    wished = threading.Event()
    if threading.current_thread() is not threading.main_thread():
        yield wished.is_set
        return
    before = signal.getsignal(signal.SIGINT)

    def wish(number: int, frame: object) -> None:  # noqa: ARG001 - the shape of a handler
        wished.set()
        signal.signal(signal.SIGINT, signal.default_int_handler)

    signal.signal(signal.SIGINT, wish)
    try:
        yield wished.is_set
    finally:
        signal.signal(signal.SIGINT, before)
