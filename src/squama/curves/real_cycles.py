"""Loading, unloading and reversal of the real beam: its path is walked through a history of twists, or of bends.

Nothing is a function of the load alone: the scales' motions depend on the way. After a reversal the contact sticks
while the friction turns round (docs, theory: cycles).
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from typing import NamedTuple, NoReturn

import numpy as np

from squama.beam.design import Beam
from squama.contacts import increments, path
from squama.curves import real
from squama.curves.curve_figures import loop_figures, loop_table, used_senses, work_error
from squama.curves.cycle_points import evenly, goals_of, resolving
from squama.curves.real_figures import by_load, exchanged, touching, values
from squama.curves.way import Asked, States, Stations, direction
from squama.errors import InputError, Problem, refuse
from squama.loads import Load
from squama.model import history
from squama.model.outcome import SENTENCES, End
from squama.symbols import OTHER
from squama.types import Array

INCREMENT = 5e-4
"""Largest increment of the load angle, rad per pitch: work and dissipation agree to some 1e-4 with it."""
MOST = 100_000
"""Increments of a history at most."""
_BEFORE = 1e-4
"""By how much a state is put before engagement, rad per pitch: at engagement itself a contact may not be found."""
_INNER = ("mode", "onset", "work", "RED", "f0", f"f0{OTHER}")
"""Names of variables that no cycle tells."""
_BRANCHES = np.array(["straight", "loading", "unloading", "stick"])


class _Way(NamedTuple):
    """A history: signed twists of its points, their legs, the number of each value's point; modes once it is walked.

    ``told``: whether a point was asked for, or only resolves a reversal.
    """

    twists: Array
    legs: Array
    turns: list[int]
    told: Array
    mode: Array = np.empty(0)


def walk(asked: Asked) -> States:
    """Return the states along a history, its loops, and what holds for each sense.

    Each way has the points that are asked, evenly, and one where contact begins or ends, and where the scales slide
    again after a reversal. A history on which the contact ends is refused: the twist, and what happens there.
    """
    goals, beam, load = asked.way.values, asked.beam, asked.way.load
    check(goals)
    ones = paths(beam, load, float(asked.mus), goals, ideal=asked.ideal)
    met = [sign * (c.phi - _BEFORE) for sign, one in ones.items() for c in one.way.contacts if c.first != -1]
    way = _points(goals, asked.points, _apart(met))
    try:
        found = follow(ones[1], load, way.twists, way.legs)
    except LeftError as left:
        _refuse(asked, left, goals[way.legs[left.point]])
    v = _values(ones, load, way.twists, found)
    rigidity = ones[1].case(load).rigidity
    way, along = _along(v, way._replace(mode=v["mode"]), rigidity)
    told = way.told
    residual = [_residual(ones[1], load, way, goals, loop) for loop in history.loops(goals)]
    by_dim: dict[tuple[str, ...], dict[str, Array]] = {
        ("point",): {
            "branch": along["branch"][told],
            "leg": way.legs[told],
            **{role: values[told] for role, values in along.items() if role not in (*_INNER, "branch")},
        },
        ("loop",): _loops(way, along, goals, beam.pitch, residual),
        ("sense",): _senses(ones, goals),
        (): {"energy_error": np.asarray(work_error(along))},
    }
    held = ones[1].held
    attrs = {**real.attributes(held, load.verb), "rigidity": rigidity, "increment": INCREMENT}
    return States(by_dim, attrs, real.notes(held, beam, max(map(abs, goals)), ideal=asked.ideal))


def paths(beam: Beam, load: Load, mu: float, goals: Sequence[float], *, ideal: bool) -> dict[int, real.Path]:
    """Return a beam by the senses that a history goes to, with what touches first there."""
    most = max(*map(abs, goals), path.RANGE)
    return {
        sign: real.Path.of(beam, mu, (load.verb,), ideal=ideal, toward=direction(load, sign), most=most)
        for sign in (-1 if sense == "-" else 1 for sense in used_senses(goals))
    }


def follow(one: real.Path, load: Load, x: Array, legs: Array | int = 1) -> path.Answers:
    """Follow a history of one load through signed values from 0 on.

    Raises
    ------
    LeftError
        There is no equilibrium on the history.
    """
    answers = one.way.along(Stations.along(load, x, legs).strains, INCREMENT)
    end = answers.end()
    if end.code != increments.RANGE:
        n = max(1, end.solved)
        gone = math.copysign(end.phi - np.abs(np.diff(x[:n])).sum(), x[n] - x[n - 1])
        raise LeftError(n, x[n - 1] + gone, SENTENCES[end.word], outward=abs(x[n]) > abs(x[n - 1]))
    return answers


def _values(ones: dict[int, real.Path], load: Load, x: Array, found: path.Answers) -> dict[str, Array]:
    """Return every variable along a history, SI units, by role; of twists each sense as its curve tells it."""
    turned = np.where(x < 0, -1.0, 1.0)
    v = values(
        ones[1],
        Stations.along(load, x).strains,
        *(face.rows[0] for face in found.faces),
        turned=turned if load.sided else 0.0,
    )
    own = by_load(v, load)
    own["onset"] = own["onset"] * np.where(np.diff(x, prepend=0.0) < 0, -1.0, 1.0)
    if not load.sided:
        return own | touching(found)
    leads = {sign: one.lead for sign, one in ones.items()}
    return exchanged(own, np.where(turned < 0, leads.get(-1, 0), leads[1]) == 1)


def check(values: Sequence[float]) -> None:
    """Refuse a history that is too far or too long to be walked."""
    far = max(values, key=abs)
    if abs(far) >= math.pi:
        refuse("twist", f"{far:.6g} rad/pitch", "must be below half a turn per pitch")
    way = sum(abs(b - a) for a, b in itertools.pairwise(values))
    if way > MOST * INCREMENT:
        reason = f"the beam would have to be walked over {way:.4g} rad per pitch in increments of {INCREMENT:g}"
        refuse("twist", "", reason, f"give at most {MOST * INCREMENT:.4g}, by fewer twists or loops")


def _apart(places: list[float]) -> list[float]:
    """Return rising places without those that all but equal the one before: both faces may engage at once."""
    return [x for before, x in itertools.pairwise([-math.inf, *sorted(places)]) if x - before > _BEFORE]


def _points(values: list[float], points: int, engaged: list[float]) -> _Way:
    """Return the points of a history, and where contact begins and ends; after a reversal the first steps are small."""
    twists, legs, turns, told = [0.0], [1], [0], [True]
    reversals = set(history.reversals(values))
    for i, (start, stop) in enumerate(itertools.pairwise(values)):
        even = evenly(start, stop, values[: i + 1], points, engaged)
        small = resolving(start, even[0]) if i in reversals else []
        twists += [*small, *even]
        told += [False] * len(small) + [True] * len(even)
        turns.append(len(twists) - 1)
        legs += [i + 1] * (len(twists) - len(legs))
    return _Way(np.array(twists), np.array(legs), turns, np.array(told))


class LeftError(InputError):
    """A history on which the contact ends before its point number ``point``, at the load angle ``far`` per pitch.

    ``outward``: on a way on which the load grows.
    """

    def __init__(self, point: int, far: float, why: str, *, outward: bool) -> None:
        super().__init__(Problem("twist", "", f"the contact is followed to {far:.5g} rad/pitch: {why}"))
        self.point, self.far, self.outward = point, far, outward


def _refuse(asked: Asked, left: LeftError, goal: float) -> NoReturn:
    """Refuse a history on which the contact ends on the way to a value, and say how far it may go."""
    remedy = "turn round before"
    if left.outward and left.far:
        digits = 10.0 ** (math.floor(math.log10(abs(left.far))) - 3)
        # after a reversal the contact goes on a little before it comes back
        most = math.copysign(math.floor(0.999 * abs(left.far) / digits) * digits, left.far)
        total = math.degrees(most) * asked.beam.scales
        remedy = f'give at most "{most:.4g} rad/pitch" ({total:.4g} deg total)'
    refuse("twist", asked.way.said(goal), left.problems[0].reason, remedy)


def _along(v: dict[str, Array], way: _Way, rigidity: float) -> tuple[_Way, dict[str, Array]]:
    """Return every variable along the history, by role, with what follows from its ways, and these."""
    v = dict(v)
    for role in ("f", f"f{OTHER}"):
        if role in v:
            v[role] = v[role] * np.where(np.diff(np.abs(way.twists), prepend=0.0) < 0, -1.0, 1.0)
    way, v = _sliding(way, v)
    size = np.abs(way.twists)
    inward = np.diff(size, prepend=0.0) < 0
    v["tangent"] = np.empty(size.size)
    for a, b in itertools.pairwise(way.turns):
        slope = np.gradient(v["torque"][a : b + 1], v["rate"][a : b + 1])
        v["tangent"][a + 1 : b + 1] = slope[1:]
        if a == 0:
            v["tangent"][0] = slope[0]
    v["stiffness_ratio"] = v["tangent"] / rigidity
    branch = np.where(way.mode == path.STICK, 3, np.where(inward, 2, 1)) * (way.mode != path.FREE)
    v["branch"] = _BRANCHES[branch.astype(int)]
    return way, v


def _sliding(way: _Way, v: dict[str, Array]) -> tuple[_Way, dict[str, Array]]:
    """Add the points at which scales slide again after they stuck, where the torque's slope jumps.

    A contact that sticks is all but linear: its states go on as the last two, up to the torque at which it slides.
    """
    x, torque = way.twists, v["torque"]
    i = 1 + np.flatnonzero((way.mode[1:-1] == path.STICK) & (way.mode[2:] == path.SLIP))
    slope = (torque[i] - torque[i - 1]) / (x[i] - x[i - 1])
    ahead = np.divide(v["onset"][i + 1] - torque[i], slope, out=np.zeros(i.size), where=slope != 0)
    inside = (ahead / (x[i + 1] - x[i]) > 0) & (ahead / (x[i + 1] - x[i]) < 1)
    i, ahead = i[inside], ahead[inside]
    share = ahead / (x[i] - x[i - 1])

    def grown(values: Array) -> Array:
        new = values[i] + share * (values[i] - values[i - 1]) if values.dtype.kind == "f" else values[i]
        return np.insert(values, i + 1, new)

    turns = [n + int(np.searchsorted(i, n)) for n in way.turns]
    legs, told = np.insert(way.legs, i + 1, way.legs[i + 1]), np.insert(way.told, i + 1, True)
    own = _Way(grown(x), legs, turns, told, np.insert(way.mode, i + 1, path.STICK))
    v = {role: grown(values) for role, values in v.items()}
    new = i + 1 + np.arange(i.size)
    # what is left of the friction while it turns round lies across; where the scales slide it is all there
    for face in ("", OTHER):
        if f"f{face}" in v:
            f, N = v[f"f{face}"], v[f"N{face}"]
            f[new] = N[new] * np.divide(f[new + 1], N[new + 1], out=0 * N[new], where=N[new + 1] > 0)
    return own, v


class _Closed(NamedTuple):
    """A loop by the numbers of its points: where it began, where it turned, where it closed."""

    loop: history.Loop
    began: int
    turned: int
    closed: int


def _closed(way: _Way, values: list[float]) -> list[_Closed]:
    found = []
    for loop in history.loops(values):
        # it closes where it began: the twist that the last way leads back to
        rising = values[loop.closed] > values[loop.closed - 1]
        first, other = sorted((loop.base, loop.top), reverse=rising)
        turned = [j for j in range(loop.closed) if values[j] == other][-1]
        began = [j for j in range(turned) if values[j] == first or j == 0][-1]
        last = range(way.turns[loop.closed - 1], way.turns[loop.closed] + 1)
        closed = next(i for i in last if way.twists[i] == first)
        found.append(_Closed(loop, way.turns[began], way.turns[turned], closed))
    return found


def _loops(way: _Way, v: dict[str, Array], values: list[float], d: float, residual: list[float]) -> dict[str, Array]:
    """Return the figures of every closed loop, by role."""
    rows: list[list[float]] = []
    done: list[tuple[_Closed, float]] = []
    for one, left in zip(_closed(way, values), residual, strict=True):
        dissipated = sum(float(v[role][one.closed] - v[role][one.began]) for role in ("W_fr", "W_snap"))
        # what has closed inside is a loop of its own
        dissipated -= sum(w for c, w in done if one.began <= c.began and c.closed <= one.closed)
        done.append((one, dissipated))
        outward = abs(way.twists[one.turned]) > abs(way.twists[one.began])
        top, base = (one.turned, one.closed) if outward else (one.began, one.turned)
        stuck = top
        while stuck + 1 < way.twists.size and v["branch"][stuck + 1] == "stick":
            stuck += 1
        slides = stuck + 1 < way.twists.size and way.mode[stuck + 1] == path.SLIP
        drop = v["onset"][stuck + 1] if slides else v["torque"][stuck]
        elastic = float(v["U_el"][top])
        rows.append(
            loop_figures(
                (one.loop.base, one.loop.top),
                d,
                dissipated=dissipated,
                elastic=elastic,
                torques=(float(v["torque"][top]), float(drop), float(v["torque"][base])),
                residual=left,
            )
        )
    return loop_table(rows)


def _residual(one: real.Path, load: Load, way: _Way, goals: Sequence[float], loop: history.Loop) -> float:
    """Return the load that is left when the beam is let go at a loop's top: where its torque comes to zero."""
    end = way.turns[list(goals).index(loop.top)]
    down = np.array(goals_of(loop.top, 0.0, 60))
    x = np.append(way.twists[: end + 1], down)
    try:
        found = follow(one, load, x, np.append(way.legs[: end + 1], [way.legs[end] + 1] * down.size))
    except LeftError:
        return 0.0
    v = [path.named(face.rows[0, end + 1 :]) for face in found.faces]
    pressed = np.sum([face["N"] for face in v], axis=0)
    sign = math.copysign(1.0, loop.top)
    torque = sign * v[0]["torque" if load.sided else "M"]
    return sign * _crossing(sign * down, torque, pressed)


def _crossing(x: Array, torque: Array, N: Array) -> float:
    """Return the twist at which a torque comes to zero on the way back while scales still press; 0 where none does."""
    i = int(np.argmax(torque <= 0))
    if i == 0 or x[i] == 0 or N[i] == 0:
        return 0.0
    share = torque[i - 1] / (torque[i - 1] - torque[i])
    return float(x[i - 1] + share * (x[i] - x[i - 1]))


def _senses(ones: dict[int, real.Path], goals: Sequence[float]) -> dict[str, Array]:
    """Return what holds for either sense that the history goes to."""
    rows = []
    for sign, one in ones.items():
        contact = one.contact(one.lead)
        rows.append({
            "load_e": contact.phi, "load_end": max(*(v * sign for v in goals), 0.0),
            "neighbour": max(0, contact.k), "first_contact": contact.words, "other_contact": "",
            "end": str(End.NONE if contact.first == -1 else End.RANGE),
        })  # fmt: skip
    senses = np.array(used_senses(goals))
    return {"sense": senses, **{role: np.array([row[role] for row in rows]) for role in rows[0]}}
