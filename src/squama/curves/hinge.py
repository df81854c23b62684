"""Beams with hinges: the path by the closed form, and the curve along it in SI units.

:func:`solve` turns a beam into a solved path, twisted or bent, for all coefficients of friction at once: the order of
contacts is geometry.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from squama.arrays import solution
from squama.curves import both_faces
from squama.curves.curve_figures import dissipation, figures
from squama.curves.way import Analysis, Case, Curve, States, Way, spaced
from squama.loads import neutral_height
from squama.model import energy, history, mechanics, screw
from squama.model.mechanics import Row
from squama.model.outcome import CODES, End
from squama.model.paths import ARRAY, FLOAT
from squama.model.plates import Plates, Touch
from squama.model.reach import SEARCH
from squama.model.screw_path import Design, Leg
from squama.model.tracks import at_loads, scalar
from squama.types import Array

LINEAR = 10
"""One in LINEAR points of a curve lies before engagement."""
SAME = 1e-12
"""Relative difference of load angles due to rounding."""
LOCKS = (End.FRICTIONAL, End.KINEMATIC)
"""Ends towards which a curve steepens."""
BENT_BY, TWISTED_BY = "BF", "TS"
"""Contacts of a bent and of a twisted beam, by their names in :mod:`squama.model.screw`."""
_NEAR = 1e-9
"""Relative difference below which the ends of two faces coincide."""
_NOT_MET = (np.nan, np.nan)


class Path(NamedTuple):
    """The solved path of one design, cut to the requested range.

    ``touch`` load angle and inclination of the other contact; ``leg`` the same way in the plane of bend and twist, if
    the moment that holds the other load is computed.
    """

    case: Case
    row: Any
    x0: float
    x_end: float
    x_c: float
    pole: float
    load_e: float
    load_end: float
    theta_end: float
    end: End
    neighbour: int
    other: str
    mu: float
    law: str
    touch: tuple[float, float] = _NOT_MET
    leg: Leg | None = None

    @property
    def engaged(self) -> bool:
        """Whether part of the path is in contact."""
        return self.row is not None and self.x_c > self.x0

    @classmethod
    def straight(
        cls, case: Case, far: float, mu: float, law: str, other: str = "", touch: tuple[float, float] = _NOT_MET
    ) -> Path:
        """Return the path of a design that does not engage, up to the load angle ``far``."""
        return cls(case, None, 0, 0, 0, 1, np.inf, far, case.theta0, End.NONE, 0, other, mu, law, touch)

    @property
    def side(self) -> history.Side:
        """The part in contact, for loading and unloading."""
        return history.Side(self.row, self.x0, self.x_c, self.pole, self.mu, self.law)

    @property
    def last(self) -> float:
        """Load angle of the last state of the curve: the cut-off before a lock, or the end."""
        if not self.engaged:
            return min(self.load_e, self.load_end)
        return float(self.row.point(self.x_c, self.law, FLOAT).load)

    def place(self, load: Array) -> Array:
        """Return the path parameters at load angles, all between the path's ends."""
        return invert(self.row, load, self.x0, self.x_end, self.law)

    def at(self, load: Array) -> dict[str, Array]:
        """Return the states at load angles, see :func:`states`; NaN beyond the end."""
        # a load that meets the end but for rounding belongs to the curve; at a lock the forces have no bounds
        reach = self.load_end * (1 if self.end in LOCKS else 1 + SAME)
        before = load <= (self.load_e if self.engaged else reach)
        contact = ~before & (load <= reach)
        x = self.place(load[contact]) if contact.any() else np.empty(0)
        order = np.concatenate([np.flatnonzero(before), np.flatnonzero(contact)])
        found = {}
        for role, v in states(self, load[before], x).items():
            found[role] = np.full(load.size, "" if v.dtype.kind == "U" else np.nan, v.dtype)
            found[role][order] = v
        return found | {"load": load}

    def curve(self, *, points: int, at: Array | None = None) -> Curve:
        """Return the curve at ``points`` from load 0 to the cut-off, or at load angles; and the single values."""
        v = states(self, *samples(self, points)) if at is None else self.at(at)
        end = (np.empty(0), np.array([self.x_c])) if self.engaged else (np.array([self.last]), np.empty(0))
        return Curve(in_si(self.case, [v]), _figures(self, in_si(self.case, [states(self, *end)])))


