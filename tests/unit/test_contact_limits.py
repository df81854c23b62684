"""Where the model of scales in contact ends: side faces, motions beyond the linear joint; hooked edges are in it."""

from __future__ import annotations

import itertools
import math
from typing import NamedTuple

import numpy as np
import pytest

from oracle.boxes import displaced
from squama.contacts import increments, path
from squama.contacts.row import track
from squama.contacts.ties import LOOSE
from squama.joints import law
from squama.model.outcome import End
from squama.model.screw import rotations
from squama.types import Array


class Case(NamedTuple):
    """A random beam, by the numbers of the law's shape, of its scale and its friction; E = d = 1."""

    shape: law.Shape
    scale: path.Scale
    mu: float
    sense: int = 1

    def path(self) -> path.Path:
        """Return what is followed."""
        return path.Path.of(self.scale, law.stiffness(self.shape), self.mu, sense=self.sense, most=0.5)


JAMS = Case(
    law.Shape(0.661239, 0.747916, 0.278649, 0.458581, 0.0716685, 0.941275, 0.367199, 0.250336),
    path.Scale(2.80394, 0.458581, 0.747916, 0.941275, 0.367199, 0.0716685, math.inf, 0.35),
    0.59432,
)
"""Rigid scales that fall past each other; untwisted, their side edges stick and lift them."""
SIDES = Case(
    law.Shape(0.691741, 0.72446, 0.253218, 0.450195, 0.0142297, 1.08809, 0.161032, 0.451276),
    path.Scale(4.37936, 0.450195, 0.72446, 1.08809, 0.161032, 0.0, 0.00751648, 0.35),
    0.46284,
)
"""Thin elastic scales that fall past each other; untwisted, side edges press them apart sideways."""
HOOKED = Case(
    law.Shape(0.992861, 0.757561, 0.133242, 0.365926, 0.0532855, 0.641141, 0.26498, 0.480026),
    path.Scale(3.87525, 0.365926, 0.757561, 0.641141, 0.26498, 0.0532855, math.inf, 0.35),
    0.77743,
)
"""Rigid scales that fall past each other and stay hooked down to no twist."""
LEAVES = Case(
    law.Shape(2.52394, 0.71986, 0.141299, 0.796738, 0.0283402, 0.39302, 0.124316, 0.463764),
    path.Scale(2.74042, 0.796738, 0.71986, 0.39302, 0.124316, 0.0283402, 0.00764667, 0.35),
    0.178998,
    -1,
)
"""A corner that leaves a face while the edge beside it comes in."""


def history(*turns: float, points: int = 60) -> Array:
    """Return twists of a history, so many on each way."""
    ways = [np.linspace(a, b, points + 1)[1:] for a, b in itertools.pairwise(turns)]
    return np.concatenate([[0.0], *ways])


def moves(rows: Array) -> Array:
    """Return the motions of the scales (n, 6) in states."""
    at = path.COLUMNS.index("u_X")
    return rows[:, at : at + 6]


def test_a_path_ends_where_a_scale_leaves_its_linear_joint() -> None:
    x = history(0.0, 0.15369, 0.09601, 0.15369, 0.0)
    ends = []
    for step in (2e-4, 1e-4):
        rows, end = JAMS.path().states(x, step)
        assert end.code == increments.TOO_FAR
        assert end.word is End.JOINT
        known = rows[np.isfinite(rows[:, 1])]
        assert np.linalg.norm(moves(known).reshape(-1, 2, 3), axis=2).max() < 1
        ends.append(end.phi)
    # located: the steps of friction alone differ
    assert ends[1] == pytest.approx(ends[0], abs=1e-3)
    first = len(known)
    on_the_way = history(x[first - 1], 2 * x[first] - x[first - 1], points=40)[1:]
    rows, _ = JAMS.path().states(np.append(x[:first], on_the_way), 2e-4)
    last = moves(rows[np.isfinite(rows[:, 1])][-1:]).reshape(2, 3)
    assert 0.9 < np.linalg.norm(last, axis=1).max() < 1


def test_a_path_ends_where_side_faces_bear() -> None:
    rows, end = SIDES.path().states(history(0.0, 0.04344, 0.02476, 0.04344, 0.0), 2e-4)
    assert end.word is End.SIDE
    known = rows[np.isfinite(rows[:, 1])][-1:]
    # without friction the force is along the normal: here within its cone about the plane of the plate
    F = known[0, [path.COLUMNS.index(name) for name in ("F_x", "F_y", "F_z")]]
    up = rotations(moves(known)[:, 3:])[0][:, 2]
    assert abs(F @ up) < 0.1 * np.linalg.norm(F)


