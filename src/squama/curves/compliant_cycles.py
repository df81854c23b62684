"""Loading, unloading and reversal of thick, elastic scales along a history of twists, or of bends.

No result is a function of the load alone: the scales' motions depend on the way. After a reversal the contact sticks
while the friction turns round (docs, theory: cycles).
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from typing import NoReturn

import numpy as np

from squama.beam.design import Beam
from squama.contacts import events, increments, path, row
from squama.contacts.row import Track
from squama.contacts.ties import KINDS
from squama.curves import compliant, rows
from squama.curves.compliant_figures import by_load, exchanged, touching, values
from squama.curves.curve_figures import loop_figures, loop_table, table, used_senses, work_error
from squama.curves.hinge_cycles import BRANCHES, STRAIGHT
from squama.curves.way import Analysis, States, Stations, direction
from squama.errors import InputError, Problem, refuse
from squama.loads import Load
from squama.model import history
from squama.model.outcome import SENTENCES, End
from squama.people import at_most, per_pitch
from squama.symbols import OTHER
from squama.types import Array

INCREMENT, OF_ROWS = 5e-4, 2e-3
"""Largest increments of the load angle, rad per pitch, for an endless beam and for N scales, whose contacts come in one
by one: work and dissipation agree to about 1e-4 with them.
"""
MOST = 100_000
"""Largest number of increments of a history."""
_BEFORE = 1e-4
"""Distance of a state before engagement, rad per pitch."""
_APART, _FULL = 1e-6, 1e-9
"""Smallest distance of states, rad per pitch, and distance below which two are the same."""
LET_GO = 60
"""Number of points along which a beam is released."""
_INNER = ("mode", "onset", "work", "RED", "f0", f"f0{OTHER}")
"""Variables that cycles leave out."""


def walk(analysis: Analysis) -> States:
    """Return the states along a history, its loops, and the values for each sense.

    Each leg has the requested points, evenly spaced, and a point where contact begins or ends, and where the scales
    slide again after a reversal. A history on which the contact ends is refused, with the twist and the reason.
    """
    goals, beam, load = analysis.way.values, analysis.beam, analysis.way.load
    check(goals)
    ones = paths(beam, load, float(analysis.mus), goals, ideal=analysis.ideal)
    one, kind = ones["+"], KINDS.get(analysis.ends)
    rows.check_ends(kind, one.held, beam.pitches)
    engaged = [sum(o.toward) * (c.phi - _BEFORE) for o in ones.values() for c in o.way.contacts if c.first != -1]
    # both faces may engage at once
    apart = [x for before, x in itertools.pairwise([-math.inf, *sorted(engaged)]) if x - before > _BEFORE]
    stations = _stations(load, goals, analysis.points, apart)
    slid: Array = np.zeros(0, int)
    each: dict[str, Array] = {}
    notes = compliant.notes(one.held, beam, max(map(abs, goals)), ideal=analysis.ideal)
    try:
        if kind is None:
            stations, slid = _with_slides(stations, follow(one, stations))
            v = _values(ones, load, stations, follow(one, stations))
        else:
            v, each, more = _of_row(ones, load, stations, kind)
            notes += [*more, *rows.shifted(beam)]
    except LeftError as left:
        leg = stations.legs[left.point]
        _refuse(analysis, left, goals[leg if left.outward else leg - 1])
    rigidity = one.case(load).rigidity
    v["mode"][slid] = path.STICK
    v = _along(v, stations, rigidity)
    by_dim: dict[tuple[str, ...], dict[str, Array]] = {
        ("point",): {
            "branch": v["branch"],
            "leg": stations.legs,
            **{role: values for role, values in v.items() if role not in (*_INNER, *each, "branch")},
        },
        ("loop",): _loops(one, load, stations, v, goals, kind),
        ("sense",): table([_of_sense(one, sense, goals) for sense, one in ones.items()]),
        (): {"energy_error": np.asarray(work_error(v))},
    }
    held = one.held
    attrs = {**compliant.attributes(held, load.verb), "rigidity": rigidity, "increment": INCREMENT}
    if kind is not None:
        by_dim["point", "scale"] = {role: values for role, values in each.items() if role not in _INNER}
        attrs |= {"ends": analysis.ends, "increment": OF_ROWS}
    return States(by_dim, attrs, notes)


def paths(beam: Beam, load: Load, mu: float, goals: Sequence[float], *, ideal: bool) -> dict[str, compliant.Path]:
    """Return a beam's paths by the senses "+" and "-" of a history, with the first contact in each."""
    most, how = max(*map(abs, goals), path.RANGE), {"+": direction(load, 1), "-": direction(load, -1)}
    return {
        sense: compliant.Path.of(beam, mu, (load.verb,), ideal=ideal, toward=how[sense], most=most)
        for sense in used_senses(goals)
    }


