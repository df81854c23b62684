"""Files opened on the page: a beam, or a measured table for comparison with the curve; size and time are bounded.

A file arrives as bytes; it is read under a cleaned name in a temporary folder, and cannot refer to other files. A fit
runs in its own process, which is killed when it takes too long.
"""

from __future__ import annotations

import itertools
import pickle
import re
import subprocess
import sys
import tempfile
import threading
import warnings
from pathlib import Path
from typing import NamedTuple

import numpy as np

from squama.beam.design import Beam
from squama.errors import InputError, TableWarning, refuse
from squama.identify import records
from squama.io import files, measured
from squama.io.measured import Measured
from squama.loads import LOADS
from squama.types import Array
from squama.web import live
from squama.web.state import State, of

LARGEST = {"beam": 64 * 1024, "table": 512 * 1024}
"""Largest size of a file, bytes; the sending script checks it first."""
MOST_POINTS = 600
"""Largest number of drawn points; of more every n-th is drawn."""
SECONDS = 60
"""Time limit of a fit, s."""


class Table(NamedTuple):
    """Measured points and their name; ``load``: the kind of load with which they were read.

    ``said``: guesses made in reading, in words.
    """

    name: str
    points: Measured
    load: str
    said: str = ""


class Fitted(NamedTuple):
    """Result of a fit: beam, ``values`` (name, words, value with error), ``doubts`` about the errors, summary lines.

    ``model``: idealisation of the scales, ``specimen``: their number and ends. For the points, in the order of
    specimens: load angles per pitch (rad), fitted torque and residual (N m), NaN where the model does not cover them.
    """

    beam: Beam
    values: tuple[tuple[str, str, str], ...]
    doubts: tuple[str, ...]
    model: str
    specimen: str
    lines: tuple[str, ...]
    load: Array
    torque: Array
    left: Array


class How(NamedTuple):
    """Settings for reading a table, as of :func:`squama.io.measured.read`; empty values are guessed."""

    columns: str = ""
    decimal: str = ""


class Residual(NamedTuple):
    """Measured less computed torque (N m) at load angles per pitch (rad), for the points that the curve covers."""

    load: Array
    torque: Array
    words: str


GUESSED = How()


def opened(name: str, content: bytes, state: State, how: How = GUESSED) -> State | Table:
    """Return the state of a beam file (.toml), or the points of a measured table.

    Raises InputError for a file that is too large or unreadable, in one line.
    """
    plain = re.sub(r"[^\w.+-]+", "_", Path(name).name)[-60:].lstrip("._") or "table.csv"
    kind = "beam" if plain.lower().endswith(".toml") else "table"
    if len(content) > LARGEST[kind]:
        refuse("", "", f"is larger than {LARGEST[kind] // 1024} KiB", "thin it out", plain)
    with tempfile.TemporaryDirectory() as folder:
        place = Path(folder) / plain
        place.write_bytes(content)
        try:
            if kind == "beam":
                beam = Beam.from_toml_text(files.read_text(place), source=plain)
                return of(beam)._replace(kept=state.kept)
            beam = state.beam
            with warnings.catch_warnings(record=True) as guessed:
                warnings.simplefilter("always", TableWarning)
                chosen = {name: value for name, value in how._asdict().items() if value}
                points = measured.read(place, pitch=beam.pitch, scales=beam.pitches, load=state.load, **chosen)
        except InputError as error:
            # messages name the file, not its temporary path
            first, *more = (p._replace(source=p.source.replace(str(place), plain)) for p in error.problems)
            others = f"; and {len(more)} more mistakes" if more else ""
            raise InputError(first._replace(remedy=first.remedy + others)) from None
    said = "; ".join(str(w.message).replace(str(place), plain) for w in guessed)
    return Table(plain, points._replace(label=plain), state.load, said)


def _signed(table: Table, state: State) -> Array:
    """Return the load angles per pitch (rad), positive in the displayed sense."""
    sided = LOADS[state.load].sided
    return table.points.rate * state.beam.pitch * (-1 if sided and state.sense == "-" else 1)


