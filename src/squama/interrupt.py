"""Ctrl-C as a request to stop: long work ends at the next safe place and keeps its finished part."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager


class Interrupted(KeyboardInterrupt):
    """Ctrl-C, after the unit of work in progress was finished; the message says how to continue."""


@contextmanager
def kept(name: str, rest: str = "") -> Iterator[None]:
    """Put the name of the work before the message of an interrupt in the block, ``rest`` (the kept part) behind."""
    try:
        yield
    except KeyboardInterrupt as stop:
        message = f"{name}: {str(stop) or 'interrupted'}{rest}"
        raise Interrupted(message) from None


@contextmanager
def until_interrupted() -> Iterator[Callable[[], bool]]:
    """Turn the first Ctrl-C into a request to stop; the yielded function returns whether it came.

    The second Ctrl-C interrupts at once.
    """
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
    """Delay a Ctrl-C until the block has ended, and let it take effect then, whatever error ended the block.

    Imports need this: compiled packages turn a KeyboardInterrupt into an ImportError or another error.
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
