"""Random beams on compliant joints through histories of twists: ends without a name, work, loops, senses, points.

Beams of the ranges of the joint's law, rigid and elastic, thick and thin.
"""

from __future__ import annotations

import collections
import itertools
import math
from typing import NamedTuple

import numpy as np

from squama.contacts import events, increments, path, states, touch
from squama.joints import law
from squama.joints.factor import MIRROR
from squama.model import elastic_plate as plate
from squama.types import Array

TRIALS, SIZE = 100, 100
BALANCE, SAME, FORCE = 2e-4, 1e-3, 1e-5
"""Work that is lost, over the largest energy; differences of torques over the largest; contact force, E d^2, of scales
so soft that rounding decides whether their contact is followed."""
POINTS = 24
CHATTER = 10
"""Number of snaps from which on a path sticks and slips: its jumps fall elsewhere with other points."""
SIDES = plate.SIDE_A, plate.SIDE_D
"""Edges by which scales may be hooked below the engagement, too."""


class Given(NamedTuple):
    """A beam, its joint and the sense that it is twisted in."""

    scale: path.Scale
    K: Array
    mu: float
    sense: int

    def path(self) -> path.Path:
        """Return what is followed."""
        return path.Path.of(self.scale, self.K, self.mu, sense=self.sense, most=0.5)

    def mirrored(self) -> Given:
        """Return the mirror image."""
        scale = self.scale._replace(alpha=-self.scale.alpha)
        return self._replace(scale=scale, K=self.K * np.outer(MIRROR, MIRROR), sense=-self.sense)


def drawn(r: np.random.Generator) -> Given:
    """Return a beam of which something touches."""
    while True:
        alpha, theta0 = np.radians([r.uniform(20, 75), r.uniform(5, 25)])
        beta, lam, zeta, nu = r.uniform(0.35, 1.2), r.uniform(0.3, 0.8), r.uniform(0.1, 0.5), r.uniform(0.25, 0.495)
        h = r.uniform(0.05, 0.45) * math.cos(alpha) * math.sin(theta0)
        width = r.uniform(1.05, 1.95) * 2 * beta * math.cos(alpha)
        K = law.stiffness(law.Shape(width, lam, zeta, beta, h, alpha, theta0, nu))
        D = 10 ** r.uniform(3, 5.5) * h**3 / (12 * (1 - 0.35**2)) if r.random() < 2 / 3 else math.inf
        thickness = h if r.random() < 3 / 4 else 0.0
        scale = path.Scale(r.uniform(1.5, 5), beta, lam, alpha, theta0, thickness, D, 0.35)
        sense = 1 if r.random() < 0.7 else -1
        mu = math.exp(r.uniform(math.log(0.05), 0)) if r.random() < 0.9 else 0.0
        given = Given(scale, K, mu, sense)
        if given.path().contact.first >= 0:
            return given


def history(r: np.random.Generator, e: float, far: float) -> Array:
    """Return the turns of a history to ``far``, engagement at e: there and back, partial loops, the same twice."""
    a, b, c = e + (far - e) * np.sort(r.uniform(0.05, 0.95, 3))
    kinds = (0, far, 0), (0, far, a, far, 0), (0, b, a, far, c, far, 0), (0, far, 0, far, 0)
    return np.array(kinds[r.integers(4)])


def along(turns: Array, points: int) -> Array:
    """Return the twists of a history, so many on each way."""
    ways = [np.linspace(a, b, points + 1)[1:] for a, b in itertools.pairwise(turns)]
    return np.concatenate([[0.0], *ways])


def wrong(given: Given, turns: Array, step: float) -> tuple[int, list[str]]:
    """Return how a beam's history ends, and what is wrong with it."""
    x, one = along(turns, POINTS), given.path()
    followed = one.follow(x, step)
    rows, end = followed.rows[0], followed.end()
    if end.code == increments.NO_EQUILIBRIUM:
        inside = np.nanmax(states.bent(given.scale, rows)) <= states.THIN
        return end.code, [f"stops at {end.phi:.6g}"] if inside and np.nanmax(rows[:, 2]) > FORCE else []
    found = []
    U = sum(states.energies(one, rows).values())
    most, T = np.nanmax(U), rows[:, 1]
    largest = np.nanmax(np.abs(T))
    lost = np.nanmax(np.abs(rows[:, 7] - U - rows[:, 6] - path.named(rows)["W_snap"])) / most
    snaps = sum(event.kind == increments.SNAP for event in events.events(followed))
    if lost > BALANCE * max(1, snaps / CHATTER):
        found.append(f"loses {lost:.1e} of its work")
    if end.code == increments.RANGE:
        first = followed.touches[0, :, 0]
        hooked = (
            (first[:, 1] > 0) & (first[:, 2] == touch.EE) & np.isin(first[:, 3], SIDES) & np.isin(first[:, 4], SIDES)
        )
        below = (x < one.contact.phi * (1 - 1e-9)) & ~hooked
        if abs(T[below] - states.bare(one.beams)[0, 0, 0] * x[below]).max() > SAME * largest:
            found.append("does not come back to the line without contact")
        finer = one.states(along(turns, 2 * POINTS), step)[0][::2, 1]
        if abs(finer - T).max() > SAME * largest and snaps < CHATTER:
            found.append(f"depends on its points by {abs(finer - T).max() / largest:.1e}")
        if turns.size == 5 and turns[2] == 0:
            loops = np.diff(rows[:: 2 * POINTS, 6])
            if abs(loops[1] - loops[0]) > SAME * loops[0] + BALANCE * most:
                found.append(f"dissipates {loops[0]:.6g}, then {loops[1]:.6g}")
    same = given.mirrored().path().states(x, step)[0]
    if not np.allclose(same[:, 1], T, rtol=0.0, atol=1e-9 * largest, equal_nan=True):
        found.append("is not its mirror image")
    return end.code, found


def trial(seed: int, size: int = SIZE) -> list[str]:
    """Try histories; the line for a failure names the trial and its number."""
    r, counts, failed = np.random.default_rng([13, seed]), collections.Counter[str](), []
    for i in range(size):
        given = drawn(r)
        e = given.path().contact.phi
        far = min(e * r.uniform(1.3, 3), e + 0.25, 0.5)
        turns = history(r, e, far)
        code, found = wrong(given, turns, min(2e-4, (far - e) / 200))
        counts[str(path.WORDS[code])] += 1
        failed += [f"trial {seed}, history {i} (mu {given.mu:.3g}, to {far:.4g}): {what}" for what in found]
    print(f"histories, {seed}: " + ", ".join(f"{n} {end}" for end, n in counts.most_common()), flush=True)
    return failed
