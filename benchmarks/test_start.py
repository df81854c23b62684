"""CPU seconds of whole cold processes: import, help, one answer."""

from __future__ import annotations

import resource
import statistics
import subprocess
import sys
from pathlib import Path

import pytest

EXAMPLE = Path(__file__).parents[1] / "examples" / "pla_on_vps.toml"
COMMANDS = {
    "python -c 'import squama'": ["-c", "import squama"],
    "squama --help": ["-m", "squama", "--help"],
    "squama twist --json": ["-m", "squama", "twist", str(EXAMPLE), "--json"],
}


def cpu(arguments: list[str]) -> float:
    """User and system seconds of one process."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([sys.executable, *arguments], check=True, stdout=subprocess.DEVNULL)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


@pytest.mark.parametrize("name", COMMANDS)
def test_cold_start(benchmark, name: str) -> None:
    seconds: list[float] = []
    benchmark.pedantic(lambda: seconds.append(cpu(COMMANDS[name])), rounds=5, warmup_rounds=1)
    benchmark.extra_info["median CPU seconds"] = round(statistics.median(seconds), 3)
