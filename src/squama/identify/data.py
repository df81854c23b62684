"""Measured records for a fit: where they come from, what is refused, and how each point was reached."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from squama import checks, measured
from squama.design import Beam
from squama.errors import InputError
from squama.histories import Senses
from squama.identify.branches import ways
from squama.measured import Specimen
from squama.model.solve import Array
from squama.units import QuantityError, curvature, twist

MOST = 1_000_000
"""Most points of all specimens."""
_LEAST_LEG = 3
_KEYS = {
    "twisting": ((("Phi", "rate"), ("phi", "pitch"), ("total", "total")), "T"),
    "bending": ((("kappa", "rate"), ("psi", "pitch"), ("total", "total")), "M"),
}


class Record(NamedTuple):
    """Points of all specimens, one behind the other.

    ``specimen`` is the place of each point's specimen; ``load`` the signed load angle per pitch; ``torque`` N m;
    ``way`` +1 where its magnitude grew, -1 where it fell; ``stuck`` where the contact may stick; ``asked`` whether
    the point is within the range that is asked for.
    """

    specimens: list[Specimen]
    specimen: NDArray[np.int64]
    load: Array
    torque: Array
    way: Array
    stuck: NDArray[np.bool_]
    asked: NDArray[np.bool_]

    def where(self, i: int) -> str:
        """Name the place of a point in messages."""
        s = int(self.specimen[i])
        return self.specimens[s].where(i - int(np.argmax(self.specimen == s)))


def read(given: Any, beam: Beam, load: str) -> list[Specimen]:
    """Return the specimens of a file, of several files, of a dataset or of arrays.

    Parameters
    ----------
    given
        A path; a sequence of paths, datasets or mappings; a dataset of :func:`squama.cycle` or another mapping with
        ``Phi`` (rad/m) or ``phi`` (rad per pitch) or ``total`` (rad) and ``T`` (N m), in bending ``kappa`` or ``psi``
        and ``M``.

    Raises
    ------
    InputError
        What is given cannot be used; one line per mistake.
    """
    items = list(given) if isinstance(given, Sequence) and not isinstance(given, str) else [given]
    if items and all(isinstance(item, Specimen) for item in items):
        return list(items)
    if isinstance(given, Specimen | measured.Measured):
        items = [given]
    if not items:
        checks.fail("data: is empty; give a file, or several")
    found: list[Specimen] = []
    problems: list[str] = []
    for i, item in enumerate(items):
        try:
            if isinstance(item, str | os.PathLike):
                found += measured.read_specimens(item, pitch=beam.pitch, scales=beam.scales, load=load)
            else:
                found.append(_arrays(item, f"data[{i}]" if len(items) > 1 else "data", beam, load))
        except InputError as error:
            problems += str(error).splitlines()
    if problems:
        raise InputError("\n".join(problems))
    return _named_apart(found)


def _named_apart(found: list[Specimen]) -> list[Specimen]:
    """Give specimens of one name (from several files) the file's name, or a number."""
    labels = [s.label for s in found]
    out = []
    for i, s in enumerate(found):
        again = labels[: i + 1].count(s.label)
        out.append(s if labels.count(s.label) == 1 else s._replace(label=f"{s.label} {again}"))
    return out


def _arrays(item: Any, name: str, beam: Beam, load: str) -> Specimen:
    """Return a specimen from a mapping or dataset by the symbols of its variables."""
    if isinstance(item, Specimen):
        return item
    if isinstance(item, measured.Measured):
        item = {_KEYS[load][0][0][0]: item.rate, _KEYS[load][1]: item.load}
    abscissas, torque = _KEYS[load]
    wanted = f'"{abscissas[0][0]}" (rad/m) and "{torque}" (N m)'
    if not isinstance(item, Mapping) and not hasattr(item, "data_vars"):
        checks.fail(f"{name}: is no file and has no columns; give a path, a dataset, or a mapping with {wanted}")
    per = {"rate": 1.0, "pitch": beam.pitch, "total": beam.length}
    key = next((k for k, _ in abscissas if k in item), None)
    if key is None or torque not in item:
        checks.fail(f"{name}: has no {wanted}; give both")
    over = per[dict(abscissas)[key]]
    columns = []
    for column in (key, torque):
        values = item[column]
        array = checks.numbers(f'{name}["{column}"]', getattr(values, "values", values))
        if array.ndim != 1:
            checks.fail(f'{name}["{column}"]: must be one-dimensional, not of shape {array.shape}; give one curve')
        columns.append(array)
    rate, values = columns
    if rate.size != values.size:
        checks.fail(f"{name}: {rate.size} twists but {values.size} torques; give one torque for each twist")
    return Specimen(rate / over, values, name)


