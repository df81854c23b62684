"""Measured records of a fit: their sources, the checks, and the direction in which each point was reached.

A rigid scale neither slips nor moves while friction reverses, so at the twist of a turning point any torque between
both branches is possible (docs, theory: cycles). Such points lie on the drop, not on a branch, and are marked.
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from squama import arguments
from squama.beam.design import Beam
from squama.curves.hinge_cycles import Senses
from squama.errors import Problems, naming, refuse
from squama.identify import noise
from squama.identify.noise import scatter
from squama.identify.readings import Readings
from squama.io import measured
from squama.io.columns import Ordinate, torque
from squama.io.measured import Measured
from squama.loads import LOADS, TESTS, Load
from squama.people import at_most, per_pitch
from squama.types import Array
from squama.units import Bounds, shown

MOST = 1_000_000
"""Largest number of points of all specimens."""
_LEAST_LEG = 3
_SWINGS, _BACK = 20, 0.02
"""Least number of points of a decay; backward twist that makes a turning point, over the range of the twist."""
_FEWEST, _TIMES, _WIDEST = 20, 6.0, 0.05
"""Least number of points for the noise of the twist; backward twist over the noise; its largest share of the range."""
_SURE = 3.0
"""Noises of a torque within which a specimen may still stick."""
TORQUES = Bounds(1e-30, 1e30, "1e-30 to 1e30 N m", closed=True, example='"5 N mm"')
"""Magnitudes of torques: squares and ratios of them are finite."""
FORCES = Bounds(1e-30, 1e30, "1e-30 to 1e30 N", closed=True, example='"5 mN"')
"""Magnitudes of forces, with the same purpose."""
_TWISTING = LOADS["twisting"]
_OUTLIER = 1e6
"""Torque over the median of the record that no load cell resolves: a mistake in the row."""


class Record(NamedTuple):
    """Points of all specimens, one after the other.

    ``specimen``: index; ``load``: signed angle per pitch (rad), corrected for a given machine; ``torque`` N m,
    ``smooth`` without noise; ``way``: +1 where the magnitude of the load grew, -1 where it fell; ``stuck``: where the
    contact may stick; ``asked``: within the requested range.
    """

    specimens: list[Measured]
    specimen: NDArray[np.int64]
    load: Array
    torque: Array
    smooth: Array
    way: Array
    stuck: NDArray[np.bool_]
    asked: NDArray[np.bool_]

    def readings(self, scales: int, compliance: float) -> Readings:
        """Return the readings of a beam with so many scales, corrected for a machine's compliance (rad/(N m))."""
        return Readings.of(self.load, self.way, self.specimen, scales, self.smooth, compliance)

    def where(self, i: int) -> str:
        """Return the place of a point in messages."""
        s = int(self.specimen[i])
        return self.specimens[s].where(i - int(np.argmax(self.specimen == s)))


def read(given: object, beam: Beam, load: str, ordinate: Ordinate | None = None) -> list[Measured]:
    """Return the specimens of files, datasets or arrays, see :func:`squama.fit`; ``ordinate``: default the torque."""
    beside = ordinate or torque(TESTS[load])
    items = list(given) if isinstance(given, Sequence) and not isinstance(given, str | Measured) else [given]
    if not items:
        refuse("data", "", "is empty", "give a file, or several")
    found: list[Measured] = []
    problems = Problems()
    for i, item in enumerate(items):
        with problems.caught():
            if isinstance(item, Measured):
                found += item.specimens()
            elif isinstance(item, str | os.PathLike):
                one = measured.read(item, pitch=beam.pitch, scales=beam.pitches, load=load, ordinate=beside)
                found += one.specimens()
            else:
                found.append(_arrays(item, f"data[{i}]" if len(items) > 1 else "data", beam, TESTS[load], beside))
    problems.settle()
    # specimens of one name (from several files) get a number
    labels = [s.label for s in found]
    again = [labels[: i + 1].count(label) if labels.count(label) > 1 else 0 for i, label in enumerate(labels)]
    return [s._replace(label=f"{s.label} {n}") if n else s for s, n in zip(found, again, strict=True)]


