"""Loading, unloading and reversal of the real beam: its path is walked through a history of twists, or of bends.

Nothing is a function of the twist alone: the scales' motions depend on the way. After a reversal the contact sticks
while the friction turns round (docs, theory: cycles). Scales are apart at no twist, so each part of a history in one
sense begins anew there. A history of bends is a path of both loads that goes to and fro
(:mod:`squama.curves.real_polygons`); bent away from its scales nothing touches.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from typing import NamedTuple, NoReturn

import numpy as np

from squama.beam.design import Beam
from squama.contacts import increments, path, states
from squama.contacts.legs import follow_legs
from squama.curves import both_faces, real
from squama.curves.cycle_points import evenly, goals_of, resolving
from squama.curves.path import Asked, States, loop_figures, loop_table, used_senses
from squama.curves.real_polygons import Gone, Stations, go
from squama.errors import InputError, Problem, refuse
from squama.model import history
from squama.model.outcome import SENTENCES, End
from squama.types import Array

INCREMENT = 5e-4
"""Largest increment of the twist, rad per pitch: work and dissipation agree to some 1e-4 with it."""
MOST = 100_000
"""Increments of a history at most."""
_BEFORE = 1e-4
"""By how much a state is put before engagement, rad per pitch: at engagement itself a contact may not be found."""
_ALONG = (
    *("load", "rate", "theta", "torque", "scales", "tangent", "N", "f", "p", "s", "U_el", "W_fr", "W_snap"),
    *("T", "contact"),
    *real.OWN,
)  # fmt: skip
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


class _Walked(NamedTuple):
    """What a history of one load brings: variables ``along`` it by role and modes; ``rigidity`` without contact.

    ``senses``: what holds for each sense; ``left`` gives the twist that is left of a loop; ``held`` by the joint.
    """

    along: dict[str, Array]
    mode: Array
    rigidity: float
    senses: dict[str, Array]
    left: Callable[[history.Loop], float]
    held: real.Held


def walk(asked: Asked) -> States:
    """Return the states along a history, its loops, and what holds for each sense.

    Each way has the points that are asked, evenly, and one where contact begins or ends, and where the scales slide
    again after a reversal. A history on which the contact ends is refused: the twist, and what happens there.
    """
    values, beam = asked.path.values, asked.beam
    check(values)
    follower = _bent if asked.neutral else _twisted
    way = _points(values, asked.points, _engagements(asked))
    walked = follower(asked, way.twists, way.legs)
    way, along = _along(walked, way._replace(mode=walked.mode))
    far, told = max(map(abs, values)), way.told
    residual = [walked.left(loop) for loop in history.loops(values)]
    lost = float(along["W_fr"][-1] + along["W_snap"][-1])
    error = float(along["work"][-1]) - float(along["U_el"][-1]) - lost
    error /= max(lost, float(along["U_el"].max()), 1e-300)
    roles = [role for role in _ALONG if role in along]
    by_dim: dict[tuple[str, ...], dict[str, Array]] = {
        ("point",): {
            "branch": along["branch"][told],
            "leg": way.legs[told],
            **{role: along[role][told] for role in roles},
        },
        ("loop",): _loops(way, along, values, beam.pitch, residual),
        ("sense",): walked.senses,
        (): {"energy_error": np.asarray(error)},
    }
    attrs = {**real.attributes(walked.held, asked.path.load.verb), "rigidity": walked.rigidity, "increment": INCREMENT}
    return States(by_dim, attrs, real.notes(walked.held, beam, far, ideal=asked.ideal))


def check(values: list[float]) -> None:
    """Refuse a history that is too far or too long to be walked."""
    far = max(values, key=abs)
    if abs(far) >= math.pi:
        refuse("twist", f"{far:.6g} rad/pitch", "must be below half a turn per pitch")
    way = sum(abs(b - a) for a, b in itertools.pairwise(values))
    if way > MOST * INCREMENT:
        reason = f"the beam would have to be walked over {way:.4g} rad per pitch in increments of {INCREMENT:g}"
        refuse("twist", "", reason, f"give at most {MOST * INCREMENT:.4g}, by fewer twists or loops")


def _engagements(asked: Asked) -> list[float]:
    """Return the signed load angles just before scales come into contact, in the senses that a history goes to."""
    beam, mu, values = asked.beam, float(asked.mus), np.array(asked.path.values)
    held, plate = real.Held.of(beam, asked.path.load.verb), real.scale(beam, ideal=asked.ideal)
    if not asked.neutral:
        both = paths(beam, held, plate, mu, values)
        return [one.sign * (one.way.contact.phi - _BEFORE) for one in both.values() if one.way.contact.first != -1]
    found = []
    for far in (float(values.max()), float(values.min())):
        for view in both_faces.views(beam):
            ahead = np.array([(far, 0.0)]) * view
            met = follow_legs(plate, held.K, mu, ahead, **held.bar).answers.contact() if far else None
            found += [math.copysign(met.phi - _BEFORE, far)] if met and met.first != -1 else []
    return found


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


def _twisted(asked: Asked, twists: Array, legs: Array) -> _Walked:
    """Walk a history of twists, parts in one sense one after the other; refuse one on which the contact ends."""
    beam, values = asked.beam, asked.path.values
    held = real.Held.of(beam)
    both = paths(beam, held, real.scale(beam, ideal=asked.ideal), float(asked.mus), np.array(values))
    try:
        found = rows(both, twists, INCREMENT)
    except LeftError as error:
        _refuse(asked, error, values[legs[error.point]])
    size, negative = np.abs(twists), twists < 0
    parts = {sense: real.values(one, size, found) for sense, one in both.items()}
    v = dict(parts["+"])
    if "-" in parts:
        v = {role: np.where(negative, parts["-"][role], v[role]) for role in v}
    v = both_faces.total([v] * both_faces.alike(beam, "twisting"), held.rigidity)
    if beam.other and "M" in v:
        # the other face sees the bend in its own sense
        other = beam.other.seen[0]
        v["M"] = v["M"] * (1 + other if both_faces.alike(beam, "twisting") == 2 else np.where(negative, other, 1))
    sign = np.where(negative, -1.0, 1.0)
    v |= {role: v[role] * sign for role in ("load", "rate", "torque", "scales", "onset")}
    return _Walked(
        v,
        path.named(found)["mode"],
        held.rigidity,
        _senses(both, values),
        lambda loop: _residual(both, values, loop),
        held,
    )


def _bent(asked: Asked, bends: Array, legs: Array) -> _Walked:
    """Walk a history of bends; refuse one on which the contact ends."""
    values = asked.path.values

    def through(x: Array, numbers: Array) -> Gone:
        ways = np.concatenate([[0.0], np.cumsum(np.abs(np.diff(x)))])
        corners = [(v, 0.0) for v in x[np.append(np.flatnonzero(np.diff(numbers)), x.size - 1)].tolist()]
        whole = Stations(ways, np.column_stack([x, 0 * x]), numbers)
        return go(asked, float(asked.mus), lambda _: whole, corners, INCREMENT)

    gone = through(bends, legs)
    n = gone.along["psi"].size
    if n < bends.size:
        why, far = SENTENCES[End(gone.found.end)], float(gone.along["psi"][-1])
        _refuse(asked, LeftError(n, far, why, outward=abs(bends[n]) > abs(bends[n - 1])), values[legs[n]])
    v, bare = gone.bending()
    v["onset"] = v["onset"] * np.where(np.diff(bends, prepend=0.0) < 0, -1.0, 1.0)

    def left(loop: history.Loop) -> float:
        last = values.index(loop.top)
        down = np.array(goals_of(loop.top, 0.0, 60))
        end = int(np.flatnonzero(legs == last)[-1]) if last else 0
        there = through(np.append(bends[: end + 1], down), np.append(legs[: end + 1], [last + 1] * down.size)).along
        return _crossing(there["psi"][end + 1 :], there["M"][end + 1 :], there["N"][end + 1 :])

    met = gone.faces[0].met
    senses = [
        {
            "load_e": met[0] if sense == "+" else math.inf, "first_contact": met[1] if sense == "+" else "",
            "load_end": max(*(v if sense == "+" else -v for v in values), 0.0),
            "end": str(End.RANGE if sense == "+" and met[1] else End.NONE),
            "neighbour": int(sense == "+" and bool(met[1])), "other_contact": "",
        }
        for sense in used_senses(values)
    ]  # fmt: skip
    told = {"sense": np.array(used_senses(values))} | {k: np.array([row[k] for row in senses]) for k in senses[0]}
    return _Walked(v, v["mode"], bare, told, left, gone.one.held)


def paths(beam: Beam, held: real.Held, plate: path.Scale, mu: float, values: Array) -> dict[str, real.Path]:
    """Return what is followed in each sense that a history of twists goes to.

    Of scales on both faces one acts at a time, or both do the same: a history to where both touch is refused.
    """
    far, found, seen = float(np.abs(values).max()), {}, both_faces.sense(beam, "twisting")

    def way(sign: int) -> path.Path:
        return path.Path.of(plate, held.K, mu, sense=sign, most=max(far, path.RANGE), **held.bar)

    if seen < 0 and (first := way(-1).contact).first != -1 and first.phi < far:
        reason = f"is beyond {first.phi:.6g} rad/pitch, where the other face's scales touch too, which is not followed"
        refuse("twist", f"{far:.6g} rad/pitch", reason, "turn round before")
    for sense in used_senses(values.tolist()):
        sign = -1 if sense == "-" else 1
        found[sense] = real.Path(beam, held, way(1 if seen < 0 else sign), sign, far)
    return found


def rows(paths: dict[str, real.Path], x: Array, increment: float) -> Array:
    """Follow a history of signed twists from rest, 0 among them wherever it passes; return the states.

    Rows as of :class:`squama.contacts.path.Answers`.

    Raises
    ------
    LeftError
        The contact ends on the history.
    """
    sums = [path.COLUMNS.index(name) for name in ("W_fr", "W_snap", "W", "slip")]
    found, before = np.zeros((x.size, path.WIDTH)), np.zeros(len(sums))
    found[:, [path.COLUMNS.index(name) for name in ("x", "y")]] = np.nan
    # a part is what lies between two states without twist
    ends = [*np.flatnonzero(x == 0), x.size]
    for a, b in itertools.pairwise(ends):
        part = slice(a, min(b + 1, x.size))
        if part.stop - part.start < 2:
            continue
        one = paths["-" if x[a + 1] < 0 else "+"]
        own, end = one.way.states(np.abs(x[part]), increment)
        if end.code != increments.RANGE:
            error = _left(one, end, end.solved, x[part])
            error.point += part.start
            raise error
        own[:, sums] += before
        before = own[-1, sums]
        found[part] = own
    return found


class LeftError(InputError):
    """A history on which the contact ends before its point number ``point``, at the load angle ``far`` per pitch.

    ``outward``: on a way on which the load grows.
    """

    def __init__(self, point: int, far: float, why: str, *, outward: bool) -> None:
        super().__init__(Problem("twist", "", f"the contact is followed to {far:.5g} rad/pitch: {why}"))
        self.point, self.far, self.outward = point, far, outward


def _left(one: real.Path, end: path.End, point: int, x: Array) -> LeftError:
    """Return where the scales do not follow, on the way to twist number ``point`` of a part in one sense."""
    words, size = SENTENCES[end.word], np.abs(x)
    before, step = max(0, point - 1), float(np.diff(size, prepend=0.0)[point])
    far = float(size[before] + math.copysign(end.phi - np.abs(np.diff(size[: before + 1])).sum(), step))
    return LeftError(point, far * one.sign, words, outward=step > 0)


def _refuse(asked: Asked, left: LeftError, goal: float) -> NoReturn:
    """Refuse a history on which the contact ends on the way to a value, and say how far it may go."""
    remedy = "turn round before"
    if left.outward and left.far:
        digits = 10.0 ** (math.floor(math.log10(abs(left.far))) - 3)
        # after a reversal the contact goes on a little before it comes back
        most = math.copysign(math.floor(0.999 * abs(left.far) / digits) * digits, left.far)
        total = math.degrees(most) * asked.beam.scales
        remedy = f'give at most "{most:.4g} rad/pitch" ({total:.4g} deg total)'
    refuse("twist", asked.path.said(goal), left.problems[0].reason, remedy)


def _along(walked: _Walked, way: _Way) -> tuple[_Way, dict[str, Array]]:
    """Return every variable along the history, by role, with what follows from its ways, and these."""
    v = dict(walked.along)
    v["f"] = v["f"] * np.where(np.diff(np.abs(way.twists), prepend=0.0) < 0, -1.0, 1.0)
    way, v = _sliding(way, v)
    size = np.abs(way.twists)
    inward = np.diff(size, prepend=0.0) < 0
    v["tangent"] = np.empty(size.size)
    for a, b in itertools.pairwise(way.turns):
        slope = np.gradient(v["torque"][a : b + 1], v["rate"][a : b + 1])
        v["tangent"][a + 1 : b + 1] = slope[1:]
        if a == 0:
            v["tangent"][0] = slope[0]
    v["stiffness_ratio"] = v["tangent"] / walked.rigidity
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
    v["f"][new] = v["N"][new] * v["f"][new + 1] / v["N"][new + 1]
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


def _residual(paths: dict[str, real.Path], values: list[float], loop: history.Loop) -> float:
    """Return the twist that is left when the beam is let go at a loop's top: where the torque comes to zero."""
    last = values.index(loop.top)
    one = paths["-" if loop.top < 0 else "+"]
    start = [j for j in range(last + 1) if values[j] == 0][-1]
    down = goals_of(abs(loop.top), 0.0, 60)
    targets = np.array([*np.abs(values[start : last + 1]), *down])
    rows, end = one.way.states(targets, INCREMENT)
    v = path.named(rows[-len(down) :])
    x, torque = targets[-len(down) :], v["torque"]
    faces = both_faces.alike(one.beam, "twisting")
    torque = faces * torque + (one.held.rigidity / one.held.alone - faces) * states.rigidity(one.way) * x
    if end.code != increments.RANGE:
        return 0.0
    return math.copysign(_crossing(x, torque, v["N"]), loop.top)


def _crossing(x: Array, torque: Array, N: Array) -> float:
    """Return the twist at which a torque comes to zero on the way back while scales still press; 0 where none does."""
    i = int(np.argmax(torque <= 0))
    if i == 0 or x[i] == 0 or N[i] == 0:
        return 0.0
    share = torque[i - 1] / (torque[i - 1] - torque[i])
    return float(x[i - 1] + share * (x[i] - x[i - 1]))


def _senses(paths: dict[str, real.Path], values: list[float]) -> dict[str, Array]:
    """Return what holds for either sense of twist that the history goes to."""
    rows = []
    for one in paths.values():
        contact = one.way.contact
        rows.append(
            {
                "load_e": contact.phi,
                "load_end": max(*(v * one.sign for v in values), 0.0),
                "neighbour": max(0, contact.k),
                "first_contact": contact.words,
                "other_contact": "",
                "end": str(End.RANGE),
            }
        )
    return {"sense": np.array(list(paths)), **{role: np.array([row[role] for row in rows]) for role in rows[0]}}
