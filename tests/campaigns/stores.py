"""Small finished stores of sweeps are damaged at random, read, drawn and gone on with; some get what is no file at all.

A damaged store gives the values of the undamaged one or one line; the same sweep run again leaves the undamaged store,
byte for byte, or says in one line why not.
"""

from __future__ import annotations

import contextlib
import functools
import io
import os
import random
import shutil
import tempfile
import warnings
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import xarray as xr
import zarr

import squama
from squama.cli import main
from squama.errors import InputError
from squama.study.plan import Plan
from squama.study.store import read_plan
from squama.study.sweeping import make_plan, run

TRIALS, SIZE = 60, 10
SWEEPS = (
    ({"mu": (0.0, 2.0, 9), "alpha": ("15 deg", "75 deg", 7)}, {"tile": 20}),
    ({"mu": (0.0, 2.0, 3), "eta": (2.0, 4.0, 4)}, {"tile": 6, "law": ("edge", "plate")}),
    ({"mu": [0.1, 0.3, 0.4], "margin": [0.01, 0.1]}, {"tile": 2, "load": "bending"}),
)
LARGEST = 2**20
"""No file of these stores has more bytes, if it was not put there."""
LAST_BYTES = 40
"""Appended at most."""


def contents(store: Path) -> dict[str, bytes]:
    """Return every file of a store."""
    return {str(p.relative_to(store)): p.read_bytes() for p in sorted(store.rglob("*")) if p.is_file()}


def plan(which: int) -> Plan:
    """Return what is swept."""
    ranges, how = SWEEPS[which]
    return make_plan(squama.Beam.from_ratios(mu=0.3), ranges, **how, joint="hinge")  # type: ignore[arg-type]


@functools.cache
def finished(which: int) -> tuple[Path, dict[str, bytes], xr.Dataset]:
    """Return a finished store, its files and its values."""
    folder = Path(tempfile.mkdtemp(prefix="squama-stores-"))
    run(plan(which), folder / "map.zarr")
    data = squama.open_sweep(folder / "map.zarr").load()
    return folder / "map.zarr", contents(folder / "map.zarr"), data


