r"""Contact of thin, rigid scales on hinges, the beam bent and twisted at once (docs, theory: bending and twisting).

Scale 1 + k is scale 1 moved by g^k, where g is the screw exp(-(psi, 0, phi), (0, 0, 1 + psi y_n)) and y_n the height of
the line that keeps its length. Lengths in pitches, moments in K_theta; vectors are arrays (3, n). With c, s the cosine
and sine of theta, n_X = c a + s b and n_Z = c b - s a. Every contact of :data:`CONTACTS` has a gap

    F = (q + e n_X) . (c P + s Q) >= 0

over the length of its normal c P + s Q. Where it closes, with V the velocities at the contact and t the direction of
slip along the way (psi', phi'),

    theta' = -(g_psi psi' + g_phi phi') / g_theta        N = (theta - theta_0) / (g_theta - mu t . V_theta)
    M = N (mu t . V_psi - g_psi)                         T = N (mu t . V_phi - g_phi)
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from squama.types import Array

_SERIES = 0.01
"""Angle of the screw below which its coefficients are computed by series."""
_SAMPLES, _ROUNDS = 48, 8
NEAR = 1e-12
"""Tolerance of a contact's place on its edges, in pitches."""
NONE, LOCKED = "", "locked"
"""Words in place of a contact: nothing touches; beyond the lock of the plates."""


class Kind(NamedTuple):
    """A pair of features that can touch.

    ``tip``: at the tip of scale 1 (k_ZX > 0), else at the base of scale 2; ``face``: a corner on a face, else two
    edges; ``side``: -1 for the side D-C (y = -beta), 1 for A-B; ``rolling``: sign of the roll with which the contact
    occurs, 0 for either.
    """

    tip: bool
    face: bool
    side: int
    rolling: int


CONTACTS = {
    "TS": Kind(True, False, -1, 1),
    "CF": Kind(True, True, -1, 1),
    "BF": Kind(True, True, 1, -1),
    "TA": Kind(True, False, 1, -1),
    "DF": Kind(False, True, -1, 0),
    "AF": Kind(False, True, 1, 0),
    "SB": Kind(False, False, 1, 0),
    "SD": Kind(False, False, -1, 0),
}
"""Tip edge on the side edges D-C and A-B (TS, TA), corners B, C of the tip on the face (BF, CF), corners D, A of the
next scale's base under the face (DF, AF), side edges A-B, D-C on the next scale's base edge (SB, SD).
"""
WORDS = {
    "TS": "tip edge on side edge",
    "TA": "tip edge on the other side edge",
    "BF": "corner B on face",
    "CF": "corner C on face",
    "TF": "tip edge on face",
}
"""Contacts in words: feature of a scale on feature of the next scale."""


def dot(a: Array, b: Array) -> Array:
    """Return a . b."""
    return np.asarray(a[0] * b[0] + a[1] * b[1] + a[2] * b[2])


def cross(a: Array, b: Array) -> Array:
    """Return a x b."""
    x, y, z = a
    u, v, w = b
    return np.array([y * w - z * v, z * u - x * w, x * v - y * u])


def coefficients(q: Array) -> tuple[Array, Array, Array]:
    """Return sin(rho)/rho, (1 - cos(rho))/rho^2 and (rho - sin(rho))/rho^3 of a rotation by rho, from q = rho^2."""
    small = q < _SERIES**2
    rho = np.sqrt(np.where(small, 1.0, q))
    sin, cos = np.sin(rho), np.cos(rho)
    a = np.where(small, 1 - q / 6 * (1 - q / 20 * (1 - q / 42)), sin / rho)
    b = np.where(small, 0.5 - q / 24 * (1 - q / 30 * (1 - q / 56)), (1 - cos) / rho**2)
    c = np.where(small, 1 / 6 - q / 120 * (1 - q / 42 * (1 - q / 72)), (rho - sin) / rho**3)
    return a, b, c


def rotations(w: Array) -> Array:
    """Return the rotations (n, 3, 3) by rotation vectors (n, 3), rad (Rodrigues' formula)."""
    a, b, _ = (v[:, None, None] for v in coefficients((w * w).sum(axis=1)))
    axes = np.eye(3)
    once = np.cross(w[:, None], axes)
    # rows are the turned axes
    return np.asarray((axes + a * once + b * np.cross(w[:, None], once)).swapaxes(1, 2))