def follow(one: compliant.Path, stations: Stations) -> path.Answers:
    """Follow a history of one load from rest; raise :class:`LeftError` if no equilibrium is found on it."""
    answers = one.way.along(stations.strains, INCREMENT)
    _goes_on(answers.end(), stations.loads)
    return answers


def _goes_on(end: path.End, x: Array) -> None:
    """Refuse a history of load angles x (n,) that ends before the last of them."""
    if end.code != increments.RANGE:
        n = max(1, end.solved)
        gone = math.copysign(end.phi - np.abs(np.diff(x[:n])).sum(), x[n] - x[n - 1])
        raise LeftError(n, x[n - 1] + gone, SENTENCES[end.word], outward=abs(x[n]) > abs(x[n - 1]))


def _row(one: compliant.Path, load: Load, x: Array, kind: int) -> Track:
    """Follow a history of all scales of a beam from rest, with ends of a kind."""
    return row.track(one.way, one.beam.pitches, x, OF_ROWS, ends=kind, load=load.axis)


def reached(one: compliant.Path, load: Load, x: Array, kind: int | None) -> tuple[list[dict[str, Array]], path.End]:
    """Follow a history of load angles x (n,) from rest, for N scales with ends of a ``kind``, or endless (None).

    Returns the states by name up to the end, of each scale or of each face, and the end; the torque is the beam's.
    """
    if kind is None:
        answers = one.way.along(Stations.along(load, x).strains, INCREMENT)
        end = answers.end()
        n = x.size if end.code == increments.RANGE else end.solved
        return [path.named(face.rows[0, :n]) for face in answers.faces], end
    track = _row(one, load, x, kind)
    return by_scale(track), track.end


def by_scale(track: Track) -> list[dict[str, Array]]:
    """Return the states of each scale of each face, by name."""
    return [path.named(scale) for face in track.faces for scale in face.rows.swapaxes(0, 1)]


def torque(states: Sequence[Mapping[str, Array]], load: Load) -> Array:
    """Return the beam's torque, or its moment for a bend, from the states of :func:`reached`, over E d^3."""
    return states[0]["torque" if load.sided else "M"]


def pressed(one: compliant.Path, load: Load, x: Array, kind: int | None) -> list[dict[str, Array]]:
    """Return the states of :func:`reached`; refuse a history that ends early, as :func:`follow` does."""
    states, end = reached(one, load, x, kind)
    _goes_on(end, x)
    return states


def _of_row(
    ones: Mapping[str, compliant.Path], load: Load, stations: Stations, kind: int
) -> tuple[dict[str, Array], dict[str, Array], tuple[str, ...]]:
    """Return the variables along a history of N scales, SI units, by role: of the beam, and of each scale; notes."""
    x, one = stations.loads, ones["+"]
    track = _row(one, load, x, kind)
    _goes_on(track.end, x)
    turned = np.where(x < 0, -1.0, 1.0) if load.sided else 0.0
    along, each = rows.of_scales(one, load, stations.strains, track, turned)
    along["onset"] = along["onset"] * np.where(np.diff(x, prepend=0.0) < 0, -1.0, 1.0)
    if load.sided:
        each = exchanged(each, _exchanged(ones, x)[:, None])
    for role in {"f", f"f{OTHER}"} & each.keys():
        each[role] = each[role] * np.where(np.diff(np.abs(x), prepend=0.0) < 0, -1.0, 1.0)[:, None]
    notes = rows.remarks(track, float(np.abs(x).max()), kind, load)
    return along, each | rows.cells_of(one, track, kind, load), notes


def _values(
    ones: Mapping[str, compliant.Path], load: Load, stations: Stations, found: path.Answers
) -> dict[str, Array]:
    """Return the variables along a history, SI units, by role; in twisting each sense as in its own curve."""
    x = stations.loads
    turned = np.where(x < 0, -1.0, 1.0)
    rows = (face.rows[0] for face in found.faces)
    v = by_load(values(ones["+"], stations.strains, *rows, turned=turned if load.sided else 0.0), load)
    v["onset"] = v["onset"] * np.where(np.diff(x, prepend=0.0) < 0, -1.0, 1.0)
    if not load.sided:
        return v | touching(found)
    return exchanged(v, _exchanged(ones, x))