def flip(dice: random.Random, files: list[Path]) -> str:
    """Flip a bit of a file."""
    place = dice.choice(files)
    data = bytearray(place.read_bytes())
    bit = dice.randrange(8 * len(data))
    data[bit // 8] ^= 1 << bit % 8
    place.write_bytes(data)
    return f"bit {bit} of {place.parent.name}/{place.name}"


def truncate(dice: random.Random, files: list[Path]) -> str:
    """Cut a file off."""
    place = dice.choice(files)
    data = place.read_bytes()
    left = dice.choice((0, dice.randrange(len(data))))
    place.write_bytes(data[:left])
    return f"{place.parent.name}/{place.name} cut to {left} of {len(data)} bytes"


def delete(dice: random.Random, files: list[Path]) -> str:
    """Take a file away."""
    place = dice.choice(files)
    place.unlink()
    return f"{place.parent.name}/{place.name} deleted"


def append(dice: random.Random, files: list[Path]) -> str:
    """Write something after the end of a file."""
    place = dice.choice(files)
    more = b"\xff" + dice.randbytes(dice.randrange(LAST_BYTES))
    place.write_bytes(place.read_bytes() + more)
    return f"{len(more)} bytes after {place.parent.name}/{place.name}"


def zeros(dice: random.Random, files: list[Path]) -> str:
    """Put zeros in the place of a file, as a disk does that was cut off from its power."""
    place = dice.choice(files)
    place.write_bytes(bytes(place.stat().st_size))
    return f"zeros in {place.parent.name}/{place.name}"


def swap(dice: random.Random, files: list[Path]) -> str:
    """Swap two files, often of one variable."""
    one = dice.choice(files)
    near = [p for p in files if p != one and (dice.random() < 0.1 or p.parent == one.parent)]
    other = dice.choice(near or files)
    first, second = one.read_bytes(), other.read_bytes()
    one.write_bytes(second)
    other.write_bytes(first)
    return f"{one.parent.name}/{one.name} and {other.parent.name}/{other.name} swapped"


def copy(dice: random.Random, files: list[Path]) -> str:
    """Put one file in the place of another."""
    one, other = dice.choice(files), dice.choice(files)
    one.write_bytes(other.read_bytes())
    return f"{other.parent.name}/{other.name} in the place of {one.parent.name}/{one.name}"


def strange(dice: random.Random, files: list[Path]) -> str:
    """Put a loop of links, a pipe, a device, a folder or a file of 64 GiB without content in the place of a file."""
    place = dice.choice(files)
    place.unlink()
    kind = dice.choice(("loop", "pipe", "device", "folder", "endless"))
    if kind in ("loop", "device"):
        place.symlink_to(place.name if kind == "loop" else "/dev/zero")
    elif kind == "pipe":
        os.mkfifo(place)
    elif kind == "folder":
        place.mkdir()
    else:
        with place.open("wb") as file:
            file.truncate(2**36)
    return f"a {kind} in the place of {place.parent.name}/{place.name}"


def foreign(dice: random.Random, files: list[Path]) -> str:
    """Put an array that is none of the store's, or a thing that is no file, beside a file."""
    store = next(p for p in files[0].parents if p.suffix == ".zarr")
    name = f"foreign{dice.randrange(10**6)}"
    if dice.random() < 0.5:
        zarr.create_array(store / name, data=np.arange(3.0))
        return f"an array {name}"
    os.mkfifo(store / name)
    return f"a pipe {name}"


DAMAGES: tuple[Callable[[random.Random, list[Path]], str], ...] = (
    flip, truncate, delete, append, zeros, swap, copy, strange, strange, foreign,
)  # fmt: skip


def damage(dice: random.Random, store: Path) -> str:
    """Damage a store at one to three places; return what was done."""
    done = []
    for _ in range(dice.choice((1, 1, 1, 2, 3))):
        files = [p for p in sorted(store.rglob("*")) if p.is_file() and 0 < p.stat().st_size < LARGEST]
        some = dice.choice(("c.", "c.", "c.", "zarr.json", ""))
        # the marks are few among the chunks
        marks = dice.random() < 0.2
        chosen = [p for p in files if p.name.startswith(some) and (not marks or p.parent.name == "status")]
        done.append(dice.choice(DAMAGES)(dice, chosen or files))
    return ", ".join(done)


@contextlib.contextmanager
def one_line() -> Iterator[list[str]]:
    """Yield a list that gets what was wrong with what is done inside: warnings, noise, errors but of one line."""
    wrong: list[str] = []
    with warnings.catch_warnings(record=True) as warned, contextlib.redirect_stderr(io.StringIO()) as noise:
        warnings.simplefilter("always")
        try:
            yield wrong
        except InputError as error:
            if len(str(error).splitlines()) != 1:
                wrong.append(f"more than a line: {error}")
        except Exception as error:
            wrong.append(f"{type(error).__name__}: {str(error)[:200]}")
    wrong += [f"warned: {w.message}"[:200] for w in warned]
    if noise.getvalue():
        wrong.append(f"wrote: {noise.getvalue()[:200]}")


def read(store: Path, values: xr.Dataset) -> list[str]:
    """Open a damaged store and read it."""
    with one_line() as wrong:
        found = squama.open_sweep(store).load()
        done = found.status.values == 1
        for axis, (side, cells) in enumerate(zip(read_plan(store).tile, values.RED.shape, strict=True)):
            done = np.repeat(done, side, axis).take(range(cells), axis)
        for name in values.drop_vars("status").data_vars:
            # a tile without its mark is not computed yet, and told so
            here, wanted = found[name].values[done], values[name].values[done]
            if not np.array_equal(here, wanted, equal_nan=here.dtype.kind == "f"):
                wrong.append(f"other values of {name}")
    return wrong


def drawn(store: Path) -> list[str]:
    """Write a slice of a damaged store by the command; on failure it says one line and no more."""
    held = ["--at", "margin=0.1"] if "margin" in {p.name for p in store.iterdir()} else []
    csv = store.with_name("map.csv")
    said = io.StringIO()
    with one_line() as wrong, contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(said):
        status = main(["map", str(store), "--csv", str(csv), *held])
        lines = said.getvalue().splitlines()
        if status and not (status == 2 and len(lines) == 1 and lines[0].startswith("squama: error: ")):
            wrong.append(f"map: status {status}, {lines[:3]}")
    return wrong


def resumed(store: Path, which: int, whole: dict[str, bytes]) -> list[str]:
    """Run the sweep again over a damaged store."""
    with one_line() as wrong:
        run(plan(which), store)
        now = {name: data for name, data in contents(store).items() if not name.startswith("foreign")}
        if other := [name for name in {**whole, **now} if whole.get(name) != now.get(name)]:
            wrong.append(f"called complete with {len(other)} other files, e.g. {other[0]}")
    return wrong


def trial(seed: int) -> list[str]:
    """Damage stores."""
    dice = random.Random(seed)
    failed = []
    for number in range(SIZE):
        which = dice.randrange(len(SWEEPS))
        origin, whole, values = finished(which)
        store = origin.with_name(f"{os.getpid()}.zarr")
        shutil.copytree(origin, store)
        try:
            done = damage(dice, store)
            wrong = [f"read: {w}" for w in read(store, values)]
            if number % 5 == 0:
                wrong += [f"drawn: {w}" for w in drawn(store)]
            wrong += [f"resumed: {w}" for w in resumed(store, which, whole)]
            failed += [f"seed {seed}, {number}: {done}: {'; '.join(wrong)}"] if wrong else []
        finally:
            shutil.rmtree(store)
    return failed