class Both(NamedTuple):
    """The solved path of a beam with scales on both faces: the paths of the faces, with the bar counted once.

    ``lead``: the face whose scales touch first; ``turns``: signs with which the faces see the held load. Variables of a
    scale are those of the leading face, and of the other face under its own names. The curve ends where one of the two
    ends.
    """

    lead: Path
    other: Path
    turns: tuple[int, int]

    @property
    def case(self) -> Case:
        """Data of the beam and the model."""
        return self.lead.case

    @property
    def load_e(self) -> float:
        """Load angle per pitch at engagement."""
        return self.lead.load_e

    def curve(self, *, points: int, at: Array | None = None) -> Curve:
        """Return the curve at the points of its leading face, or at load angles; NaN beyond its end."""
        lead, other = self.lead, self.other
        sooner = other.last < lead.last * (1 - _NEAR)
        cut = other.last if sooner else lead.last
        if at is None:
            at = spaced(cut, points, self.load_e) if sooner else states(lead, *samples(lead, points))["load"]
        along, last = (
            in_si(self.case, [face.at(x) for face in self[:2]], turns=self.turns) for x in (at, np.array([cut]))
        )
        found = _figures(lead, last)
        if sooner:
            end, words = other.load_end if math.isfinite(other.load_end) else cut, other.other
            found |= {"load_end": end, "rate_end": end / self.case.pitch, "theta_end": last["theta"].item()}
            found["end"] = str(End.OTHER if other.end is End.NONE else other.end)
            found["other_contact"] = both_faces.WHOSE * bool(words) + words
        return Curve(along, found | {"load_e_other": other.load_e})


def gather(analysis: Analysis, one_face: list[Path]) -> list[Path] | list[Both]:
    """Return the paths of a beam from those of its scaled face, for each coefficient of friction."""
    beam, load = analysis.beam, analysis.way.load
    if not (seen := both_faces.sense(beam, load.name)):
        return one_face
    assert beam.other is not None
    # the other face sees the load in its own sense
    mirror = analysis._replace(way=Way.of(load.name, [-v for v in analysis.way.values]))
    others = one_face if seen > 0 else solve(mirror)[0]
    across = 1, beam.other.seen[1 - load.axis]
    found = []
    for pair in zip(one_face, others, strict=True):
        lead = int(pair[1].load_e < pair[0].load_e)
        found.append(Both(pair[lead], pair[1 - lead], (across[lead], across[1 - lead])))
    return found


def solve(analysis: Analysis) -> tuple[list[Path], States]:
    """Solve a beam in one sense up to the load angle of its way, for each coefficient of friction."""
    beam, way, law, mus = analysis.beam, analysis.way, analysis.law, np.atleast_1d(analysis.mus)
    kind, case, to = way.load, Case.of(beam, way.load.name, way.sense), abs(way.values[-1])
    margin = analysis.margin
    more = States({}, {"margin": margin})
    ratios = beam.ratios | {"lam": kind.height(beam.lam, beam.neutral), "thickness": thickness(analysis)}
    if case.mirrored and not kind.sided:
        plates = Plates(beam.eta, beam.beta, ratios["lam"], math.sin(beam.scale.alpha), math.cos(beam.scale.alpha))
        hit = solution.touch(plates, case.theta0, SEARCH, None, 0, mirrored=True, bent=True)
        words = solution.other_words(hit, 0, mirrored=False)
        paths = [_open(case, hit, words, to, float(m), law) for m in mus]
    else:
        shapes = {name: np.full(mus.size, value) for name, value in ratios.items()}
        sol = solution.solve({**shapes, "mu": mus}, load=kind.name, law=law, sense=way.sense)
        sol, touches = solution.with_touches(sol, [*shapes.values()], load=kind.name, sense=way.sense, alike=True)
        paths = [path(case, sol.one(i), touches[i], float(m), law, margin, to) for i, m in enumerate(mus)]
    if kind.sided and (law != "edge" or ratios["thickness"]):
        return paths, more
    # twisting has the axis in the bar's middle; the other sense is the mirror image
    y_n, sides = (0.0, (0.0, 1.0)) if kind.sided else (neutral_height(beam.neutral, beam.lam), (1.0, 0.0))
    shape = beam.ratios | {"alpha": -beam.scale.alpha if case.mirrored else beam.scale.alpha}
    legs = [Leg(Design(**shape, mu=float(m), y_n=y_n), (0.0, 0.0), sides) for m in mus]
    return [path._replace(leg=leg) for path, leg in zip(paths, legs, strict=True)], more


