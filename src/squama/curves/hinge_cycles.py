"""Loading, unloading and reversal of hinged scales: how far a beam is followed, the states on the way, its loops.

The inclination is a function of the load, so each way is evaluated from the solved paths of the two senses
(:mod:`squama.model.history`).
"""

from __future__ import annotations

import functools
import itertools
import math
from typing import NamedTuple

import numpy as np

from squama.beam.design import Beam
from squama.curves import both_faces
from squama.curves.curve_figures import loop_figures, loop_table, table, used_senses
from squama.curves.hinge import LOCKS, SAME, Path, in_si, solve, straight, touching
from squama.curves.way import Analysis, Case, States, Way
from squama.errors import refuse
from squama.loads import LOADS
from squama.model import history
from squama.model.outcome import End
from squama.model.paths import FLOAT
from squama.people import at_most, per_pitch
from squama.types import Array

STRAIGHT = 4
"""A straight part has this many times fewer points than a part in contact."""
BRANCHES = ("straight", "loading", "unloading", "stick")
_ALONG = (
    "branch",
    "load",
    "rate",
    "theta",
    "torque",
    "scales",
    "tangent",
    "N",
    "f",
    "p",
    "s",
    "U_el",
    "W_fr",
    "leg",
)
_BEYOND = {
    End.LINE: "where the plates lock (kinematic lock, line contact)",
    End.STATIC: "where friction locks the scales as soon as they touch (static lock)",
    End.OFF_TIP: "where the contact runs off the end of the tip edge, and a cycle does not follow it",
    End.OFF_SIDE: "where the contact runs off the end of the side edge, and a cycle does not follow it",
    End.RELEASED: "where the contact opens beyond a fold, and a cycle does not follow it",
    End.RANGE: "where half a turn of scale or beam is reached",
    End.TOUCHING: "where the scales touch at rest",
    End.NONE: "the range in which contacts are looked for",
}


class Senses(NamedTuple):
    """Both senses of loading of a beam, by "+" and "-": solved paths, sides in contact, largest load angles allowed.

    ``faces``: on how many of the bar's faces scales do the same, where those of two do not act one at a time.
    """

    case: Case
    mu: float
    paths: dict[str, Path]
    sides: dict[str, history.Side]
    most: dict[str, float]
    faces: int = 1

    @property
    def bar(self) -> float:
        """Rigidity of the bar without contact over K_theta d of what touches."""
        return self.case.rigidity / (self.faces * self.case.stiffness * self.case.pitch)

    def place(self, sign: str, load: float) -> float:
        """Path parameter at a load angle (magnitude, beyond engagement)."""
        p = self.paths[sign]
        return float(p._replace(x_end=p.x_c).place(np.array([load]))[0])


def senses(beam: Beam, load: str, mu: float, law: str, margin: float, ideal: bool = True) -> Senses:
    """Solve a beam in both senses of loading.

    Of scales on both faces one acts at a time, or both do the same: where the other face's touch too, the path ends.
    """

    def path(end: float) -> Path:
        analysis = Analysis(beam, Way.of(load, [end]), np.asarray(mu), LOADS[load].law(law), margin, 3, None, ideal)
        return solve(analysis)[0][0]

    found = {"+": path(math.inf), "-": path(-math.inf)}
    seen = both_faces.sense(beam, load)
    if seen < 0:
        other = found["-"]
        first, told = min((other.load_e, "they come to rest on each other"), (other.load_end, other.other))
        closed = found["+"]
        if first < closed.load_end:
            words = f"{both_faces.WHOSE}{told}"
            closed = path(first)._replace(end=End.OTHER, other=words)
        found = {"+": closed, "-": closed}
    most = {sign: p.last if p.engaged and p.end in LOCKS else p.load_end for sign, p in found.items()}
    sides = {sign: p.side for sign, p in found.items() if p.engaged}
    return Senses(Case.of(beam, load), mu, found, sides, most, 1 + (seen > 0))