class Screw(NamedTuple):
    """The screw g from one scale to the next: w, v, sin(rho)/rho, (1 - cos(rho))/rho^2, (rho - sin(rho))/rho^3."""

    w: Array
    v: Array
    a: Array
    b: Array
    c: Array

    @classmethod
    def of(cls, psi: Array, phi: Array, y_n: Array) -> Screw:
        """Return the screw of a bend and a twist per pitch, rad."""
        zero = 0.0 * psi
        w, v = np.array([-psi, zero, -phi]), np.array([zero, zero, 1 + psi * y_n])
        return cls(w, v, *coefficients(psi * psi + phi * phi))

    def turned(self, x: Array) -> Array:
        """Return R x, the vectors x turned by the screw's rotation."""
        once = cross(self.w, x)
        return np.asarray(x + self.a * once + self.b * cross(self.w, once))

    @property
    def shift(self) -> Array:
        """Translation t of the screw."""
        once = cross(self.w, self.v)
        return np.asarray(self.v + self.b * once + self.c * cross(self.w, once))

    def rates(self, x: Array, dw: Array, dv: Array) -> Array:
        """Return the derivative of g(x) for changes dw and dv of w and v."""
        q, s = dot(self.w, self.w), dot(self.w, dw)
        small = q < _SERIES**2
        over = np.where(small, 1.0, q)
        cos = 1 - self.b * q
        da = np.where(small, -1 / 3 + q / 30 - q * q / 840, (cos - self.a) / over) * s
        db = np.where(small, -1 / 12 + q / 180 - q * q / 6720, (self.a - 2 * self.b) / over) * s
        dc = np.where(small, -1 / 60 + q / 1260 - q * q / 60480, (self.b - 3 * self.c) / over) * s
        wx, wv, dwx, dwv = cross(self.w, x), cross(self.w, self.v), cross(dw, x), cross(dw, self.v)
        turn = da * wx + self.a * dwx + db * cross(self.w, wx) + self.b * (cross(dw, wx) + cross(self.w, dwx))
        once = dwv + cross(self.w, dv)
        move = dv + db * wv + self.b * once + dc * cross(self.w, wv) + self.c * (cross(dw, wv) + cross(self.w, once))
        return np.asarray(turn + move)


class Pair(NamedTuple):
    """Two scales: numbers (n,), axes (3, n) of scale 1 without inclination, those of scale 2, both base midpoints."""

    eta: Array
    beta: Array
    theta0: Array
    a: Array
    b: Array
    y: Array
    Ra: Array
    Rb: Array
    Ry: Array
    base: Array
    there: Array

    @classmethod
    def of(cls, g: Screw, eta: Array, beta: Array, lam: Array, alpha: Array, theta0: Array) -> Pair:
        """Return the scales from lengths in pitches, angles in rad, and the screw from one to the next."""
        sin, cos, zero = np.sin(alpha), np.cos(alpha), 0.0 * eta
        a, b, y = np.array([-sin, zero, cos]), np.array([zero, zero + 1, zero]), np.array([cos, zero, sin])
        Ra, Rb, Ry = g.turned(a), g.turned(b), g.turned(y)
        return cls(eta, beta, theta0, a, b, y, Ra, Rb, Ry, lam * b, lam * Rb + g.shift)

    def take(self, i: Array) -> Pair:
        """Return the pairs with the indices ``i``."""
        return Pair._make(v[..., i] for v in self)

    def axes(self, theta: Array) -> tuple[Array, Array, Array, Array]:
        """Return n_X and n_Z of scale 1 and of scale 2 at an inclination (rad)."""
        c, s = np.cos(theta), np.sin(theta)
        return c * self.a + s * self.b, c * self.b - s * self.a, c * self.Ra + s * self.Rb, c * self.Rb - s * self.Ra


class Posed(NamedTuple):
    """Two scales (n,) with the screw between them; rotations about the width (closing) and the length (rolling)."""

    g: Screw
    d: Pair
    closing: Array
    rolling: Array

    @classmethod
    def of(cls, psi: Array, phi: Array, y_n: Array, shape: Sequence[Array]) -> Posed:
        """Return scales of a ``shape`` (eta, beta, lam, alpha, theta0) at bends and twists per pitch, rad."""
        g, sin, cos = Screw.of(psi, phi, y_n), np.sin(shape[3]), np.cos(shape[3])
        return cls(g, Pair.of(g, *shape), psi * cos + phi * sin, phi * cos - psi * sin)


