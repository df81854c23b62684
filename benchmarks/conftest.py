"""Benchmarks print the figures they collected beside their times."""

from __future__ import annotations

from typing import Any


def pytest_terminal_summary(terminalreporter: Any) -> None:
    """Print extra figures of every benchmark."""
    session = getattr(terminalreporter.config, "_benchmarksession", None)
    for bench in session.benchmarks if session else ():
        for key, value in bench.extra_info.items():
            terminalreporter.write_line(f"{bench.name}: {key} = {value}")