def record(
    specimens: list[Specimen], beam: Beam, load: str, *, to: Any = None, reversal: Any = 0.0, stick: Any = 0.0
) -> Record:
    """Put specimens one behind the other, and tell how every point was reached.

    Parameters
    ----------
    to
        Twist (magnitude) beyond which points are not used; all are if None.
    reversal, stick
        Way back that is noise of the twist, and way after a turning point on which the contact sticks.

    Raises
    ------
    InputError
        A record that does not move, whose torque is constant, or that is not in the order measured.
    """
    limit = np.inf if to is None else _angle("to", to, beam, load)
    back, hold = _angle("reversal", reversal, beam, load), _angle("stick", stick, beam, load)
    if limit <= 0:
        checks.fail('to: must be above 0; write e.g. "0.1 rad/pitch"')
    if sum(s.rate.size for s in specimens) > MOST:
        checks.fail(f"data: more than {MOST} points are too many; thin them out")
    problems = []
    parts = []
    for number, s in enumerate(specimens):
        angle = s.rate * beam.pitch
        place = s.label if s.lines is None else f"{s.file}: specimen {s.label}" if len(specimens) > 1 else s.file
        found = ways(angle, tolerance=back, stick=hold)
        problem = _unusable(s, found.turns)
        if problem:
            problems.append(f"{place}: {problem}")
        way = found.direction * np.where(angle < 0, -1, 1)
        parts.append((np.full(angle.size, number), angle, s.load, way, found.stuck, np.abs(angle) <= limit))
    if problems:
        raise InputError("\n".join(problems))
    columns = [np.concatenate(column) for column in zip(*parts, strict=True)]
    return Record(specimens, *columns)


def _angle(name: str, value: Any, beam: Beam, load: str) -> float:
    """Return an angle per pitch from a rate (rad/m) or a text such as "0.1 rad/pitch"."""
    reader = twist if load == "twisting" else curvature
    try:
        rate = reader(value, pitch=beam.pitch, scales=beam.scales)
    except QuantityError as error:
        message = f"{name} = {error.shown}: {error.reason}"
        raise InputError(message) from None
    if rate < 0:
        checks.fail(f"{name} = {rate:.6g} rad/m: must be 0 or more; give its magnitude")
    return rate * beam.pitch


def _unusable(s: Specimen, turns: list[int]) -> str | None:
    """Say what makes a record unusable; None if nothing does."""
    n = s.rate.size
    if n > 1 and np.ptp(s.rate) == 0:
        return f"the twist is {s.rate[0]:.6g} rad/m in every row; a fit needs points at different twists"
    if not s.load.any():
        return "the torque is 0 in every row; check the column and the load cell"
    if n > 1 and np.ptp(s.load) == 0:
        return f"the torque is {s.load[0]:.6g} N m in every row; check the column and the load cell"
    if float(s.rate @ s.load) < 0:
        return "torque and twist have opposite signs; turn the sign of one of them"
    if len(turns) > 1 and n < _LEAST_LEG * (len(turns) + 1):
        return (
            f"the twist turns round {len(turns)} times in {n} rows, first at {s.where(turns[0])}; give the rows in the "
            "order measured, a curve of loading only in growing twist; if the twist is noisy, say by how much with "
            'reversal, e.g. "0.5 deg total"'
        )
    return None


def check_range(rec: Record, senses: Senses, lowest: float) -> None:
    """Refuse points where no trial has a contact that the model covers.

    Parameters
    ----------
    senses
        Both senses, solved for the smallest friction of all trials.
    lowest
        That friction.

    Raises
    ------
    InputError
        One line for each sense that is left: how many points, the farthest, why, and what to do.
    """
    problems = []
    for sign, path in senses.paths.items():
        there = rec.asked & ((rec.load < 0) == (sign == "-"))
        beyond = there & (np.abs(rec.load) > senses.most[sign] * (1 + 1e-9))
        if not beyond.any():
            continue
        i = int(np.argmax(np.where(beyond, np.abs(rec.load), -1)))
        minus = "-" if sign == "-" else ""
        why = f"{path.end} at {minus}{path.load_end:.6g} rad/pitch"
        if path.end.locks:
            why += f", where the beam locks even with the least friction allowed, {lowest:g}"
        elif path.other:
            why = f"{minus}{senses.most[sign]:.6g} rad/pitch, where another contact comes in: {path.other}"
        low = np.floor(senses.most[sign] * 1e4) / 1e4
        problems.append(
            f"{rec.where(i)}: {np.count_nonzero(beyond)} of {rec.load.size} points, the farthest at "
            f"{rec.load[i]:.6g} rad/pitch, lie beyond what the model covers: {why}; check the geometry in the beam "
            f'file, or use the points before only with to "{low:g} rad/pitch"'
        )
    if problems:
        raise InputError("\n".join(problems))
