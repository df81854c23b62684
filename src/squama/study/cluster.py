"""Tiles of a sweep solved by dask.distributed: the workers write them into one shared folder."""

from __future__ import annotations

import asyncio
import logging
import re
import signal
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError, ThreadPoolExecutor
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from typing import Any

from squama.errors import refuse
from squama.needs import need
from squama.study.plan import Tile
from squama.units import shown

MOST_WORKERS = 1024
WAIT = 10
"""Seconds within which a scheduler must answer."""


def check(address: object) -> None:
    """Refuse anything but "local:n", "tcp://host:port" (or tls://) and a dask client."""
    if not isinstance(address, str):
        if hasattr(address, "submit") and hasattr(address, "scheduler_info"):
            return
        refuse("dask", shown(address), 'give "local:2", "tcp://host:8786" or a dask.distributed Client')
    local = re.fullmatch(r"local:(\d{1,6})", address)
    known = local and 1 <= int(local[1]) <= MOST_WORKERS
    if not known and not re.fullmatch(r"(tcp|tls)://[^\s/]+:\d{1,5}", address):
        refuse("dask", shown(address), "write local:2 for two workers here, or tcp://host:8786 for a scheduler")


def remote(address: object) -> bool:
    """Say whether the cluster exists already: a scheduler's address or a client, not "local:n"."""
    return not (isinstance(address, str) and address.startswith("local:"))


@contextmanager
def client(address: object) -> Iterator[Any]:
    """Yield a client of a cluster; stop a local cluster and close the client afterwards, refuse a silent address."""
    check(address)
    if not isinstance(address, str):
        yield address
        return
    distributed = need("distributed")
    if not remote(address):
        workers = int(address.partition(":")[2])
        with _deaf():
            here = distributed.LocalCluster(
                n_workers=workers, threads_per_worker=1, processes=True, dashboard_address=":0"
            )
        with here as cluster, distributed.Client(cluster) as found:
            yield found
        return
    try:
        _knock(address)
        found = distributed.Client(address, timeout=WAIT)
    except (OSError, TimeoutError, ValueError, TypeError) as error:
        refuse("dask", shown(address), f"no scheduler answers there ({type(error).__name__})", "check the address")
    with _silent(), found:
        yield found


@contextmanager
def _silent() -> Iterator[None]:
    """Silence dask's log on the error stream: squama reports an error in one line."""
    # the client's logger has its own level, all other loggers inherit the level of "distributed"
    loggers = [logging.getLogger(name) for name in ("distributed", "distributed.client")]
    before = [logger.level for logger in loggers]
    for logger in loggers:
        logger.setLevel(logging.CRITICAL + 1)
    try:
        yield
    finally:
        for logger, level in zip(loggers, before, strict=True):
            logger.setLevel(level)


def _knock(address: str) -> None:
    """Connect to a scheduler within ``WAIT`` seconds; a client would wait for ever for a silent scheduler."""
    connect = import_module("distributed.comm").connect
    how = import_module("distributed.security").Security().get_connection_args("client")

    async def ask() -> None:
        comm = await asyncio.wait_for(connect(address, timeout=WAIT, **how), WAIT)
        await comm.close()

    # in another thread, because a notebook runs an event loop in this thread
    with ThreadPoolExecutor(1) as pool:
        pool.submit(asyncio.run, ask()).result()


@contextmanager
def _deaf() -> Iterator[None]:
    """Start child processes that ignore Ctrl-C: the process that hands out the tiles handles it."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)


def run(
    found: Any,
    task: Callable[[str, Tile], bool],
    path: Path,
    tiles: Iterator[Tile],
    finished: Callable[[Tile, bool], None],
    stopped: Callable[[], bool],
) -> None:
    """Run a task for every tile, a few ahead of the workers; the tile of a worker that dies goes to another one.

    Workers may join and leave at any time. ``task(store, tile)`` returns whether it wrote the tile; ``finished(tile,
    wrote)`` is called after each; no new tile is begun once ``stopped()`` is true. A tile that kills its workers, and a
    lost scheduler, raise InputError with one line.
    """
    distributed: Any = import_module("distributed")
    killed: type[Exception] = import_module("distributed.scheduler").KilledWorker
    gone: type[Exception] = distributed.comm.CommClosedError

    store = str(path.absolute())
    running: dict[object, Tile] = {}
    queue = distributed.as_completed()

    def fill() -> None:
        try:
            ahead = max(2, 2 * sum(found.nthreads().values()))
        except OSError as error:  # the connection is cut, and the client has not noticed yet
            raise gone from error
        while len(running) < ahead and not stopped() and (tile := next(tiles, None)) is not None:
            future = found.submit(task, store, tile, pure=False)
            running[future] = tile
            queue.add(future)

    try:
        fill()
        for future in queue:
            tile = running.pop(future)
            try:
                wrote = future.result()
            except killed:
                place = f"tile {'.'.join(map(str, tile))}"
                refuse(place, "", "the workers that took it died", "give them memory, run again")
            finished(tile, wrote)
            fill()
    except (CancelledError, gone):
        refuse("dask", "", "the scheduler has gone", "start it and run the same command again, finished tiles are kept")