def _exchanged(ones: Mapping[str, compliant.Path], x: Array) -> Array:
    """Return whether a scale's variables at load angles x (n,) are those of the other face, which touches first."""
    leads = {sense: one.lead for sense, one in ones.items()}
    return np.asarray(np.where(x < 0, leads.get("-", 0), leads["+"]) == 1)


def check(values: Sequence[float]) -> None:
    """Refuse a history that is too far or too long to be computed."""
    far = max(values, key=abs)
    if abs(far) >= math.pi:
        refuse("twist", per_pitch(far, 6), "must be below half a turn per pitch")
    way = sum(abs(b - a) for a, b in itertools.pairwise(values))
    if way > MOST * INCREMENT:
        reason = f"the beam would have to be walked over {per_pitch(way)} in increments of {per_pitch(INCREMENT)}"
        refuse("twist", "", reason, f"give at most {at_most(MOST * INCREMENT)}, by fewer twists or loops")


def _stations(load: Load, goals: Sequence[float], points: int, engaged: Sequence[float]) -> Stations:
    """Return the stations of a history: even ones, its values, and places where contact begins and ends."""
    x, legs = [0.0], [1]
    for i, (start, stop) in enumerate(itertools.pairwise(goals)):
        x += evenly(start, stop, goals[: i + 1], points, engaged)
        legs += [i + 1] * (len(x) - len(legs))
    return Stations.along(load, np.array(x), np.array(legs))


