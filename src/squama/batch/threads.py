"""Work on many designs, shared between threads."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor


def in_parts(
    begin: Callable[[], Callable[[int, int], None]], n: int, *, most: int, least: int, threads: int | None = None
) -> None:
    """Work on the designs 0..n in parts.

    Parameters
    ----------
    begin
        Called once by each thread; returns what works on the designs from a first one to before a last one.
    most, least
        Designs of a part.
    threads
        By default as many as there are cores, or as NUMBA_NUM_THREADS says.
    """
    from numba import config

    workers = max(1, min(threads or int(getattr(config, "NUMBA_NUM_THREADS", 1)), n // least))
    parts = iter(range(0, n, size := max(least, min(most, n // (2 * workers)))))

    def work() -> None:
        one = begin()
        for low in parts:
            one(low, min(n, low + size))

    if workers == 1:
        work()
        return
    with ThreadPoolExecutor(workers - 1) as pool:
        others = [pool.submit(work) for _ in range(workers - 1)]
        work()
        for other in others:
            other.result()