def gap(kind: Kind, d: Pair) -> Array:
    """Return F (1 + u^2)^2 of a contact as a polynomial (5, n) in u = tan(theta / 2), lowest power first."""
    edge = kind.side * d.beta
    # the half width is that of scale 1 if its corner or side edge touches, else that of scale 2
    q = d.base - d.there + (edge * d.y if kind.tip == kind.face else -edge * d.Ry)
    if kind.face:
        P, Q = (d.Rb, -d.Ra) if kind.tip else (d.b, -d.a)
    elif kind.tip:
        P, Q = cross(d.Ra, d.y), cross(d.Rb, d.y)
    else:
        P, Q = cross(d.a, d.Ry), cross(d.b, d.Ry)
    c, s = dot(q, P), dot(q, Q)
    if not kind.tip:
        return np.array([c, 2 * s, 0 * c, 2 * s, -c])
    cc, cs, ss = (d.eta * x for x in (dot(d.a, P), dot(d.a, Q) + dot(d.b, P), dot(d.b, Q)))
    return np.array([c + cc, 2 * (s + cs), 4 * ss - 2 * cc, 2 * (s - cs), cc - c])


def at(F: Array, u: Array) -> Array:
    """Return the values (n,) of polynomials (5, n) at u."""
    return np.asarray((((F[4] * u + F[3]) * u + F[2]) * u + F[1]) * u + F[0])


def opening(F: Array, start: Array) -> Array:
    """Return the smallest u > start at which a gap, closed at start, opens; NaN if none is below 1 (90 deg)."""
    step = (1 - start) / _SAMPLES
    samples = at(F, start + step * np.arange(1, _SAMPLES + 1)[:, None])
    above = samples >= 0
    low = start + step * above.argmax(axis=0)
    high, found = low + step, np.asarray(above.any(axis=0))
    missed = np.flatnonzero(~found)
    if missed.size:
        # near a fold it opens and closes again between two samples
        top = start[missed] + step[missed] * (1 + samples[:, missed].argmax(axis=0))
        low[missed] = top - step[missed]
        high[missed] = _highest(F[:, missed], low[missed], np.minimum(top + step[missed], 1.0))
        found[missed] = at(F[:, missed], high[missed]) >= 0
    u = (low + high) / 2
    for _ in range(_ROUNDS):
        value = at(F, u)
        slope = ((4 * F[4] * u + 3 * F[3]) * u + 2 * F[2]) * u + F[1]
        low, high = np.where(value < 0, u, low), np.where(value < 0, high, u)
        near = u - value / np.where(slope == 0, 1.0, slope)
        # just behind engagement the root is next to the start, and Newton's steps from afar fall short of it
        aside = np.where(near < low, low + (high - low) / 64, (low + high) / 2)
        u = np.where((near >= low) & (near <= high), near, aside)
    return np.where(found, u, np.nan)


def _highest(F: Array, low: Array, high: Array) -> Array:
    """Return the place between ``low`` and ``high`` at which a gap is largest."""
    u = (low + high) / 2
    for _ in range(_ROUNDS):
        slope = ((4 * F[4] * u + 3 * F[3]) * u + 2 * F[2]) * u + F[1]
        bend = (12 * F[4] * u + 6 * F[3]) * u + 2 * F[2]
        low, high = np.where(slope > 0, u, low), np.where(slope > 0, high, u)
        near = u - slope / np.where(bend == 0, 1.0, bend)
        u = np.where((near >= low) & (near <= high), near, (low + high) / 2)
    return u


class Place(NamedTuple):
    """Place of a contact: whether it lies within its features, point of scale 2 before the screw, normal, V_theta.

    ``along`` and ``across`` are coordinates on a scale from the middle of its base: 0 to eta, -beta to beta.
    """

    along: Array
    across: Array
    inside: Array
    point: Array
    normal: Array
    V_theta: Array