@pytest.mark.parametrize("case", [HOOKED, JAMS], ids=["hooked", "jams"])
def test_rigid_scales_that_fell_past_each_other_touch_and_do_not_overlap(case: Case) -> None:
    s, turns = case.scale, (0.0, 0.12816, 0.08898, 0.12816, 0.002) if case is HOOKED else (0.0, 0.15369, 0.09)
    x = history(*turns, points=15)
    rows, _ = case.path().states(x, 2e-4)
    shape, pressed = (s.eta, s.beta, s.lam, s.alpha, s.h), 0
    for phi, row in zip(x, rows, strict=True):
        if np.isfinite(row[1]) and row[path.COLUMNS.index("N")] > 0:
            gap = min(displaced(shape, s.theta0, phi, k, moves(row[None])[0], 0.0) for k in (1, 2, 3))
            assert gap == pytest.approx(0.0, abs=1e-8)
            pressed += 1
    assert pressed > 15
    if case is HOOKED:
        assert x[-1] < case.path().contact.phi / 10
        assert rows[-1, path.COLUMNS.index("N")] > 0


@pytest.mark.parametrize("far", [0.365, 0.38, 0.42])
def test_a_corner_leaves_a_face_together_with_its_edge(far: float) -> None:
    """Where both come at once depends on the increments: of 66 turns at 0.365 to 0.43 it is so for these."""
    x = np.concatenate([[0.0, 0.2, 0.3, 0.36, far], np.linspace(far, 0.3, 30)[1:]])
    rows, end = LEAVES.path().states(x, 2e-4)
    assert end.word is End.RANGE
    v = path.named(rows)
    assert np.nanmax(np.abs(v["energy"] + v["W_fr"] + v["W_snap"] - v["W"])) < 2e-4 * np.nanmax(v["energy"])


def test_rigid_scales_of_a_row_come_in_all_at_once():
    """Friction of nine sliding contacts throws Newton's method to and fro; every cell carries the same torque."""
    alpha, theta0, beta, lam = 1.2919262094045036, 0.20864402252207986, 0.6477966749412424, 0.722206552324585
    h, nu = 0.004431012012950177, 0.2555280853088236
    K = law.stiffness(law.Shape(0.41659717896644327, lam, 0.4535981205263303, beta, h, alpha, theta0, nu))
    scale = path.Scale(4.075352699043692, beta, lam, alpha, theta0, h, math.inf, 0.35)
    way = path.Path.at_rest(scale, K, 0.17437169359070914, free=(1, 1, 1, 1), aside=2.846946003127106)
    found = track(way, 10, np.linspace(0.0, 0.25, 25)[1:], ends=LOOSE)
    assert found.end.code == increments.RANGE
    assert found.engaged == pytest.approx(0.014059, abs=1e-5)
    np.testing.assert_allclose(found.cells[-1, :, 5], found.cells[-1, 0, 5], rtol=1e-9)
    # the last scale has no next one
    for name in ("first", "second"):
        features = path.named(found.rows)[name][-1]
        assert (features[:-1] >= 0).all()
        assert features[-1] == -1


def test_a_row_creeps_to_rest_where_it_has_no_way_on():
    """Five scales under an end torque jump; where they come to rest is the same from any station, and work balances."""
    alpha, theta0, beta, lam = 1.0023893353051005, 0.1860129432296795, 0.45677318336543876, 0.7271372877703923
    h, nu = 0.015720034149947864, 0.2661120830416826
    K = law.stiffness(law.Shape(0.7164362981598352, lam, 0.40302813319816777, beta, h, alpha, theta0, nu))
    scale = path.Scale(3.9324313825525845, beta, lam, alpha, theta0, h, 0.02550241848432562, 0.35)
    way = path.Path.at_rest(scale, K, 0.07875827071371233, free=(1, 1, 1, 1), aside=2.6268748895657685)
    ends = []
    for points in (10, 12, 50):
        found = track(way, 5, np.linspace(0.0, 0.12, points + 1)[1:], ends=LOOSE)
        v, snap = path.named(found.rows), found.events[found.events[:, 0] == increments.SNAP][-1]
        assert found.end.code == increments.RANGE
        assert snap[1] == pytest.approx(0.108855, abs=1e-5)
        ends.append([v["torque"][-1, 0], v["energy"][-1].sum(), 100 * snap[12]])
        U, W, rubbed, lost = (v[name].sum(axis=1) for name in ("energy", "W", "W_fr", "W_snap"))
        # tolerance: what is asked for
        assert np.abs(W - U - rubbed - lost).max() < 1e-4 * U.max()
        assert lost[-1] > 0.01 * U.max()
    # tolerance: where the jump begins is told to 1e-6 rad per pitch
    np.testing.assert_allclose(ends[1:], ends[:1] * 2, rtol=1e-4)