def shown(table: Table, state: State) -> tuple[Array, Array]:
    """Return load angles and torques of the points in the displayed sense, for drawing."""
    load = _signed(table, state)
    torque = np.copysign(1.0, table.points.rate * load) * table.points.load
    there = np.flatnonzero((load >= 0) & (table.load == state.load))[:: 1 + load.size // MOST_POINTS]
    return load[there], torque[there]


def looped(found: Fitted, state: State) -> tuple[Array, Array, Array]:
    """Return load angles, fitted torque and residual in the displayed sense, for the points that a fit covers."""
    sign = -1 if LOADS[state.load].sided and state.sense == "-" else 1
    there = np.isfinite(found.torque) & (sign * found.load >= 0)
    return sign * found.load[there], sign * found.torque[there], sign * found.left[there]


def residual(table: Table, state: State, found: Fitted | None = None) -> Residual | None:
    """Return the residual of the measured torque from the fitted loop, or from the curve along the same history."""
    if found and found.beam == state.beam and table.load == state.load:
        x, _, y = looped(found, state)
        return _told(x, y, found.load.size, float(np.abs(table.points.load).max(initial=0.0)))
    load, m = _signed(table, state), live.motion(state.setting)
    if table.load != state.load or not load.size:
        return None
    sign = -1 if state.sense == "-" and m.kind.sided else 1
    # smaller backward twists are noise; a table is followed up to 13 turning points
    ways = records.ways(load, tolerance=0.02 * float(np.abs(load).max()))
    ends, most = [*ways.turns[:12], load.size - 1], (1 - live.NEAR) * m.last
    goals = np.clip(load[ends], 0.0, most).tolist()
    left, start = np.full(load.size, np.nan), 0
    legs = [0.0, *(b for a, b in itertools.pairwise([0.0, *goals]) if a != b)]
    if len(legs) < 2:
        return None
    try:
        answer = live.history(state.setting, tuple(sign * v for v in legs))
    except InputError as error:
        return Residual(load[:0], load[:0], f"no residual: {error}")
    leg, before = 0, 0.0
    for end, goal in zip(ends, goals, strict=True):
        part, start = slice(start, end + 1), end + 1
        leg += goal != before
        before = goal
        # a leg begins at the end of the previous one
        mine = np.flatnonzero(answer["leg"] == leg)
        mine = np.concatenate([[max(mine[0] - 1, 0)], mine])
        x, y = (sign * answer[name][mine] for name in (m.kind.angle, m.kind.torque))
        order = np.argsort(x, kind="stable")
        left[part] = sign * table.points.load[part] - np.interp(load[part], x[order], y[order])
    # where the contact may stick, any torque between both branches is possible
    covered = np.isfinite(left) & (load <= most) & (load >= 0) & ~ways.stuck
    x, y = load[covered], left[covered]
    if not x.size:
        return Residual(x, y, "no point lies on the curve")
    left_over = _told(x, y, load.size, float(np.abs(table.points.load[covered]).max()))
    return left_over._replace(words=f"{left_over.words}, against the endless beam's curve")


def _told(x: Array, y: Array, of: int, largest: float) -> Residual:
    """Return residuals (n,) out of ``of`` points, with their size in words."""
    there = np.isfinite(y)
    if not there.any():
        return Residual(x[:0], y[:0], "no point lies on the curve")
    rms = float(np.sqrt(np.mean(y[there] ** 2)))
    share = f", {100 * rms / largest:.2g} % of the largest torque" if largest else ""
    words = f"residual rms {live.quantity(rms, 'N m')}{share}; {np.count_nonzero(there)} of {of} points"
    every = np.flatnonzero(there)[:: 1 + x.size // MOST_POINTS]
    return Residual(x[every], y[every], words)


def fitted(table: Table, state: State) -> Fitted:
    """Return the fit of :func:`squama.fit` to a table with the displayed model and the specimen's own scales.

    The fit runs in another process, which ends with this one. Raises InputError where there is no fit, or it takes too
    long.
    """
    if state.bent:
        refuse("", "", "a fit needs a beam without bend", "set the held bend to 0")
    names = LOADS[state.load]
    every = table.points.specimens()
    data = [{names.rate: one.rate, names.torque: one.load} for one in every]
    how = {"load": state.load, "law": names.law(state.law), "joint": live.motion(state.setting).joint}
    command = [sys.executable, "-c", "from squama.web import tables; tables.answer()"]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as process:
        assert process.stdin
        assert process.stdout
        end = threading.Timer(SECONDS, process.kill)
        end.start()
        try:
            process.stdin.write(pickle.dumps((data, state.beam, how)))
            process.stdin.flush()
            found: Fitted | InputError = pickle.load(process.stdout)
        except (BrokenPipeError, EOFError):
            refuse("", "", f"no fit is found within {SECONDS} s", "thin the table out, or use squama fit")
        finally:
            end.cancel()
            process.kill()
    if isinstance(found, InputError):
        raise found
    load = np.concatenate([one.rate for one in every]) * state.beam.pitch
    if found.torque.size != load.size:
        load, found = np.empty(0), found._replace(torque=np.empty(0), left=np.empty(0))
    return found._replace(load=load)


def answer() -> None:
    """Run the fit requested on the standard input, and write what it found; the process ends with the input."""
    import os

    from squama.identify.fitting import fit

    data, beam, how = pickle.load(sys.stdin.buffer)
    threading.Thread(target=lambda: (sys.stdin.buffer.read(), os._exit(1)), daemon=True).start()
    reply: Fitted | InputError
    try:
        found = fit(data, beam, **how)
        rows = zip(found.asked.rows, found.estimates, found.deviations, strict=True)
        values = tuple((row.name, row.words, row.written(value, error)) for row, value, error in rows)
        doubts = (*found.doubts, *filter(None, [found.disagreement]))
        lines, none = tuple(found.summary().splitlines()), np.empty(0)
        points = none, found.fitted, found.residuals
        reply = Fitted(found.beam, values, doubts, found.scales, found.fitted_as, lines, *points)
    except InputError as error:
        reply = error
    sys.stdout.buffer.write(pickle.dumps(reply))
    sys.stdout.buffer.flush()
    # the reading thread ends only with the process
    os._exit(0)