def place(kind: Kind, d: Pair, theta: Array) -> Place:
    """Return the place of a contact at an inclination (rad)."""
    nX, nZ, RX, RZ = d.axes(theta)
    side, tip = kind.side * d.beta, d.base + d.eta * nX
    if kind.face:
        # a corner, seen from the base midpoint of the plate on whose face it is
        seen = tip + side * d.y - d.there if kind.tip else d.there + side * d.Ry - d.base
        along, across = (dot(seen, RX), dot(seen, d.Ry)) if kind.tip else (dot(seen, nX), dot(seen, d.y))
        normal = RZ if kind.tip else nZ
        point = d.base + (along * nX + across * d.y if kind.tip else side * d.y)
    else:
        start, other = (tip, d.there + side * d.Ry) if kind.tip else (d.there, d.base + side * d.y)
        u, v = (d.y, RX) if kind.tip else (d.Ry, nX)
        between, k = other - start, dot(u, v)
        across = (dot(between, u) - k * dot(between, v)) / (1 - k * k)
        along = across * k - dot(between, v)
        normal = cross(RX, d.y) if kind.tip else cross(nX, d.Ry)
        normal = normal / np.sqrt(dot(normal, normal))
        point = d.base + (along * nX + side * d.y if kind.tip else across * d.y)
    inside = (np.abs(across) <= d.beta + NEAR) & (along >= -NEAR) & (along <= d.eta + NEAR)
    V_theta = d.eta * nZ - along * RZ if kind.tip else along * nZ
    return Place(along, across, inside, point, normal, V_theta)


class Touching(NamedTuple):
    """Contacts (n,): inclination, name or "", whether locked; point, normal and V_theta as in :class:`Place`."""

    theta: Array
    contact: Array
    locked: Array
    point: Array
    normal: Array
    V_theta: Array


def touching(d: Pair, closing: Array, rolling: Array) -> Touching:
    """Return the contact with the largest inclination, for pairs with rotations ``closing`` and ``rolling``."""
    theta, n = d.theta0.copy(), d.theta0.size
    contact, locked = np.full(n, NONE, "U6"), np.zeros(n, bool)
    rest, (point, normal, V_theta) = np.tan(theta / 2), np.zeros((3, 3, n))
    normal[1] = V_theta[1] = 1.0
    for name, kind in CONTACTS.items():
        F = gap(kind, d)
        closed = at(F, rest) < 0
        if kind.tip:
            closed &= (rolling >= 0) == (kind.rolling > 0)
        i = np.flatnonzero(closed)
        if not i.size:
            continue
        one, turn = d.take(i), (closing[i], rolling[i])
        found = 2 * np.arctan(opening(F[:, i], rest[i]))
        here = place(kind, one, found)
        better = here.inside & (found > theta[i]) & counts(kind, found, one, *turn)
        # closed at rest and at all larger inclinations: not reachable
        locked[i] |= place(kind, one, one.theta0).inside & counts(kind, one.theta0, one, *turn)
        to = i[better]
        theta[to], contact[to] = found[better], name
        for whole, part in ((point, here.point), (normal, here.normal), (V_theta, here.V_theta)):
            whole[:, to] = part[:, better]
    return Touching(theta, contact, locked & (contact == NONE), point, normal, V_theta)


