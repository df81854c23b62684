"""Damaged results: flipped bits and other bytes in netCDF and CSV files load equal or are refused, nothing else.

No warning, no other exception, and no more than some seconds. Files without a hash, as squama wrote them once, are
damaged too: of them only the kind of error is asked.
"""

from __future__ import annotations

import faulthandler
import functools
import itertools
import tempfile
import time
import warnings
from pathlib import Path

import numpy as np

import squama
from squama.errors import InputError

TRIALS = 100
SIZE = 100
SECONDS = 20.0
"""Of one file, at most."""
HANGS = 120.0
"""Seconds after which the library that reads counts as hung; nothing in Python can stop it."""


def damaged(data: bytes, rng: np.random.Generator) -> tuple[bytes, str]:
    """Return bytes with one damage and its name: two of three times a single bit."""
    i = int(rng.integers(len(data)))
    n = int(rng.choice([1, 2, 8, 64]))
    other = rng.integers(0, 256, n, dtype=np.uint8).tobytes()
    kind = str(rng.choice(["bit"] * 12 + ["bytes", "zeros", "removed", "inserted", "repeated", "cut"]))
    parts = {
        "bit": data[:i] + bytes([data[i] ^ (1 << int(rng.integers(8)))]) + data[i + 1 :],
        "bytes": data[:i] + other + data[i + n :],
        "zeros": data[:i] + bytes(n) + data[i + n :],
        "removed": data[:i] + data[i + n :],
        "inserted": data[:i] + other + data[i:],
        "repeated": data[: i + n] + data[i:],
        "cut": data[:i],
    }
    return parts[kind], f"{kind} at {i} of {len(data)}"


@functools.cache
def results() -> list[tuple[str, bytes, bool]]:
    """Return files as they are written: their ending, their bytes, and whether they carry a hash."""
    beam = squama.Beam.from_ratios(alpha="45 deg", mu=0.3)
    sets = (
        squama.twist(beam, points=8),
        squama.twist(beam, mu=[0.0, 0.2, 6.0], points=4),
        squama.bend(beam, points=6),
    )
    found = []
    with tempfile.TemporaryDirectory() as folder:
        for dataset, ending in itertools.product(sets, (".nc", ".csv")):
            data = squama.save(dataset, Path(folder) / f"a{ending}").read_bytes()
            found.append((ending, data, True))
            if ending == ".csv":
                lines = data.split(b"\n")
                found.append((ending, b"\n".join(line for line in lines if not line.startswith(b"# sha256")), False))
    return found


@functools.cache
def whole(number: int) -> object:
    """Return what a file holds undamaged."""
    ending, data, _ = results()[number]
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"a{ending}"
        path.write_bytes(data)
        return squama.read(path)


def trial(seed: int) -> list[str]:
    """Read damaged files; return what went wrong."""
    rng = np.random.default_rng(seed)
    failed = []
    with tempfile.TemporaryDirectory() as folder:
        for case in range(SIZE):
            number = int(rng.integers(len(results())))
            ending, data, hashed = results()[number]
            data, how = damaged(data, rng)
            path = Path(folder) / f"a{ending}"
            path.write_bytes(data)
            if wrong := _wrong(path, number, hashed):
                failed.append(f"seed {seed}, case {case}: {ending} {number}, {how}: {wrong}")
    return failed


def _wrong(path: Path, number: int, hashed: bool) -> str:
    """Read a file; return what is wrong with how that ended, or nothing."""
    expected = whole(number)
    start = time.monotonic()
    faulthandler.dump_traceback_later(HANGS, exit=True)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            found = squama.read(path)
    except InputError as error:
        if str(path) not in str(error) or "\n" in str(error) or not str(error).isprintable() or len(str(error)) > 600:
            return f"a message that is none: {str(error)[:300]!r}"
    except BaseException as error:
        return f"{type(error).__name__}: {str(error)[:200]!r}"
    else:
        if hashed and not found.identical(expected):
            return "loads with other numbers, words or units"
    finally:
        faulthandler.cancel_dump_traceback_later()
    took = time.monotonic() - start
    return f"took {took:.1f} s" if took > SECONDS else ""
