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
    before = signal.getsignal(signal.SIGINT)
    # a handler that is not Python's could not be put back
    if threading.current_thread() is not threading.main_thread() or before is None:
        yield wished.is_set
        return

    def wish(number: int, frame: object) -> None:  # noqa: ARG001 - the shape of a handler
        wished.set()
        signal.signal(signal.SIGINT, signal.default_int_handler)

    signal.signal(signal.SIGINT, wish)
    try:
        yield wished.is_set
    finally:
        signal.signal(signal.SIGINT, before)


@contextmanager
def undivided() -> Iterator[None]:
    """Hold Ctrl-C back until the work inside has ended, and let it count then, whatever error the work ended in.

    Imports need it: compiled packages turn a KeyboardInterrupt into an ImportError and others.
    """
    failed = False
    with until_interrupted() as stopped:
        try:
            yield
        except BaseException:
            if not stopped():
                raise
            failed = True
    if stopped():
        # to the handler from before, which raises KeyboardInterrupt or notes a wish
        signal.raise_signal(signal.SIGINT)
        if failed:
            raise KeyboardInterrupt