class Velocities(NamedTuple):
    """Relative velocities (3, n) of two scales at a contact per unit of theta, psi and phi; the normals."""

    theta: Array
    psi: Array
    phi: Array
    normal: Array

    @classmethod
    def of(cls, g: Screw, y_n: Array, here: Touching | Place) -> Velocities:
        """Return the velocities at the places of contacts."""
        zero = 0.0 * here.normal[0]
        one, none = zero + 1, np.array([zero, zero, zero])
        psi = -g.rates(here.point, np.array([-one, zero, zero]), np.array([zero, zero, zero + y_n]))
        return cls(here.V_theta, psi, -g.rates(here.point, np.array([zero, zero, -one]), none), here.normal)

    def sliding(self, lift: Array, mu: Array, toward: tuple[Array, Array]) -> Sliding:
        """Return the forces of sliding contacts, for a ``lift`` theta - theta_0 and a direction (psi', phi')."""
        g_theta, g_psi, g_phi = (dot(self.normal, v) for v in self[:3])
        rate = -(g_psi * toward[0] + g_phi * toward[1]) / g_theta
        V = self.psi * toward[0] + self.phi * toward[1] + self.theta * rate
        speed = np.sqrt(dot(V, V))
        t = V / np.where(speed > 0, speed, 1.0)
        drag = dot(t, self.theta)
        D = g_theta - mu * drag
        N = np.where(D > 0, lift / D, np.nan)
        M, T = (N * (mu * dot(t, v) - slope) for v, slope in ((self.psi, g_psi), (self.phi, g_phi)))
        return Sliding(N, M, T, np.where(drag == 0, np.inf, g_theta / drag), D, g_theta, rate, speed)

    def held(self, lift: Array, mu: Array, angles: Array) -> tuple[Array, Array, Array]:
        """Return moments M and T (m, n) on the border of what friction holds, for its angles (m,) and theta - theta_0.

        The third result (2, 2, n) are the edges of the cone of locked directions.
        """
        g_theta, g_psi, g_phi = (dot(self.normal, v) for v in self[:3])
        u = self.theta - g_theta * self.normal
        size = np.sqrt(dot(u, u))
        along = u / size
        aside = cross(self.normal, along)
        # friction per normal force at its limit, in all directions of the tangent plane
        drag = mu * size * np.cos(angles)[:, None]
        N = np.where(g_theta > drag, lift / (g_theta - drag), np.inf)
        moments = (
            N * (mu * (np.cos(angles)[:, None] * dot(along, v) + np.sin(angles)[:, None] * dot(aside, v)) - slope)
            for v, slope in ((self.psi, g_psi), (self.phi, g_phi))
        )
        # directions whose slip is at the angle to u at which D is zero
        turn = np.arccos(g_theta / (mu * size))
        slips = [np.cos(turn) * along + sign * np.sin(turn) * aside for sign in (-1, 1)]
        psi, phi = (v - self.theta * slope / g_theta for v, slope in ((self.psi, g_psi), (self.phi, g_phi)))
        area = dot(cross(psi, phi), self.normal)
        ways = np.array(
            [[dot(cross(t, phi), self.normal) / area, dot(cross(psi, t), self.normal) / area] for t in slips]
        )
        M, T = (np.where(np.isfinite(N), v, np.nan) for v in moments)
        return M, T, ways / np.sqrt((ways**2).sum(axis=1, keepdims=True))


class Sliding(NamedTuple):
    """Forces of sliding contacts, NaN where one is locked; D, g_theta, and rates of theta and of slip."""

    N: Array
    M: Array
    T: Array
    mu_lock: Array
    D: Array
    g_theta: Array
    theta_rate: Array
    slip_rate: Array


class State(NamedTuple):
    """States (n,) of bent and twisted beams, see :func:`squama.combined`."""

    theta: Array
    contact: Array
    normal: Array
    bending_moment: Array
    torque: Array
    mu_lock: Array


@np.errstate(all="ignore")
def state(posed: Posed, mu: Array, toward: tuple[Array, Array], y_n: Array) -> State:
    """Return the states of pairs, reached along the directions (psi', phi')."""
    here = touching(*posed[1:])
    slid = Velocities.of(posed.g, y_n, here).sliding(here.theta - posed.d.theta0, mu, toward)
    free, locked = here.contact == NONE, here.locked
    N, M, T = (np.where(free, np.where(locked, np.nan, 0.0), v) for v in slid[:3])
    contact = np.where(locked, LOCKED, here.contact)
    return State(np.where(locked, np.nan, here.theta), contact, N, M, T, np.where(free, np.nan, slid.mu_lock))


def counts(kind: Kind, theta: Array, d: Pair, closing: Array, rolling: Array) -> Array:
    """Return whether the contact is at the end of the overlap that bears, at an inclination."""
    over = overlap(kind, d, theta)
    return np.asarray(over <= 0 if not kind.tip else (over > 0) & (turning(theta, closing, rolling) > 0))


def overlap(kind: Kind, d: Pair, theta: Array) -> Array:
    """Return k_ZX, or -k_XZ for contacts on the face of scale 2: above 0 for a contact at the tip, below at the base.

    Where it is 0 an edge lies in the face, and the contacts at its two ends coincide.
    """
    nX, nZ, RX, RZ = d.axes(theta)
    return -dot(RZ, nX) if kind.tip == kind.face else dot(nZ, RX)


def turning(theta: Array, closing: Array, rolling: Array) -> Array:
    """Return k_YZ rho / rolling, 0 where the tip edge lies in the face of the next scale: the lock of the plates."""
    rho = np.sqrt(closing**2 + rolling**2)
    turn = (1 - np.cos(rho)) * closing / np.where(rho > 0, rho, 1.0)
    return np.asarray(np.sin(rho) * np.cos(theta) - turn * np.sin(theta))
