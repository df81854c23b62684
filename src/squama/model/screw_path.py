"""Straight ways in the plane of bend and twist, followed from contact to contact (docs, theory: bending and twisting).

The inclination depends on bend and twist alone, so a way is evaluated on a grid at once; a place where its contact is
lost, replaced or locked is solved for between two grid points. Each piece of a way with one contact is a row of
:mod:`squama.model.paths`: balance, work and cut-off are computed as for every other contact.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

import numpy as np

from squama.model import screw
from squama.model.bracket import zero
from squama.model.outcome import End
from squama.model.paths import Ops, Point
from squama.model.plates import Plates, first_touch
from squama.model.screw import CONTACTS, NONE, Posed, Sliding, Touching
from squama.types import Array

GRID = 64
"""Number of intervals of a way; a contact that comes and goes within one interval is missed."""
FINER = 8
"""Number of parts into which an interval of the grid is divided where the contact changes."""
STEP = 1e-9
"""Share of a way behind an event at which the next contact is determined."""
SAME = 1e-6
"""Largest difference of inclinations, rad, at which one contact may replace another."""
FLUSH = 1e-13
"""Roll over the magnitude of bend and twist, up to which the tip edge lies flush in the next face."""
SEEN, PARTED = 49, 1e-6
"""Number of samples of a piece for the search of other contacts, and distance from its ends, as a share of it."""
_PAIRS = {"TS": 14, "CF": 6, "BF": 7, "TA": 15, "DF": 0, "AF": 1, "SB": 20, "SD": 16}
"""Indices of the contacts among the feature pairs of :mod:`squama.model.plates`."""
_EDGES = ("left", "right", "low", "high")
_ENDS = {
    "friction": End.FRICTIONAL,
    "fold": End.KINEMATIC,
    "turn": End.LINE,
    "left": End.OFF_TIP,
    "right": End.OFF_TIP,
    "low": End.OFF_SIDE,
    "high": End.OFF_SIDE,
}
"""Ends by the margin that vanishes, if no other contact takes over."""


class Design(NamedTuple):
    """A design: lengths in pitches, angles in rad, friction, and height of the line that keeps its length."""

    eta: float
    beta: float
    lam: float
    alpha: float
    theta0: float
    mu: float
    y_n: float = 0.0


class Leg(NamedTuple):
    """A way of a design from (psi, phi) = ``start`` to ``start + step``, with parameter 0 <= x <= 1."""

    design: Design
    start: tuple[float, float]
    step: tuple[float, float]

    def loads(self, x: Array) -> tuple[Array, Array]:
        """Return bend and twist per pitch (rad) at x."""
        return self.start[0] + x * self.step[0], self.start[1] + x * self.step[1]

    @property
    def flush(self) -> bool:
        """Whether the way is on phi = psi tan(alpha), where the tip edge lies flush in the face of the next scale."""
        sin, cos = np.sin(self.design.alpha), np.cos(self.design.alpha)
        ways = (self.start, self.step)
        return all(abs(phi * cos - psi * sin) <= FLUSH * np.hypot(psi, phi) for psi, phi in ways)

    def posed(self, x: Array) -> Posed:
        """Return the scales at x."""
        psi, phi = self.loads(x)
        same = 1 + 0 * psi
        found = Posed.of(psi, phi, self.design.y_n * same, [v * same for v in self.design[:5]])
        return found._replace(rolling=0 * psi) if self.flush else found

    @np.errstate(all="ignore")
    def touching(self, x: Array) -> Touching:
        """Return the contacts at x."""
        return screw.touching(*self.posed(x)[1:])

    @np.errstate(all="ignore")
    def before(self, contact: str, x: Array) -> Array:
        """Return the gap of a contact at the inclination at rest, positive if it is open."""
        d = self.posed(x).d
        return screw.at(screw.gap(CONTACTS[contact], d), np.tan(d.theta0 / 2))


class Piece(NamedTuple):
    """A piece of a way with one contact ("" for none), from x0 to x1; ``end`` if the path ends there, else "".

    ``event`` is the margin that vanishes at x1, ``other`` the pair of plates in words that comes in there.
    """

    leg: Leg
    contact: str
    x0: float
    x1: float
    event: str = ""
    end: End | str = ""
    other: str = ""

    @property
    def theta0(self) -> float:
        """Inclination at rest, rad."""
        return self.leg.design.theta0

    def places(self, x: Array) -> tuple[Posed, Array, screw.Place, Array]:
        """Return the scales, inclination and place of the contact, and its gap at rest."""
        posed, kind = self.leg.posed(x), CONTACTS[self.contact]
        F = screw.gap(kind, posed.d)
        rest = np.tan(posed.d.theta0 / 2)
        shut = screw.at(F, rest)
        lifted = self._flush(posed)[2] if kind.tip and self.leg.flush else 2 * np.arctan(screw.opening(F, rest))
        theta = np.where(shut < 0, lifted, posed.d.theta0)
        return posed, theta, screw.place(kind, posed.d, theta), shut

    def _flush(self, posed: Posed) -> tuple[Array, Array, Array]:
        """Return both sides of arm = room sin(theta + rho/2), and theta, for a tip edge that lies in the next face."""
        s, rho, cos = self.leg.design, posed.closing, np.cos(self.leg.design.alpha)
        arm, room = s.eta * rho * np.cos(rho / 2), cos * (1 + rho * cos * s.y_n) - s.lam * rho
        return arm, room, np.arcsin(np.minimum(arm / room, 1.0)) - rho / 2

    def slid(self, x: Array, mu: float | None = None) -> tuple[Array, Sliding]:
        """Return inclination (rad) and forces at x."""
        posed, theta, here, _ = self.places(x)
        return theta, self._sliding(posed, theta, here, self.leg.design.mu if mu is None else mu)

    def _sliding(self, posed: Posed, theta: Array, here: screw.Place, mu: float) -> Sliding:
        s, same, (psi, phi) = self.leg.design, 1 + 0 * theta, self.leg.step
        V = screw.Velocities.of(posed.g, s.y_n * same, here)
        return V.sliding(theta - s.theta0, mu * same, (psi * same, phi * same))

    @np.errstate(all="ignore")
    def margins(self, x: Array) -> dict[str, Array]:
        """Return the margins at x by event, positive as long as the contact is followed; and the inclination."""
        s, kind = self.leg.design, CONTACTS[self.contact]
        posed, theta, here, shut = self.places(x)
        slid = self._sliding(posed, theta, here, s.mu)
        near = screw.NEAR
        found = {
            "theta": theta,
            "open": -shut,
            "base": screw.overlap(kind, posed.d, theta) * (1 if kind.tip else -1),
            "left": s.beta - here.across + near,
            "right": s.beta + here.across + near,
            "low": here.along + near,
            "high": s.eta - here.along + near,
            "friction": slid.D,
            "fold": slid.g_theta,
        }
        if kind.tip and not self.leg.flush:
            found["line"] = posed.rolling * kind.rolling
            found["turn"] = screw.turning(theta, posed.closing, posed.rolling)
        if kind.tip and self.leg.flush:
            arm, room, _ = self._flush(posed)
            found["fold"] = room - arm
        return found

    @property
    def both(self) -> tuple[Piece, ...]:
        """The piece itself; if the tip edge lies flush in the next face, also that of the contact at its other end."""
        if not (self.contact and self.leg.flush and CONTACTS[self.contact].tip):
            return (self,)
        others = [self._replace(contact=name) for name in ("BF", "TA")]
        middle = np.array([(self.x0 + self.x1) / 2])
        return self, max(others, key=lambda piece: min(float(piece.margins(middle)[n][0]) for n in _EDGES))

    @np.errstate(all="ignore")
    def states(self, x: Array) -> dict[str, Array]:
        """Return theta, N, M, T and mu_lock at x; where the tip edge lies flush, the mean of its two contacts."""
        if not self.contact:
            zero = 0.0 * x
            return {"theta": zero + self.theta0, "N": zero, "M": zero, "T": zero, "mu_lock": zero + np.nan}
        theta, slid = self.slid(x)
        found = np.mean([slid[:4], *(one.slid(x)[1][:4] for one in self.both[1:])], axis=0)
        return {"theta": theta, **dict(zip(Sliding._fields, found, strict=False))}

    def point(self, x: Array, law: str, ops: Ops) -> Point:  # noqa: ARG002
        """Return the contact as a row of :mod:`squama.model.paths`, with x as the load."""
        with np.errstate(all="ignore"):
            theta, slid = self.slid(x, 0.0)
            drag = slid.g_theta / slid.mu_lock
        none = np.nan * theta
        return Point(theta, x, slid.theta_rate, 1.0, slid.slip_rate, -slid.g_theta, drag, none, none, none, 1.0)


def follow(design: Design, points: Sequence[tuple[float, float]]) -> Iterator[Piece]:
    """Yield the pieces of a path from rest through points (psi, phi), up to its end or to another contact."""
    for piece in followed(design, points):
        seen = _alone(piece)
        yield seen
        if seen.other:
            return


def _alone(piece: Piece) -> Piece:
    """Cut a piece where another pair of plates comes in; pieces with a flush tip edge are not checked."""
    s, leg = piece.leg.design, piece.leg
    if leg.flush or piece.x1 - piece.x0 <= STEP:
        return piece
    shape = Plates(s.eta, s.beta, s.lam, float(np.sin(s.alpha)), float(np.cos(s.alpha)), 0.0, s.y_n)
    own = [_PAIRS[piece.contact]] if piece.contact else []

    def at(x: Array) -> tuple[Array, Array]:
        theta = piece.places(x)[1] if own else np.full(x.size, s.theta0)
        return theta, np.array(leg.loads(x))

    # at the ends of a piece corners and edges of its own meet
    near = PARTED * (piece.x1 - piece.x0)
    x = np.linspace(piece.x0 + near, piece.x1 - near, SEEN)
    with np.errstate(all="ignore"):
        hit = first_touch(shape, at, x, follows=len(own), mirrored=False, own=own)
    if hit is None:
        return piece
    return piece._replace(x1=hit.x, event="other", end=End.OTHER, other=f"{hit.pair} (k = {hit.k})")


def followed(design: Design, points: Sequence[tuple[float, float]]) -> Iterator[Piece]:
    """Yield the pieces of a path, considering only the contacts of :data:`squama.model.screw.CONTACTS`."""
    start, contact = (0.0, 0.0), NONE
    for point in points:
        leg = Leg(design, start, (point[0] - start[0], point[1] - start[1]))
        start = point
        for piece in _pieces(leg, contact):
            contact = piece.contact
            yield piece
            if piece.end:
                return


def _pieces(leg: Leg, contact: str) -> Iterator[Piece]:
    """Yield the pieces of one way, starting with a contact."""
    grid = np.linspace(0.0, 1.0, GRID + 1)
    found, x = leg.touching(grid), 0.0
    contact = str(leg.touching(np.array([STEP])).contact[0]) if contact else NONE
    while True:
        piece = _piece(leg, contact, x, grid, found)
        now = _next(piece)
        if isinstance(now, End):
            piece = piece._replace(end=now)
        yield piece
        if piece.end or not piece.event:
            return
        contact, x = str(now), piece.x1


def _piece(leg: Leg, contact: str, x: float, grid: Array, found: Touching) -> Piece:
    """Return the piece of one contact from x on to where it ends."""
    piece = Piece(leg, contact, x, 1.0)
    ahead = np.flatnonzero(grid > x + STEP)
    if contact == NONE:
        met = ahead[(found.contact[ahead] != NONE) | found.locked[ahead]]
        if not met.size:
            return piece
        x1, event = _engaged(leg, max(x, float(grid[met[0] - 1])), float(grid[met[0]]))
        return piece._replace(x1=x1, event=event)
    places = np.concatenate([[x + STEP], grid[ahead]])
    margins = piece.margins(places)
    theta = margins.pop("theta")
    over = np.concatenate([[False], found.theta[ahead] > theta[1:] + SAME])
    lost = over | np.any([~(v >= 0) for v in margins.values()], axis=0)
    if not lost.any():
        return piece
    i = int(lost.argmax())
    if i == 0:
        event = next(name for name, v in margins.items() if not v[0] >= 0)
        return piece._replace(x1=x, event=event)
    x1, event = _lost(piece, float(places[i - 1]), float(places[i]))
    return piece._replace(x1=x1, event=event)


def _lost(piece: Piece, low: float, high: float) -> tuple[float, str]:
    """Return place and event at which a contact is lost: by its own margin, or to one with a larger inclination."""

    def margin(name: str, x: Array) -> Array:
        found = piece.margins(x)
        return found["theta"] - piece.leg.touching(x).theta + SAME / 2 if name == "other" else found[name]

    fine = np.linspace(low, high, FINER + 1)
    margins, fold = piece.margins(fine), np.inf
    beyond = ~(margins["fold"] >= 0)
    if beyond.any():
        # beyond a fold there is no inclination; all other margins are finite just before it
        i = int(beyond.argmax())
        fold = _root(functools.partial(margin, "fold"), fine[i - 1 : i + 1], margins["fold"][i - 1 : i + 1])
        fine = np.linspace(low, fold - STEP * (high - low), FINER + 1)
        margins = piece.margins(fine)
    theta = margins.pop("theta")
    lost = {name: int((values < 0).argmax()) for name, values in margins.items() if (values < 0).any()}
    if not lost and np.isfinite(fold):
        return fold, "fold"
    if not lost:
        margins["other"] = theta - piece.leg.touching(fine).theta + SAME / 2
        lost = {"other": int((margins["other"] < 0).argmax())}
    roots = {}
    for name, i in lost.items():
        if i <= min(lost.values()):
            at = slice(i - 1, i + 1)
            roots[name] = _root(functools.partial(margin, name), fine[at], margins[name][at]) if i else low
    event = min(roots, key=lambda name: roots[name])
    return roots[event], event


def _engaged(leg: Leg, low: float, high: float) -> tuple[float, str]:
    """Return the place, and the event "closed", where between two grid points the first gap closes and plates touch."""
    fine = np.linspace(low, high, FINER + 1)
    here = leg.touching(fine)
    i = max(int(((here.contact != NONE) | here.locked).argmax()), 1)
    ends = fine[i - 1 : i + 1]
    # if no contact is found behind, any closing gap counts
    wanted = [str(here.contact[i])] if here.contact[i] else list(CONTACTS)
    gaps = {name: leg.before(name, ends) for name in wanted}
    closing = {name: gap for name, gap in gaps.items() if gap[0] > 0 > gap[1]}
    roots = [_root(functools.partial(leg.before, name), ends, gap) for name, gap in closing.items()]
    closed, far = min(roots, default=float(ends[1])), float(ends[1])
    # a gap may close outside the plates, which touch later
    while far - closed > STEP and not _touched(leg, closed + STEP):
        middle = (closed + far) / 2
        closed, far = (closed, middle) if _touched(leg, middle) else (middle, far)
    return closed, "closed"


def _touched(leg: Leg, x: float) -> bool:
    """Return whether plates touch or are locked at x."""
    here = leg.touching(np.array([min(1.0, x)]))
    return bool(here.contact[0] != NONE or here.locked[0])


def _root(value: Callable[[Array], Array], ends: Array, values: Array) -> float:
    """Return the place between two others where ``value`` changes its sign."""
    (a, b), (fa, fb) = map(float, ends), map(float, values)
    return float(zero(lambda x: float(value(np.array([x]))[0]), a, fa, b, fb, a, fa, True))


def _next(piece: Piece) -> str | End:
    """Return the contact behind a piece, or the end."""
    if not piece.event:
        return NONE
    if piece.event == "friction" and piece.x1 == piece.x0 and _theta(piece) - piece.theta0 <= SAME:
        return End.STATIC
    if piece.event in ("friction", "fold"):
        return _ENDS[piece.event]
    behind = piece.leg.touching(np.array([min(1.0, piece.x1 + STEP)]))
    contact, theta = str(behind.contact[0]), float(behind.theta[0])
    if not behind.locked[0] and abs(theta - _theta(piece)) <= SAME:
        return contact
    return _ENDS.get(piece.event, End.OTHER)


def _theta(piece: Piece) -> float:
    """Return the inclination at the end of a piece."""
    return float(piece.states(np.array([piece.x1]))["theta"][0])