def evenly(
    start: float, stop: float, earlier: Sequence[float], points: int, engaged: Sequence[float] = ()
) -> list[float]:
    """Return evenly spaced twists of a leg; some are replaced by 0, by places where loops may close or contact begins.

    ``points`` on each part in contact, a quarter of it (:data:`STRAIGHT`) on a part without contact.
    """
    way = math.copysign(1.0, stop - start)

    def within(v: float, least: float) -> bool:
        return (v - start) * way > least and (stop - v) * way > least

    cuts = sorted((v for v in engaged if within(v, _APART)), reverse=way < 0)
    kept = sorted({v for v in (0.0, *earlier) if within(v, _FULL)} | {stop})
    kept += [v for v in cuts if min(abs(v - u) for u in kept) > _APART]
    goals: list[float] = []
    for a, b in itertools.pairwise([start, *cuts, stop]):
        touches = not engaged or any((a + b) / 2 / v > 1 for v in engaged)
        n = points if touches else max(2, points // STRAIGHT)
        even = np.linspace(a, b, n + 1)[1:-1]
        goals += even[np.abs(even[:, None] - np.array(kept)).min(axis=1) > abs(b - a) / n * (0.5 + 1e-9)].tolist()
    return sorted([*goals, *kept], reverse=way < 0)


def _with_slides(stations: Stations, found: path.Answers) -> tuple[Stations, Array]:
    """Return the stations with those added at which scales slide again after sticking, and the indices of these."""
    ways = stations.ways
    told = {event.way for face in found.faces for event in events.events(face) if event.kind == increments.SLIDE}
    new = np.array([way for way in sorted(told) if np.abs(ways - way).min() > _APART])
    i = np.searchsorted(ways, new)
    at = np.column_stack([np.interp(new, ways, strain) for strain in stations.strains.T])
    strains, legs = np.insert(stations.strains, i, at, axis=0), np.insert(stations.legs, i, stations.legs[i])
    return Stations(np.insert(ways, i, new), strains, legs), i + np.arange(i.size)


class LeftError(InputError):
    """Error for a history on which the contact ends before point ``point``, at the load angle ``far`` per pitch.

    ``outward``: whether the load grows there.
    """

    def __init__(self, point: int, far: float, why: str, *, outward: bool) -> None:
        where = f"the contact is followed {'' if outward else 'back '}to {per_pitch(far, 5)}"
        super().__init__(Problem("twist", "", f"{where}: {why}"))
        self.point, self.far, self.outward = point, far, outward


def _refuse(analysis: Analysis, left: LeftError, goal: float) -> NoReturn:
    """Refuse a history on which the contact ends on the way to a value or back from it; name the largest load."""
    remedy = "turn round before that"
    if left.outward and left.far:
        # after a reversal the contact continues a little before it returns
        remedy = f'give at most "{at_most(0.999 * left.far)}"'
    refuse("twist", analysis.way.said(goal), left.problems[0].reason, remedy)


def _along(v: dict[str, Array], stations: Stations, rigidity: float) -> dict[str, Array]:
    """Return the variables along the history, by role, with branches and tangent stiffness added."""
    x = np.abs(stations.loads)
    inward = np.diff(x, prepend=0.0) < 0
    for role in ("f", f"f{OTHER}"):
        if role in v:
            v[role] = v[role] * np.where(inward, -1.0, 1.0)
    v["tangent"] = np.empty(x.size)
    for a, b in itertools.pairwise(stations.turns):
        slope = np.gradient(v["torque"][a : b + 1], v["rate"][a : b + 1])
        v["tangent"][a + bool(a) : b + 1] = slope[bool(a) :]
    v["stiffness_ratio"] = v["tangent"] / rigidity
    branch = np.where(v["mode"] == path.STICK, 3, np.where(inward, 2, 1)) * (v["mode"] != path.FREE)
    v["branch"] = np.array(BRANCHES)[branch.astype(int)]
    return v


def _loops(
    one: compliant.Path,
    load: Load,
    stations: Stations,
    v: Mapping[str, Array],
    goals: list[float],
    kind: int | None,
) -> dict[str, Array]:
    """Return the values of every closed loop, by role."""
    turns, x = stations.turns, stations.loads
    rows: list[list[float]] = []
    done: list[tuple[int, int, float]] = []
    for loop in history.loops(goals):
        # it closes where it began: at the twist to which the last leg returns
        rising = goals[loop.closed] > goals[loop.closed - 1]
        first, other = sorted((loop.base, loop.top), reverse=rising)
        there = [j for j in range(loop.closed) if goals[j] == other][-1]
        start = [j for j in range(there) if goals[j] == first or j == 0][-1]
        last = range(turns[loop.closed - 1], turns[loop.closed] + 1)
        began, turned, closed = turns[start], turns[there], next(i for i in last if x[i] == first)
        dissipated = sum(float(v[role][closed] - v[role][began]) for role in ("W_fr", "W_snap"))
        # a loop that closed inside counts by itself
        dissipated -= sum(work for a, b, work in done if began <= a and b <= closed)
        done.append((began, closed, dissipated))
        top, base = (turned, closed) if abs(x[turned]) > abs(x[began]) else (began, turned)
        stuck = top
        while stuck + 1 < x.size and v["branch"][stuck + 1] == "stick":
            stuck += 1
        slides = stuck + 1 < x.size and v["mode"][stuck + 1] == path.SLIP
        # N scales slide back one by one
        drop = v["torque"][stuck] if kind is None else np.float64(math.nan)
        if slides and kind is None:
            drop = v["onset"][stuck + 1]
        residual = _residual(one, load, stations, int(turns[goals.index(loop.top)]), kind)
        torques = [float(torque) for torque in (v["torque"][top], drop, v["torque"][base])]
        energies = dissipated, float(v["U_el"][top])
        rows.append(loop_figures(loop.base, loop.top, one.beam.pitch, energies, torques, residual))
    return loop_table(rows)


def _residual(one: compliant.Path, load: Load, stations: Stations, top: int, kind: int | None) -> float:
    """Return the residual load of the beam released at a point: where its torque comes to zero.

    0 if the torque does not vanish while scales still press.
    """
    begin, left = stations.loads[: top + 1], 0.0
    down: Array = np.array(evenly(begin[-1], 0.0, [], LET_GO))
    for _ in range(2):
        x = np.append(begin, down)
        try:
            v = pressed(one, load, x, kind)
        except LeftError:
            return 0.0
        x, force = x[top:], np.sum([scale["N"][top:] for scale in v], axis=0)
        T = np.sign(x[0]) * torque(v, load)[top:]
        i = int(np.argmax(T <= 0))
        if i == 0 or x[i] == 0 or force[i] == 0:
            return 0.0
        left = float(x[i - 1] + T[i - 1] / (T[i - 1] - T[i]) * (x[i] - x[i - 1]))
        # scales may stick and slide between two points: once more, close to it
        down = np.append(down[: i - 1], np.linspace(x[i - 1], x[i], LET_GO + 1)[1:])
    return left


def _of_sense(one: compliant.Path, sense: str, goals: Sequence[float]) -> dict[str, float | int | str]:
    """Return the single values for a sense of the history, by role."""
    contact, sign = one.contact(one.lead), -1 if sense == "-" else 1
    return {
        "sense": sense,
        "load_e": contact.phi,
        "load_end": max(*(v * sign for v in goals), 0.0),
        "neighbour": max(0, contact.k),
        "first_contact": contact.words,
        "other_contact": "",
        "end": str(End.NONE if contact.first == -1 else End.RANGE),
    }