def walk(analysis: Analysis) -> States:
    """Return the states along a history, its loops, and what holds for each sense."""
    values = analysis.way.values
    both = senses(
        analysis.beam, analysis.way.load.name, float(analysis.mus), analysis.law, analysis.margin, analysis.ideal
    )
    check(values, both)
    by_dim: dict[tuple[str, ...], dict[str, Array]] = {
        ("point",): _along(both, values, analysis.points),
        ("loop",): _loops(both, values),
        ("sense",): table([_of_sense(both, sign) for sign in used_senses(values)]),
    }
    return States(by_dim, {"margin": analysis.margin})


def check(values: list[float], found: Senses) -> None:
    """Refuse the first twist beyond the largest that is allowed, or at which the scales do not slide back."""
    ways = set()
    for i, value in enumerate(values):
        sign = "-" if value < 0 else "+"
        if abs(value) > found.most[sign] * (1 + SAME):
            refuse("twist", per_pitch(value, 6), *_beyond(found, sign))
        if i and (values[i - 1], value) not in ways:
            ways.add((values[i - 1], value))
            _slides_back(values[i - 1], value, found)


def _beyond(found: Senses, sign: str) -> tuple[str, str]:
    """Say what ends the path, and what to give instead."""
    p, most = found.paths[sign], found.most[sign]
    minus = "-" if sign == "-" else ""
    here, end = (f"{minus}{per_pitch(angle, 6)}" for angle in (most, p.load_end))
    if p.end in LOCKS:
        why = f"the cut-off before the {p.end} at {end} (mu = {found.mu:g})"
    elif p.other:
        why = f"where another contact comes in that a cycle does not follow: {p.other}"
    else:
        why = _BEYOND[p.end]
    return f"is beyond {here}, {why}", f'give at most "{minus}{at_most(most, 5)}"'


def _slides_back(start: float, stop: float, found: Senses) -> None:
    sign = "-" if start < 0 else "+"
    p = found.paths[sign]
    if abs(start) <= p.load_e or (abs(stop) > abs(start) and start * stop > 0):
        return
    side, high = found.sides[sign], found.place(sign, abs(start))
    low = side.x0 if start * stop <= 0 or abs(stop) <= p.load_e else found.place(sign, abs(stop))
    x = history.held(side, low, high)
    if x is not None:
        at = float(p.row.point(x, p.law, FLOAT).load) * (-1 if sign == "-" else 1)
        refuse(
            "twist",
            per_pitch(stop, 6),
            f"coming from {per_pitch(start, 6)} the scales do not slide back beyond {per_pitch(at, 6)}, friction "
            f"holds them there (mu = {found.mu:g}, {p.law} law)",
            "turn round before",
        )


def _of_sense(senses: Senses, sign: str) -> dict[str, float | int | str]:
    """Return what holds for a sense, by role."""
    p, jam = senses.paths[sign], math.inf
    if (side := senses.sides.get(sign)) is not None and (x := history.jam(side, senses.bar)) is not None:
        # from there on a beam that is let go does not come back
        jam = float(side.row.point(x, side.law, FLOAT).load)
    return {
        "sense": sign,
        "load_e": p.load_e,
        "most": senses.most[sign],
        "jam": jam,
        "load_end": math.inf if p.row is None else p.load_end,
        "end": str(p.end),
        "other_contact": p.other,
        "neighbour": p.neighbour,
    }


class _Piece(NamedTuple):
    """Part of a way in one state: signed load angles of its ends; ``sign`` of the contact, "" where there is none."""

    start: float
    stop: float
    sign: str


def _pieces(senses: Senses, start: float, stop: float) -> list[_Piece]:
    """Split the way from one load angle to another where contacts engage or open."""
    cuts = [s * p.load_e for s, p in ((1, senses.paths["+"]), (-1, senses.paths["-"]))]
    inside = sorted((c for c in cuts if min(start, stop) < c < max(start, stop)), reverse=stop < start)
    ends = [start, *inside, stop]
    found = []
    for a, b in itertools.pairwise(ends):
        middle = (a + b) / 2
        sign = "+" if middle > 0 else "-"
        found.append(_Piece(a, b, sign if abs(middle) > senses.paths[sign].load_e else ""))
    return found


