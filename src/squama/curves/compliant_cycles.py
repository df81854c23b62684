"""Loading, unloading and reversal with the compliant joint: the incremental problem, walked through a history.

Nothing is a function of the twist alone here: the scales' six motions depend on the way, so every leg is walked from
the state in which the last one ended. After a reversal the contact sticks while the friction turns round; increments
start there at :data:`LEAST` and grow, so that the steep part is resolved (docs, theory: cycles).
"""

from __future__ import annotations

import copy
import itertools
import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from squama.beam.design import Beam
from squama.curves import compliant
from squama.curves.path import Asked, States, loop_figures, loop_table, used_senses
from squama.errors import refuse
from squama.fe import condense
from squama.fe.balance import Trail
from squama.fe.contact import DHAT
from squama.fe.plate import MOTIONS
from squama.model import history
from squama.model.outcome import End
from squama.types import Array

INCREMENT = 5e-4
"""Largest increment of the twist, rad per pitch: work and dissipation agree to some 1e-4 with it."""
LEAST, GROWTH = 2e-6, 1.5
"""First increment after a reversal, rad per pitch, and how it grows."""
SLIP = 1e-7
"""Slip of friction's onset, pitches: well below that of the smallest increment."""
MOST = 100_000
"""Increments of a history at most."""
_ALONG = (
    *("load", "rate", "theta", "torque", "scales", "tangent", "N", "f", "p", "s", "U_el", "W_fr", "gap"),
    *MOTIONS,
)
_SLIDES = 1e-6
_FULL = 1e-9


class _Point(NamedTuple):
    """State at a point: leg, branch, and what the incremental model says there, E = 1 and d = 1."""

    leg: int
    branch: str
    phi: float
    theta: float
    v: Array
    T: float
    N: float
    f: float
    U_el: float
    W_fr: float
    W: float
    gap: float
    p: float
    s: float


class _Way(NamedTuple):
    """A history that was walked: its points; for each of its values the number of its point and the state there."""

    points: list[_Point]
    turns: list[int]
    states: list[condense.Walk]
    walk: condense.Walk


def walk(asked: Asked, increment: float | None = None) -> States:
    """Return the states along a history on the compliant joint, its loops, and what holds for each sense.

    To the points that are asked of each way some 15 come after each reversal. ``increment`` is the largest one, rad per
    pitch (:data:`INCREMENT`). A history on which the scales jump or lock is refused: the twist and what happens there.
    """
    increment, beam, values = INCREMENT if increment is None else increment, asked.beam, asked.path.values
    _check(values, increment)
    joint = compliant.stiffness(beam)
    way = _walked(beam, joint.K, float(asked.mus), values, asked.points, increment)
    d, E, last = beam.pitch, beam.substrate.youngs_modulus, way.points[-1]
    by_dim = {
        ("point",): _along(way, beam, joint),
        ("loop",): _loops(way, values, d, E, increment),
        ("sense",): _senses(beam, joint.K, way, values),
        (): {"energy_error": np.asarray((last.W - last.U_el - last.W_fr) / max(last.W_fr, last.U_el, 1e-300))},
    }
    attrs = {"increment": increment, "K_theta": joint.K_theta, "rigidity": joint.rigidity}
    return States(by_dim, attrs, compliant.warnings(beam, max(map(abs, values))))


def _check(values: list[float], increment: float) -> None:
    far = max(values, key=abs)
    if abs(far) >= math.pi:
        refuse("twist", f"{far:.6g} rad/pitch", "must be below half a turn per pitch")
    way = sum(abs(b - a) for a, b in itertools.pairwise(values))
    if way > MOST * increment:
        refuse(
            "twist",
            "",
            f"the compliant joint would have to be walked over {way:.4g} rad per pitch in increments of {increment:g}",
            f"give at most {MOST * increment:.4g}, by fewer twists or loops",
        )


def _walked(beam: Beam, K: Array, mu: float, values: list[float], points: int, increment: float) -> _Way:
    walk = condense.Walk(compliant.rest(beam), np.asarray(K, float), mu, condense.FREE, DHAT, SLIP)
    found = [_point(walk, 1, "straight")]
    turns, states = [0], [_copy(walk)]
    reversals = set(history.reversals(values))
    for i, (start, stop) in enumerate(itertools.pairwise(values)):
        stuck = i in reversals and walk.N > 0 and mu > 0
        for goal, most in _goals(start, stop, values[: i + 1], points, increment, turned=i in reversals):
            if not walk.run(goal, most).reached:
                if most < increment:
                    # right after a reversal a longer step may find the way
                    continue
                _refuse(walk, stop, most)
            outward = (stop - start) * goal > 0
            branch = "stick" if stuck else "loading" if outward else "unloading"
            found.append(_point(walk, i + 1, branch if walk.N > 0 else "straight"))
            # until its friction has come up again
            stuck = stuck and walk.load.strongest.f < mu * walk.N * (1 - _SLIDES)
        turns.append(len(found) - 1)
        states.append(_copy(walk))
    return _Way(found, turns, states, walk)


def _goals(
    start: float, stop: float, earlier: list[float], points: int, increment: float, *, turned: bool
) -> Iterator[tuple[float, float]]:
    """Yield the twists of a way whose state is kept, and the largest increment to each.

    Growing steps where the load has turned, then even ones; and all twists at which a loop may close.
    """
    way, here, step = math.copysign(1.0, stop - start), start, LEAST
    if turned:
        while step < increment and step < abs(stop - here) / 2:
            here += way * step
            yield here, step
            step *= GROWTH
    even = np.linspace(here, stop, points + 1)[1:-1]
    closing = [v for v in {0.0, *earlier} if (v - here) * way > _FULL and (stop - v) * way > _FULL]
    even = even[[not closing or min(abs(x - v) for v in closing) > _FULL for x in even]]
    for goal in sorted([*map(float, even), *closing, stop], reverse=way < 0):
        yield goal, increment