def path(
    case: Case, sol: solution.Solution, touch: Touch | None, mu: float, law: str, margin: float, to: float = math.inf
) -> Path:
    """Return the path of a single solved design, cut at ``to`` (load angle per pitch), with its cut-off."""
    found = sol.found
    end = CODES[int(found.code[0])]
    load_e, load_end, theta_end = float(found.load_e[0]), float(found.load_end[0]), float(found.theta_end[0])
    other = solution.other_words(touch, int(sol.crossing[0]), mirrored=case.mirrored)
    if end is End.TOUCHING:
        return Path.straight(case, 0.0, mu, law)._replace(end=end, load_e=0.0)
    if end is End.NONE:
        return _open(case, touch, other, to, mu, law)
    t = sol.tracks[0][1]
    row = scalar(t.row)
    x0, x_end = float(t.x0[0]), float(t.x_end[0])
    # the pole of the friction force belongs to the path, wherever the requested range ends
    pole = float(energy.pole(t.row, t.x_end, np.array([mu]), law, t.x0)[0]) if x_end > x0 else x0 + 1
    if to < load_end:
        end, other, load_end = End.RANGE, "", to
        x_end = float(invert(row, np.array([to]), x0, x_end, law)[0]) if to > load_e else x0
        theta_end = float(row.theta(x_end))
    locks = np.array([end in LOCKS])
    x_c = float(energy.cutoff(t.row, t.x0, np.array([x_end]), locks, margin)[0])
    met = (load_end, theta_end) if other else _NOT_MET
    k = int(found.neighbour[0])
    return Path(case, row, x0, x_end, x_c, pole, load_e, load_end, theta_end, end, k, other, mu, law, met)


def thickness(analysis: Analysis) -> float:
    """Return the thickness of scales in pitches where hinges include it: in twisting, with the edge law; else 0."""
    thin = analysis.ideal or analysis.law == "plate" or not analysis.way.load.sided
    return 0.0 if thin else analysis.beam.scale.thickness / analysis.beam.pitch


def _open(case: Case, touch: Touch | None, other: str, to: float, mu: float, law: str) -> Path:
    """Return the straight path of scales that do not engage, up to the other contact or the end of the search."""
    stop = min(touch.phi if touch else SEARCH, to)
    return Path.straight(case, stop, mu, law, other, (touch.phi, case.theta0) if touch else _NOT_MET)


def invert(row: Row, load: Array, x0: float, x_end: float, law: str) -> Array:
    """Return the path parameters at load angles (n,), all between the path's ends."""
    grid = np.linspace(x0, x_end, 257)
    with np.errstate(all="ignore"):
        seen = row.point(grid, law, ARRAY).load
    seen = np.maximum.accumulate(np.where(np.isfinite(seen), seen, -np.inf))
    i = np.clip(np.searchsorted(seen, load, side="left") - 1, 0, 255)

    inside = (load > seen[0]) & (load < seen[-1])
    x = np.where(load <= seen[0], x0, x_end)
    if inside.any():
        j = i[inside]
        x[inside] = at_loads(row, load[inside], (grid[j], grid[j + 1]), (seen[j], seen[j + 1]))
    return x


def samples(p: Path, points: int) -> tuple[Array, Array]:
    """Return load angles before engagement, and path parameters in contact; together ``points``."""
    if not p.engaged:
        return np.linspace(0.0, min(p.load_e, p.load_end), points), np.empty(0)
    first = before(points)
    w = np.linspace(0.0, 1.0, points - first)
    if p.end in LOCKS:
        # closer together where the curve steepens
        w = 1 - (1 - w) ** 2
    return np.linspace(0.0, p.load_e, first, endpoint=False), p.x0 + (p.x_c - p.x0) * w


