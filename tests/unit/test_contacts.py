"""The one contact solver: against brute force and barriers, its images, its events, its work, strains that are free."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import pytest

from squama.contacts import entry, events, follow, path
from squama.contacts.system import System
from squama.joints import law
from squama.joints.factor import MIRROR
from squama.types import Array
from tests.oracle.brute_force import Boxes
from tests.oracle.boxes import displaced


class Given(NamedTuple):
    """A beam, E = d = 1."""

    scale: path.Scale
    K: Array
    mu: float = 0.0

    @property
    def mirrored(self) -> Given:
        """Its mirror image."""
        return Given(self.scale._replace(alpha=-self.scale.alpha), self.K * np.outer(MIRROR, MIRROR), self.mu)

    def beams(self, free: tuple[int, ...] = (0, 0, 0, 0)) -> entry.Beams:
        """Return what is followed, with strains (bend, twist, lateral bend, stretch) free."""
        one = path.beams(path.Scale(*np.array([self.scale]).T), self.K[None], np.array([self.mu]), stretch="free")
        return one._replace(free=np.array([free], float))


def given(
    eta: float, beta: float, lam: float, alpha: float, theta0: float, h: float, *, mu: float = 0.0, E: float = math.inf,
    zeta: float = 0.3, nu: float = 0.45,
) -> Given:  # fmt: skip
    """Return a beam on the joint's law: scales of Young's modulus E, as wide as its bar is."""
    a, t = math.radians(alpha), math.radians(theta0)
    K = law.stiffness(law.Shape(1.5 * 2 * beta * math.cos(a), lam, zeta, beta, h, a, t, nu))
    return Given(path.Scale(eta, beta, lam, a, t, h, E * h**3 / (12 * (1 - 0.35**2)), 0.35), K, mu)


def followed(
    one: Given, corners: Array, free: tuple[int, ...] = (0, 0, 0, 0), *, n: int = 12, step: float = path.STEP
) -> path.Answers:
    """Follow a path from rest through corners (m, 2) in bend and twist, n stations on each leg."""
    ends = np.vstack([np.zeros(2), corners])
    places = np.concatenate([a + (b - a) * np.arange(1, n + 1)[:, None] / n for a, b in zip(ends, ends[1:], strict=False)])
    ways = np.cumsum(np.hypot(*np.diff(places, axis=0, prepend=np.zeros((1, 2))).T))
    return path.follow_all(one.beams(free), ways[None], corners=places[None], step=step, room=path.ROOM)


def loads(found: path.Answers) -> Array:
    """Return M, T, B, P of states (n, 4)."""
    v = path.named(found.rows[0])
    return np.column_stack([v[name] for name in ("M", "torque", "B", "P")])


def off(a: Array, b: Array) -> float:
    """Return the largest difference of moments and torques over the largest of them."""
    return float(np.abs(a - b)[:, :2].max() / np.abs(b[:, :2]).max())


def work(found: path.Answers) -> float:
    """Return the work that is lost, over the largest energy."""
    v = path.named(found.rows[0])
    return float(np.abs(v["W"] - v["energy"] - v["W_fr"] - v["W_snap"]).max() / v["energy"].max())


SOFT = given(3.0, 0.6, 0.5, 50, 20, 0.08, mu=0.25, E=2e4)
"""Bends and rubs; followed far enough TS hands over to TF."""
CORNER = np.array([[0.0, 0.2]])
TURNS = np.array([[0.05, 0.1], [0.05, 0.2], [-0.03, 0.12], [0.05, 0.2], [0.0, 0.0]])


@pytest.mark.parametrize("free", [(0, 0, 0, 0), (1, 0, 1, 1)])
@pytest.mark.parametrize("E", [math.inf, 2e4])
def test_image_in_the_mirror(E, free):
    """M and P the same, T and B the other sign."""
    one = given(3.0, 0.6, 0.5, 50, 20, 0.08, mu=0.25, E=E)
    corners = CORNER if free[0] else TURNS
    a, b = followed(one, corners, free), followed(one.mirrored, corners * [1, -1], free)
    assert a.end().code == b.end().code == follow.RANGE
    np.testing.assert_allclose(loads(a), loads(b) * [1, -1, -1, 1], rtol=0.0, atol=1e-9 * np.abs(loads(a)).max())


@pytest.mark.parametrize(("mu", "near"), [(0.25, 1e-5), (0.0, 1e-9)])
@pytest.mark.parametrize("E", [math.inf, 2e4])
def test_steps_do_not_matter(E, mu, near):
    one = given(3.0, 0.6, 0.5, 50, 20, 0.08, mu=mu, E=E)
    a, b = (loads(followed(one, CORNER, (0, 0, 0, 1), step=path.STEP / n)) for n in (1, 8))
    print("STEP", E, mu, off(a, b))
    assert off(a, b) < near


def system(one: Given, free: tuple[int, ...] = (0, 0, 0, 1), N: int = 1, grip: float = entry.GRIP) -> System:
    """Return N scales that repeat for ever, each alike."""
    b = one.beams(free)
    eta, beta, lam, sa, ca, st, ct, h, mu = b.shapes[0]
    X, Y = np.array([-sa * ct, st, ca * ct]), np.array([ca, 0.0, sa])
    shape = [eta, beta, h, mu, float(b.elastic[0]), entry.SLIDING]
    order, K = [0, 1, 2, 3, 4, 5, 7, 6, 9], np.zeros((10, 10))
    K[np.ix_(order, order)], K[8, 8] = b.K[0], b.K[0, 7, 7]
    every = ([shape], [[X, Y, np.cross(X, Y)]], [[0.0, lam, 0.0]], [K], b.plates[:1])
    reach = int(math.hypot(eta, 2 * beta))
    return System(*(np.array([*v] * N) for v in every), b.free[0], grip, reach, True)


def ring(S: System, corners: Array, n: int = 20, step: float = path.STEP, C: int = 12) -> tuple[Array, Array]:
    """Follow a system from rest through corners (m, 2); return rows and motions."""
    ends = np.vstack([np.zeros(2), corners])
    places = np.concatenate([a + (b - a) * np.arange(1, n + 1)[:, None] / n for a, b in zip(ends, ends[1:], strict=False)])
    ways, strains = np.cumsum(np.hypot(*np.diff(places, axis=0, prepend=np.zeros((1, 2))).T)), np.zeros((len(places), 4))
    strains[:, :2] = places
    N, m = len(S.shapes), len(ways)
    rows, motions, told, end = np.full((m, follow.LINE), np.nan), np.zeros((m, N, 6)), np.zeros((99, follow.EVENT)), np.zeros(4)
    entry.path(
        S, C, ways, strains, 0.0, step, rows, motions, np.zeros((m, N, 24)), np.zeros((m, C, follow.CONTACT)), told, end,
        np.zeros(0),
    )  # fmt: skip
    assert end[0] == follow.RANGE
    return rows, motions


def test_three_scales_in_a_ring_are_one():
    """A scale with its images, and three of them that are free to do otherwise."""
    for mu in (0.0, 0.25):
        one = SOFT._replace(mu=mu)
        (a, q), (b, p) = (ring(system(one, N=N), TURNS if mu else CORNER) for N in (1, 3))
        print("RING", np.abs(a[:, 5:9] - b[:, 5:9]).max(), np.abs(3*a[:, 5:9] - b[:, 5:9]).max(), a[-1, 5:9], b[-1, 5:9], np.abs(q - p).max())