def _copy(walk: condense.Walk) -> condense.Walk:
    """Return a walk that goes on from the same state, and leaves this one where it is."""
    other = copy.copy(walk)
    other.trail = Trail(walk.trail.past)
    other.contacts = list(walk.contacts)
    return other


def _point(walk: condense.Walk, leg: int, branch: str) -> _Point:
    return _Point(leg, branch, v=walk.v, **{k: x for k, x in walk.endless().items() if k not in MOTIONS})


def _refuse(walk: condense.Walk, stop: float, most: float) -> None:
    """Say where the scales do not follow: they jump, or friction or geometry holds them."""
    ending = walk.ending(most)
    words = {
        condense.SNAP: "the contact slips off a corner or opens there and the scales jump (snap)",
        condense.STOPPED: "no equilibrium is found beyond, the scales lock or jam there (stopped)",
    }
    touch = f"; in contact: {walk.touch.pair} (k = {walk.touch.second})" if walk.touch else ""
    reason = f"the compliant joint comes to {walk.phi:.5g} rad/pitch, {words[ending]}{touch}"
    refuse("twist", f"{stop:.6g} rad/pitch", reason, "turn round before")


def _along(way: _Way, beam: Beam, joint: compliant.Stiffness) -> dict[str, Array]:
    """Return every variable along the history, by role."""
    columns = {name: np.array([getattr(p, name) for p in way.points]) for name in _Point._fields}
    phi = columns["phi"]
    inward = np.diff(np.abs(phi), prepend=0.0) < 0
    own = {"torque": columns["T"], **dict(zip(MOTIONS, columns["v"].T, strict=True))}
    own |= {role: columns[role] for role in ("theta", "N", "p", "s", "U_el", "W_fr", "gap")}
    v = compliant.in_si(beam, joint, phi, {**own, "f": columns["f"] * np.where(inward, -1, 1)})
    v["tangent"] = np.full(phi.size, np.nan)
    for a, b in itertools.pairwise(way.turns):
        # a leg begins at the last point of the one before
        slope = np.gradient(v["torque"][a : b + 1], v["rate"][a : b + 1])
        v["tangent"][a + 1 : b + 1] = slope[1:]
        if a == 0:
            v["tangent"][0] = slope[0]
    return {"branch": columns["branch"], "leg": columns["leg"], **{role: v[role] for role in _ALONG}}


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
        places = [j for j in range(loop.closed) if values[j] == other]
        turned = places[-1]
        began = [j for j in range(turned) if values[j] == first or j == 0][-1]
        last = range(way.turns[loop.closed - 1], way.turns[loop.closed] + 1)
        closed = next(i for i in last if way.points[i].phi == first)
        found.append(_Closed(loop, way.turns[began], way.turns[turned], closed))
    return found


def _loops(way: _Way, values: list[float], d: float, E: float, increment: float) -> dict[str, Array]:
    """Return the figures of every closed loop, by role."""
    rows: list[list[float]] = []
    done: list[tuple[_Closed, float]] = []
    for one in _closed(way, values):
        point = way.points
        dissipated = point[one.closed].W_fr - point[one.began].W_fr
        # what has closed inside is a loop of its own
        dissipated -= sum(w for c, w in done if one.began <= c.began and c.closed <= one.closed)
        done.append((one, dissipated))
        outward = abs(point[one.turned].phi) > abs(point[one.began].phi)
        top, base = (one.turned, one.closed) if outward else (one.began, one.turned)
        stuck = top
        while stuck + 1 < len(point) and point[stuck + 1].branch == "stick":
            stuck += 1
        rows.append(
            loop_figures(
                (one.loop.base, one.loop.top),
                d,
                dissipated=dissipated * (E * d**2),
                elastic=point[top].U_el * E * d**2,
                torques=(point[top].T * E * d**3, point[stuck].T * E * d**3, point[base].T * E * d**3),
                residual=_residual(way, top, increment),
            )
        )
    return loop_table(rows)


def _residual(way: _Way, top: int, increment: float) -> float:
    """Return the twist that is left when the beam is let go at a turning point: where the torque comes to zero."""
    at = way.states[way.turns.index(top)]
    walk, sign = _copy(at), math.copysign(1.0, at.phi)
    goals = _goals(at.phi, 0.0, [], max(3, int(abs(at.phi) / increment / 4)), increment, turned=True)
    before = walk.phi, walk.T
    for goal, most in goals:
        if not walk.run(goal, most).reached:
            if most < increment:
                continue
            # what jumps does not hold
            return 0.0
        if walk.N == 0:
            return 0.0
        if walk.T * sign <= 0:
            share = before[1] / (before[1] - walk.T)
            return float(before[0] + share * (walk.phi - before[0]))
        before = walk.phi, walk.T
    return 0.0


def _senses(beam: Beam, K: Array, way: _Way, values: list[float]) -> dict[str, Array]:
    """Return what holds for either sense of twist that the history goes to."""
    rest, used, rows = compliant.rest(beam), used_senses(values), []
    for s in used:
        sign = -1 if s == "-" else 1
        met = [c for c in way.walk.contacts if c.k and c.phi * sign > 0]
        rows.append(
            {
                "load_e": abs(condense.engagement(rest, K, met[0].phi)) if met else math.inf,
                "load_end": max(*(v * sign for v in values), 0.0),
                "end": str(End.RANGE),
                **compliant.contacts(met),
            }
        )
    return {"sense": np.array(used), **{role: np.array([row[role] for row in rows]) for role in rows[0]}}