def _arrays(item: Any, name: str, beam: Beam, load: Load, ordinate: Ordinate) -> Measured:
    """Return a specimen from a mapping or dataset by the symbols of its variables."""
    symbol = ordinate.names[0]
    unit = "m" if load.pushed else "rad/m"
    wanted = f'"{load.rate}" ({unit}) and "{symbol}" {ordinate.cell.removeprefix(symbol).strip()}'
    if not isinstance(item, Mapping) and not hasattr(item, "data_vars"):
        refuse(name, "", "is no file and has no columns", f"give a path, a dataset, or a mapping with {wanted}")
    # a total is of the whole beam
    over = {load.rate: 1.0, load.angle: beam.pitch} | ({} if load.pushed else {"total": beam.length})
    key = next((k for k in over if k in item), None)
    if key is None or symbol not in item:
        refuse(name, "", f"has no {wanted}", "give both")
    columns = []
    for column in (key, symbol):
        values, where = item[column], f'{name}["{column}"]'
        array = arguments.numbers(where, getattr(values, "values", values))
        if array.ndim != 1:
            refuse(where, "", f"must be one-dimensional, not of shape {array.shape}", "give one curve")
        columns.append(array)
    rate, values = columns
    if rate.size != values.size:
        refuse(name, "", f"{rate.size} twists but {values.size} {ordinate.noun}s", f"give one {ordinate.noun} for each")
    return Measured(rate / over[key], values, name)


class Limits(NamedTuple):
    """Largest twist of used points, backward twist that is noise (None: from the record), twist of sticking, rad."""

    to: float = np.inf
    reversal: float | None = None
    stick: float = 0.0

    @classmethod
    def of(cls, beam: Beam, load: str, to: object, reversal: object, stick: object) -> Limits:
        """Read the limits; see :func:`squama.fit`."""
        limit = np.inf if to is None else angle("to", to, beam, load)
        if limit <= 0:
            example = "5 mm" if TESTS[load].pushed else "5 deg/pitch"
            refuse("to", "", "must be above 0", f'write e.g. "{example}"')
        back = None if reversal is None else angle("reversal", reversal, beam, load)
        return cls(limit, back, angle("stick", stick, beam, load))


ALL = Limits()
"""Limits that use all points."""


def record(
    specimens: list[Measured], beam: Beam, limits: Limits = ALL, compliance: float = 0.0, load: Load = _TWISTING
) -> Record:
    """Join specimens and find the ways of their points, for a machine (rad/(N m)); refuse unusable records."""
    if sum(s.rate.size for s in specimens) > MOST:
        refuse("data", "", f"more than {MOST} points are too many", "thin them out")
    problems, parts = Problems(), []
    for number, s in enumerate(specimens):
        reading = s.rate * beam.pitch
        place = s.label if s.lines is None else f"{s.file}: specimen {s.label}" if len(specimens) > 1 else s.file
        back = _jitter(reading) if limits.reversal is None else limits.reversal
        per_torque = compliance / load.counted(beam.pitches)
        # while scales stick the specimen rests, up to the noise of the torque
        stick = max(limits.stick, _SURE * per_torque * scatter(s.load, np.zeros(s.load.size)))
        turns = turning_points(reading, back)
        smooth = noise.smooth(reading, s.load, turns)
        x = reading - per_torque * smooth
        found = ways(reading, x, tolerance=back, stick=stick)
        with problems.caught(place):
            _usable(s, found.turns, load)
        way = found.direction * np.where(x < 0, -1, 1)
        parts.append((np.full(x.size, number), x, s.load, smooth, way, found.stuck, np.abs(x) <= limits.to))
    problems.settle()
    return Record(specimens, *map(np.concatenate, zip(*parts, strict=True)))


def angle(name: str, value: object, beam: Beam, load: str, *, signed: bool = False) -> float:
    """Return an angle (rad per pitch) from a rate (rad/m) or a text; one below 0 is refused unless ``signed``."""
    with naming(name):
        rate = TESTS[load].read(value, pitch=beam.pitch, scales=beam.pitches)
    if rate < 0 and not signed:
        said = shown(value) if TESTS[load].pushed else f"{rate:.6g} rad/m"
        refuse(name, said, "must be 0 or more", "give its magnitude")
    return rate * beam.pitch


