"""Progress of long work: lines in the log "squama", and a bar on a terminal."""

from __future__ import annotations

import logging
import sys
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import TYPE_CHECKING, TypeVar

from squama.errors import InputError

if TYPE_CHECKING:
    from rich import progress

T = TypeVar("T")
Listener = Callable[[str, int, int], None]
"""Function called with the name of the work, the number of finished steps and their total."""

LOG = logging.getLogger("squama")
_lost: set[tuple[str, str]] = set()
"""Caches that could not be written: content and place, so that each is reported once."""
_told: ContextVar[Listener | None] = ContextVar("told", default=None)
PATIENCE = 2.0
"""Seconds after which work is shown as a bar."""


def not_kept(what: str, place: object, error: Exception) -> None:
    """Log once for each place that the cache there cannot be written; the calculation goes on without it."""
    if (what, str(place)) not in _lost:
        _lost.add((what, str(place)))
        why = getattr(error, "strerror", None) or str(error)
        if isinstance(error, InputError):
            why = error.problems[0].reason
        why = why.lower()
        LOG.warning("squama: %s: the cache cannot be written (%s); each run makes the %s anew", place, why, what)


@contextmanager
def told(listener: Listener | None) -> Iterator[None]:
    """Report the progress of all work in the block to a listener."""
    before = _told.set(listener)
    try:
        yield
    finally:
        _told.reset(before)


@contextmanager
def work(what: str, total: int) -> Iterator[Callable[[int], None]]:
    """Report the start and end of work of ``total`` steps; the yielded function takes the number of finished steps."""
    begun, last, listener = time.monotonic(), 0, _told.get()
    LOG.info("squama: %s: begun, %d steps", what, total)

    def tell(done: int) -> None:
        nonlocal last
        last = done
        if listener is not None:
            listener(what, done, total)

    tell(0)
    try:
        yield tell
    finally:
        if listener is not None:
            listener(what, total, total)
        LOG.info("squama: %s: %d of %d steps in %.3g s", what, last, total, time.monotonic() - begun)


def steps(items: Iterable[T], total: int, what: str) -> Iterator[T]:
    """Yield the items, at most ``total``, and report the progress after each."""
    with work(what, total) as tell:
        for done, item in enumerate(items, start=1):
            yield item
            tell(done)


@contextmanager
def bars(patience: float = PATIENCE) -> Iterator[Listener]:
    """Yield a listener that shows work of over ``patience`` seconds as a bar on standard error, with the time left."""
    begun: dict[str, float] = {}
    tasks: dict[str, progress.TaskID] = {}
    shown: progress.Progress | None = None

    def listen(what: str, done: int, total: int) -> None:
        nonlocal shown
        late = time.monotonic() - begun.setdefault(what, time.monotonic()) > patience
        if shown is None and late:
            from rich.console import Console
            from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeRemainingColumn

            columns = (BarColumn(), MofNCompleteColumn(), TextColumn("{task.description}, left:"))
            shown = Progress(*columns, TimeRemainingColumn(), console=Console(stderr=True), transient=True)
            shown.start()
        if shown is not None and late:
            if what not in tasks:
                tasks[what] = shown.add_task(what)
            shown.update(tasks[what], completed=done, total=total)
        if done >= total:
            del begun[what]
            if shown is not None and what in tasks:
                shown.remove_task(tasks.pop(what))
            if shown is not None and not tasks:
                shown.stop()
                shown = None

    try:
        yield listen
    finally:
        if shown is not None:
            shown.stop()


@contextmanager
def spoken() -> Iterator[None]:
    """Write the log to standard error during a command, and show progress bars if that is a terminal."""
    handler, before = logging.StreamHandler(sys.stderr), LOG.level
    LOG.addHandler(handler)
    try:
        with bars() as listen, told(listen if sys.stderr.isatty() else _told.get()):
            yield
    finally:
        LOG.removeHandler(handler)
        LOG.setLevel(before)
