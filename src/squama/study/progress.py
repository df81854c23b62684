"""Listeners to a sweep: a bar, lines of JSON, or nothing."""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable
from types import TracebackType
from typing import Any, NamedTuple, Self

from squama.errors import InputError
from squama.units import shown


class State(NamedTuple):
    """Where a run stands: tiles and cells of its share, those done (also by earlier runs), seconds gone and left."""

    tiles: int
    tiles_done: int
    cells: int
    cells_done: int
    elapsed_s: float
    left_s: float | None


Listener = Callable[[State], None]


class Clock:
    """Counts finished tiles and tells a listener; time left follows from the cells that this run has solved."""

    def __init__(self, tiles: int, cells: int, tiles_done: int, cells_done: int, listener: Listener) -> None:
        self._start = time.monotonic()
        self._tiles, self._cells, self._listener = tiles, cells, listener
        self.tiles_done, self.cells_done, self._before = tiles_done, cells_done, cells_done
        self._tell()

    def done(self, cells: int) -> None:
        """Count a tile."""
        self.tiles_done += 1
        self.cells_done += cells
        self._tell()

    def _tell(self) -> None:
        gone = time.monotonic() - self._start
        solved = self.cells_done - self._before
        left = gone / solved * (self._cells - self.cells_done) if solved else None
        if self.cells_done == self._cells:
            left = 0.0
        self._listener(State(self._tiles, self.tiles_done, self._cells, self.cells_done, gone, left))


def json_lines(state: State) -> None:
    """Write the state as a line of JSON on standard error."""
    record = {k: round(v, 3) if isinstance(v, float) else v for k, v in state._asdict().items()}
    sys.stderr.write(json.dumps(record) + "\n")
    sys.stderr.flush()


class Bar:
    """A bar on standard error, with the time left."""

    def __init__(self) -> None:
        from rich.console import Console
        from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn

        columns = (BarColumn(), MofNCompleteColumn(), TextColumn("tiles, {task.fields[left]}"))
        self._bar = Progress(*columns, console=Console(stderr=True))
        self._task: Any = None

    def __call__(self, state: State) -> None:
        """Show a state."""
        left = "time left unknown yet" if state.left_s is None else f"{clock(state.left_s)} left"
        if self._task is None:
            self._bar.start()
            self._task = self._bar.add_task("", total=state.tiles, left=left)
        self._bar.update(self._task, completed=state.tiles_done, left=left)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._bar.stop()


class Silent:
    """A listener that says nothing, or what a function says."""

    def __init__(self, listener: Listener = lambda _: None) -> None:
        self._listener = listener

    def __call__(self, state: State) -> None:
        """Pass a state on."""
        self._listener(state)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        pass


def known(name: str) -> None:
    """Refuse a name that is none of a listener.

    Raises
    ------
    InputError
        Neither "bar" nor "json" nor "none".
    """
    if name not in ("bar", "json", "none"):
        message = f"progress = {shown(name)}: must be bar, json or none"
        raise InputError(message)


def listener(asked: str | Listener | None) -> Bar | Silent:
    """Return the listener of a name, or of a function."""
    if callable(asked):
        return Silent(asked)
    known(asked or "none")
    if asked == "bar":
        return Bar()
    return Silent(json_lines) if asked == "json" else Silent()


def clock(seconds: float) -> str:
    """Return a time for people.

    Examples
    --------
    >>> clock(5.2), clock(3700)
    ('5 s', '1 h 2 min')
    """
    if seconds < 60:
        return f"{seconds:.0f} s"
    minutes = round(seconds / 60)
    return f"{minutes} min" if minutes < 60 else f"{minutes // 60} h {minutes % 60} min"