def _jitter(values: Array) -> float:
    """Return the backward twist that is noise: a multiple of the noise where noise turns the twist round, else 0."""
    back = _TIMES * scatter(values, np.zeros(values.size))
    # where it is a large share of the range the rows are not in the order measured
    if values.size < _FEWEST or back > _WIDEST * float(np.ptp(values)):
        return 0.0
    return back if len(turning_points(values, back)) < len(turning_points(values, 0.0)) else 0.0


def _usable(s: Measured, turns: list[int], load: Load) -> None:
    """Refuse a record that cannot be used."""
    n, cell, (way, noun, unit) = s.rate.size, "check the column and the load cell", (load.way, load.noun, load.force)
    if n > 1 and np.ptp(s.rate) == 0:
        same = "the same" if load.pushed else f"{s.rate[0]:.6g} rad/m"
        refuse("", "", f"the {way} is {same} in every row", f"a fit needs points at different {way}s")
    if not s.load.any():
        refuse("", "", f"the {noun} is 0 in every row", cell)
    if n > 1 and np.ptp(s.load) == 0:
        refuse("", "", f"the {noun} is {s.load[0]:.6g} {unit} in every row", cell)
    size = np.abs(s.load)
    size /= size.max()
    i = int(np.argmax(size))
    row = f"point {i}" if s.lines is None else f"line {s.lines[i]}"
    if not TORQUES.hold(abs(float(s.load[i]))):
        refuse(row, "", f"the {noun} is {s.load[i]:.6g} {unit}, out of range (1e-30 to 1e30 {unit})", cell)
    if (times := 1 / float(np.median(size[size > 0]))) > _OUTLIER:
        far = f"{times:.2g} times the median of the record ({_OUTLIER:g} at most)"
        reason = f"the {noun} is {s.load[i]:.6g} {unit}, {far}"
        refuse(row, "", reason, "correct the row or leave it out")
    if float(s.rate @ s.load) < 0:
        refuse("", "", f"{noun} and {way} have opposite signs", "turn the sign of one of them")
    if noise.mixed(s.rate, s.load):
        reason = f"the rows are sorted by the {way}: the {noun} jumps between two branches from row to row"
        refuse("", "", reason, "sort the rows by the time: loading and unloading are mixed up")
    if len(turns) > 1 and n < _LEAST_LEG * (len(turns) + 1):
        reason = f"the {way} turns round {len(turns)} times in {n} rows, first at {s.where(turns[0])}"
        order = f"give the rows in the order measured, a curve of loading only in growing {way}"
        noisy = f'say by how much with reversal, e.g. "{"0.1 mm" if load.pushed else "0.5 deg total"}"'
        refuse("", "", reason, f"{order}; if the {way} is noisy, {noisy}")


def check_range(rec: Record, senses: Senses, lowest: float) -> None:
    """Refuse points where no trial has a contact that the model covers; ``senses`` are of the least friction."""
    problems = Problems()
    for sign, path in senses.paths.items():
        there = rec.asked & ((rec.load < 0) == (sign == "-"))
        beyond = there & (np.abs(rec.load) > senses.most[sign] * (1 + 1e-9))
        if not beyond.any():
            continue
        i = int(np.argmax(np.where(beyond, np.abs(rec.load), -1)))
        minus = "-" if sign == "-" else ""
        why = f"{path.end} at {minus}{per_pitch(path.load_end, 6)}"
        if path.end.locks:
            why += f", where the beam locks even with the least friction allowed, {lowest:g}"
        elif path.other:
            why = f"{minus}{per_pitch(senses.most[sign], 6)}, where another contact comes in: {path.other}"
        points = f"{np.count_nonzero(beyond)} of {rec.load.size} points, the farthest at {per_pitch(rec.load[i], 6)}"
        reason = f"{points}, lie beyond what the model covers: {why}"
        geometry = "check the unit of the twist and the geometry in the beam file"
        remedy = f'{geometry}, or use the points before only with to "{at_most(senses.most[sign])}"'
        problems.add(rec.where(i), "", reason, remedy)
    problems.settle()