def before(points: int) -> int:
    """Return the number of a curve's points before engagement."""
    return max(1, points // LINEAR)


def touching(row: Row, law: str, x: Array, friction: float) -> dict[str, Array]:
    """Return the contact at path parameters (n,) in units of K_theta and the pitch, by role.

    ``friction`` is the friction per normal force, negative while the contact slides back.
    """
    with np.errstate(all="ignore"):
        # a complex step gives the tangent without cancellation
        pt = row.point(x + 1e-30j, law, ARRAY)
        forces = mechanics.forces(pt, row.theta0, friction)
        # where the contact opens the lift is zero but for rounding
        N = np.maximum(forces.N.real, 0.0)
        found = {
            "theta": pt.theta.real,
            "load": pt.load.real,
            "scales": forces.torque.real,
            "tangent": forces.torque.imag / pt.load.imag,
            "N": N,
            "f": friction * N,
            "p": pt.p,
            "s": pt.s,
            "mu_lock": mechanics.mu_lock(pt),
        }
    real = {role: np.real(v) for role, v in found.items()}
    return {role: v if np.shape(v) == x.shape else np.full(x.shape, v) for role, v in real.items()}


def straight(case: Case, load: Array) -> dict[str, Array]:
    """Return the states at load angles (n,) without contact, in units of K_theta and the pitch, by role."""
    zero, none = np.zeros(load.size), np.full(load.size, np.nan)
    found = {"theta": np.full(load.size, case.theta0), "load": load, **dict.fromkeys(("scales", "tangent"), zero)}
    return {**found, **dict.fromkeys(("N", "f"), zero), **dict.fromkeys(("p", "s", "mu_lock"), none)}


def in_si(
    case: Case, faces: Sequence[Mapping[str, Array]], *, sign: int = 1, turns: Sequence[int] = (1, 1)
) -> dict[str, Array]:
    """Return the beam's states in SI units from those of each face's scales: sums, with the bar counted once.

    ``sign``: sign of the load; ``turns``: signs with which the faces see the held load.
    """
    d, K, own = case.pitch, case.stiffness, faces[0]
    rate = own["load"] / d
    added, tangent, work = (np.sum([face[role] for face in faces], axis=0) for role in ("scales", "tangent", "work"))
    scales, W_fr = sign * K * added, work * K / d
    joints = np.sum([K / d * (face["theta"] - case.theta0) ** 2 for face in faces], axis=0)
    U_el = (case.rigidity * rate**2 + joints) / 2
    found = {
        "rate": rate,
        "load": own["load"],
        "torque": case.rigidity * rate + scales,
        "scales": scales,
        "tangent": case.rigidity + K * d * tangent,
        **_of_scale(case, own),
        "U_el": U_el,
        "W_fr": W_fr,
        "RED": dissipation(U_el, W_fr),
    }
    for name in ("T", "M"):
        # torque or moment that holds a beam of oblique scales
        if name in own:
            found[name] = np.sum([turn * (K * face[name]) for turn, face in zip(turns, faces, strict=False)], axis=0)
    for other in faces[1:]:
        found |= both_faces.of_other(_of_scale(case, other))
    return found


def _of_scale(case: Case, v: Mapping[str, Array]) -> dict[str, Array]:
    """Return the variables of a scale in SI units."""
    d, K = case.pitch, case.stiffness
    contact = {"contact": v["contact"]} if "contact" in v else {}
    return {
        "p": v["p"] * d,
        "s": v["s"] * d,
        "theta": v["theta"],
        "N": v["N"] * K / d,
        "f": v["f"] * K / d,
        "f0": v["f"] * case.eta,
        "mu_lock": v["mu_lock"],
        **contact,
    }


def states(p: Path, load: Array, x: Array) -> dict[str, Array]:
    """Return the states at load angles before engagement, followed by path parameters in contact, by role.

    As :func:`straight` and :func:`touching`, with the work of friction and the moment that holds the other load.
    """
    v, work = straight(p.case, load), np.zeros(load.size + x.size)
    if x.size:
        contact = touching(p.row, p.law, x, p.mu)
        v = {role: np.concatenate([one, contact[role]]) for role, one in v.items()}
        work[load.size :] = energy.work(p.row, p.x0, max(p.x_c, float(x.max())), p.pole, p.mu, p.law)(x)
    return v | {"work": work} | ({} if p.leg is None else _held(p, p.leg, v, load.size))


def _held(p: Path, leg: Leg, v: dict[str, Array], engaged: int) -> dict[str, Array]:
    """Return the moment M that holds a twisted beam straight, or the torque T that holds a bent one, in K_theta.

    For a bent beam also its contact. Neighbour k is the next neighbour of a beam with a pitch k times as long.
    """
    bends, k = leg.step[1] == 0, max(1, p.neighbour)
    kind = BENT_BY if bends else TWISTED_BY
    held, contact = np.zeros(v["load"].size), np.full(v["load"].size, kind)
    contact[:engaged] = ""
    if not leg.flush:
        s, same = leg.design, np.ones(held.size - engaged)
        s = s._replace(eta=s.eta / k, beta=s.beta / k, lam=s.lam / k, y_n=s.y_n / k)
        posed = leg._replace(design=s).posed(k * v["load"][engaged:])
        here = screw.place(screw.CONTACTS[kind], posed.d, v["theta"][engaged:])
        velocities = screw.Velocities.of(posed.g, s.y_n * same, here)
        toward = leg.step[0] * same, leg.step[1] * same
        sliding = velocities.sliding(v["theta"][engaged:] - s.theta0, s.mu * same, toward)
        held[engaged:] = k * (sliding.T if bends else sliding.M)
    return {"T": held, "contact": contact} if bends else {"M": held}


def _figures(p: Path, end: Mapping[str, Array]) -> dict[str, float | int | str]:
    """Return the single values of a curve from its variables at its end."""
    last, mu_static = {role: v[-1].item() for role, v in end.items()}, np.nan
    if p.row is not None:
        pt = p.row.point(p.x0, p.law, FLOAT)
        mu_static = mechanics.mu_lock(pt) if pt.M_f > 0 else np.inf
    return {
        **({"T_c": last["T"]} if "T" in last else {}),
        **figures(p.case, last, p.load_e, np.inf if p.end is End.NONE else p.load_end, p.theta_end),
        "mu_static": mu_static,
        "end": str(p.end),
        "neighbour": p.neighbour,
        "other_contact": p.other,
        "load_touch": p.touch[0],
        "theta_touch": p.touch[1],
    }
