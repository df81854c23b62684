"""Distribution of work on many designs over threads."""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor


def in_parts(
    begin: Callable[[], Callable[[int, int], None]], n: int, *, most: int, least: int, threads: int | None = None
) -> None:
    """Process the designs 0..n in parts, on several threads.

    Parameters
    ----------
    begin
        Called once by each thread; returns a function that processes the designs from a first index to before a last
        one.
    most, least
        Largest and smallest number of designs of a part.
    threads
        Number of threads; by default the number of cores, or NUMBA_NUM_THREADS.
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