def _along(senses: Senses, values: list[float], points: int) -> dict[str, Array]:
    """Return every variable along the history, by role."""
    turns, parts = set(history.reversals(values)), []
    done = 0.0
    known: dict[_Piece, dict[str, Array]] = {}
    for i, (start, stop) in enumerate(itertools.pairwise(values)):
        fresh = i == 0 or i in turns
        for piece in _pieces(senses, start, stop):
            if piece not in known:
                known[piece] = _evaluate(senses, piece, points)
            part = {**known[piece], "branch": known[piece]["branch"].copy(), "W_fr": known[piece]["W_fr"] + done}
            done = float(part["W_fr"][-1])
            part["leg"] = np.full(part["load"].size, i + 1)
            if fresh and i and piece.sign and senses.mu:
                part["branch"][0] = "stick"
            parts.append(part if fresh else {name: v[1:] for name, v in part.items()})
            fresh = False
    return {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}


def _evaluate(senses: Senses, piece: _Piece, points: int) -> dict[str, Array]:
    """Every variable on a part of the way, ends included."""
    way = 1 if abs(piece.stop) > abs(piece.start) else -1
    sign = -1 if piece.sign == "-" else 1
    n = points if piece.sign else max(2, points // STRAIGHT)
    w = np.linspace(0.0, 1.0, n + 1)
    if piece.sign:
        side = senses.sides[piece.sign]
        a, b = (senses.place(piece.sign, abs(v)) for v in (piece.start, piece.stop))
        if senses.paths[piece.sign].end in LOCKS:
            # closer together where the curve steepens
            w = 1 - (1 - w) ** 2 if way > 0 else w**2
        x = a + (b - a) * w
        x[-1] = b
        v = touching(side.row, side.law, x, side.friction(way))
        load, work = sign * v["load"], history.work(side, a, b)(x)
        load[0], load[-1] = piece.start, piece.stop
    else:
        load, work = piece.start + (piece.stop - piece.start) * w, np.zeros(n + 1)
        v = straight(senses.case, load)
    out = in_si(senses.case, [v | {"load": load, "work": work}] * senses.faces, sign=sign)
    branch = BRANCHES[{0: 0, 1: 1, -1: 2}[way if piece.sign else 0]]
    return {"branch": np.full(n + 1, branch, "U9"), **{role: out[role] for role in _ALONG[1:-1]}}


def _loops(senses: Senses, values: list[float]) -> dict[str, Array]:
    """Return the figures of every closed loop, by role."""
    figures = functools.cache(lambda base, top: _figures(senses, base, top))
    return loop_table([figures(loop.base, loop.top) for loop in history.loops(values)])


def _figures(senses: Senses, base: float, top: float) -> list[float]:
    """Return the figures of a loop from its way there and back, two points for each part."""
    there, back = (
        [(piece, _evaluate(senses, piece, 1)) for piece in _pieces(senses, *ends)]
        for ends in ((base, top), (top, base))
    )
    highest, turned, lowest = there[-1][1], back[0][1], back[-1][1]
    residual, sign = 0.0, back[0][0].sign
    if sign:
        side = senses.sides[sign]
        x = history.residual(side, senses.bar, senses.place(sign, abs(top)))
        residual = 0.0 if x is None else math.copysign(float(side.row.point(x, side.law, FLOAT).load), top)
    energies = sum(float(part["W_fr"][-1]) for _, part in (*there, *back)), float(highest["U_el"][-1])
    torques = [float(torque) for torque in (highest["torque"][-1], turned["torque"][0], lowest["torque"][-1])]
    return loop_figures(base, top, senses.case.pitch, energies, torques, residual)