class Ways(NamedTuple):
    """Of each point the ``direction`` (+1 or -1), and whether it may be ``stuck``; indices of the turning points."""

    direction: NDArray[np.int64]
    stuck: NDArray[np.bool_]
    turns: list[int]


def turning_points(values: Array, tolerance: float) -> list[int]:
    """Return the indices of the turning points, after which the twist goes back by more than ``tolerance``."""
    found: list[int] = []
    # the farthest point in either direction since the last turn; before the first turn both directions are open
    farthest, way = {1: 0, -1: 0}, 0
    for i in range(1, values.size):
        for side in (1, -1) if not way else (way,):
            if side * (values[i] - values[farthest[side]]) > 0:
                farthest[side] = i
            elif side * (values[farthest[side]] - values[i]) > tolerance:
                found += [farthest[side]] if way else []
                way, farthest[-side] = -side, i
                break
    return found


def ways(values: Array, own: Array | None = None, *, tolerance: float = 0.0, stick: float = 0.0) -> Ways:
    """Return for each point of a record the direction of the twist, and whether the contact may stick there.

    ``own``: twist of the specimen where it differs from the reading; ``tolerance``: backward twist that is noise;
    ``stick``: twist after a turning point within which the contact sticks.
    """
    n, own = values.size, values if own is None else own
    turns = turning_points(values, tolerance)
    direction, stuck = np.zeros(n, np.int64), np.zeros(n, bool)
    starts, ends = [0, *turns], [*turns, n - 1]
    width = max(tolerance, stick)
    for number, (a, b) in enumerate(zip(starts, ends, strict=True)):
        # a record that does not move came from rest
        way = int(np.sign(values[b] - values[a]) or np.sign(values[a]) or 1)
        direction[a + 1 if number else 0 : b + 1] = way
        # a record that begins with unloading: the history before its first point is unknown
        if number or way * values[a] < 0:
            first = a + 1 if number else a
            away = way * (own[first : b + 1] - own[a]) > width
            stuck[first : first + (int(away.argmax()) if away.any() else away.size)] = True
    return Ways(direction, stuck, turns)


class Swings(NamedTuple):
    """The record of a decay (s, rad per pitch) after its ``release``, with the ``turns`` that follow."""

    t: Array
    y: Array
    turns: list[int]
    release: float
    start: float


def swings(specimens: list[Measured], pitch: float) -> Swings:
    """Find the turning points of the record of a decay; refuse a record of another kind."""
    given, *more = specimens
    place = given.file or given.label
    if more:
        refuse(given.file or "data", "", f"has {len(specimens)} specimens", "give one decay")
    t, y = given.load, given.rate * pitch
    back = np.flatnonzero(np.diff(t) <= 0)
    if back.size:
        refuse(given.where(int(back[0]) + 1), "", "the time does not grow", "give the rows in the order measured")
    if t.size < _SWINGS or not np.ptp(y) > 0:
        refuse(place, "", f"{t.size} points, {per_pitch(np.ptp(y))} apart, are no decay", f"give {_SWINGS} or more")
    sigma = scatter(y, np.zeros(y.size))
    reach = max(_BACK * float(np.ptp(y)), min(_TIMES * sigma, 0.1 * float(np.ptp(y))))
    turns = turning_points(y, reach)
    if len(turns) > 1 and y[0] * y[turns[0]] < 0 and abs(y[0]) > reach:
        # released at the first row, or held until it moves
        held = np.flatnonzero(np.abs(y[: turns[0]] - y[0]) > reach / 2)
        last = max(int(held[0]) - 1, 0) if held.size else 0
        return Swings(t, y, turns, float(np.median(y[: last + 1])), float(t[last]))
    if len(turns) < 3:
        refuse(place, "", f"too few turning points: {len(turns)}", "give a record of one swing there and back, or more")
    first = turns[0]
    after = first + 1
    return Swings(t[after:], y[after:], [i - after for i in turns[1:]], float(y[first]), float(t[first]))
