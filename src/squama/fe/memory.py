"""Memory: what a beam of elements will need, and what is free."""

from __future__ import annotations

from pathlib import Path

from squama.errors import InputError

_FREE = Path("/proc/meminfo")
_GB = 1e9


def available() -> float | None:
    """Return the bytes of memory that are free, or None where the system does not say."""
    try:
        lines = _FREE.read_text().splitlines()
    except OSError:
        return None
    for line in lines:
        name, _, rest = line.partition(":")
        if name == "MemAvailable":
            return 1024.0 * int(rest.split()[0])
    return None


def estimate(unknowns: int, scales: int) -> float:
    """Return about how many bytes a beam of elements takes: matrices, and factors that grow with a pitch's elements.

    Fitted to runs with MKL Pardiso, 20 000 to 270 000 unknowns, 13 000 to 77 000 a pitch; SuperLU takes several times
    as much.
    """
    return float(unknowns * (5.5e3 + 4.3e3 * (unknowns / scales / 1e4) ** 0.13))


def check(scales: int, unknowns: int) -> None:
    """Refuse a beam that will not fit into the memory that is free.

    Raises
    ------
    InputError
        It will not.
    """
    room, needs = available(), estimate(unknowns, scales)
    if room is not None and needs > room:
        raise too_large(scales, unknowns, needs, room)


def too_large(scales: int, unknowns: int, needs: float, room: float) -> InputError:
    """Return the error that says how much is missing."""
    return InputError(
        f"a beam of {scales} scales with {unknowns} unknowns needs about {needs / _GB:.2g} GB of memory and "
        f"{room / _GB:.2g} GB are free: take a coarser mesh or fewer scales"
    )
