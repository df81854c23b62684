"""Boxes: how far two are apart, and what touches first, against the faces that meet where they touch."""

import numpy as np
import pytest
from scipy.optimize import linprog
from scipy.spatial.transform import Rotation

from squama.model import boxes

HALF = (1.4, 0.6, 0.2)
LETTERS = {(-1, -1): "D", (-1, 1): "A", (1, 1): "B", (1, -1): "C"}


def touching(way: np.ndarray, M: np.ndarray) -> tuple[float, list[np.ndarray]]:
    """How far along a way from the middle of box 1 the other one's just touches it, and the sides that meet."""
    h, rows, bounds, first = np.array(HALF), [], [], np.array([HALF[0], 0, 0])
    for axes, moved in ((np.eye(3), np.zeros(3)), (M, way)):
        for sign in (1, -1):
            rows += [[*(sign * axes[:, i]), -sign * axes[:, i] @ moved] for i in range(3)]
            bounds += list(h + sign * axes.T @ first)
    found = linprog([0, 0, 0, -1], A_ub=rows, b_ub=bounds, bounds=[(None, None)] * 4)
    assert found.status == 0
    met = (found.slack < 1e-9).reshape(2, 2, 3)
    return found.x[3], [side[0].astype(int) - side[1] for side in met]


def words(at: np.ndarray, scale: int, mirrored: bool) -> str:
    """A corner, edge or face of a box by its sides."""
    x, y, z = at
    y = -y if mirrored else y
    level = {1: "upper", -1: "lower", 0: ""}[z]
    count = np.count_nonzero(at)
    if count == 3:
        return f"{level} corner {LETTERS[x, y]}{scale}"
    if count == 1:
        face = level or ("side" if y else {1: "tip", -1: "base"}[x])
        return f"the {face} face of scale {scale}"
    if not z:
        return f"upright edge {LETTERS[x, y]}{scale}"
    if not x:
        return f"{level} side edge {LETTERS[-1, y]}{scale}{LETTERS[1, y]}{scale}"
    ends = (1, -1) if mirrored else (-1, 1)
    return f"{level} {'tip' if x > 0 else 'base'} edge " + "".join(f"{LETTERS[x, e]}{scale}" for e in ends)


@pytest.mark.parametrize("mirrored", [False, True])
def test_what_touches_first_is_named(mirrored: bool) -> None:
    r, kinds = np.random.default_rng(3), set()
    for _ in range(150):
        M = Rotation.random(random_state=r).as_matrix()
        way = r.normal(size=3)
        share, sides = touching(way, M)
        o = np.array([HALF[0], 0, 0]) + share * way - HALF[0] * M[:, 0]
        gap = boxes.gaps(HALF, o, M)
        assert abs(gap[0]) < 1e-9
        np.testing.assert_array_equal(gap[1:], [M[2, 0], M[0, 0], M[1, 2], M[1, 1]])
        one, two = (words(at, scale, mirrored) for at, scale in zip(sides, (1, 3), strict=True))
        pair = f"{two} on {one}" if "face" in one else f"{one} on {two}"
        assert boxes.name(HALF, o, M, 0, 2, mirrored) == pair
        kinds.add(pair.split(" on ", maxsplit=1)[0].split()[1])
    assert kinds == {"corner", "side", "tip", "base", "edge"}


def test_boxes_apart_and_in_each_other() -> None:
    M, o = np.eye(3), np.array([0.1, 0.3, 0.5])
    assert boxes.directions(HALF, o, M).max() == pytest.approx(0.5 - 0.4)
    assert boxes.directions(HALF, o - [0, 0, 0.3], M).max() == pytest.approx(0.2 - 0.4)
    # parallel axes have no direction of their own
    assert np.isneginf(boxes.directions(HALF, o, M)[6:]).sum() == 3


def test_an_edge_flat_on_a_face_is_named() -> None:
    M, o = np.eye(3), np.zeros(3)
    side, tip = "upper side edge D2C2", "lower tip edge C1B1"
    flat = [f"{side} on the lower face of scale 1", f"{side} on the tip face of scale 1"]
    flat += [f"{tip} on the upper face of scale 2", f"{tip} on the side face of scale 2"]
    assert [boxes.name(HALF, o, M, pair, 1, False) for pair in (1, 2, 3, 4)] == flat
    assert boxes.name(HALF, o, M, 1, 1, True) == "upper side edge A2B2 on the lower face of scale 1"


def test_the_pair_that_is_followed_is_no_other_contact() -> None:
    gap = np.arange(-20.0, 10.0).reshape(5, 2, 3)
    closed = np.array([False, True, True])
    left = gap.copy()
    boxes.leave_out(left, 2, closed)
    # of other neighbours only the distance counts
    np.testing.assert_array_equal(left[0, 0], gap[0, 0])
    assert (left[1:, 0] == 1).all()
    np.testing.assert_array_equal(left[0, 1], [gap[0, 1, 0], 1, 1])
    np.testing.assert_array_equal(left[1:, 1, 0], 1)
    np.testing.assert_array_equal(left[1:, 1, 1:], gap[1:, 1, 1:])
    free = gap.copy()
    boxes.leave_out(free, 0, closed)
    np.testing.assert_array_equal(free[0], gap[0])
    assert (free[1:] == 1).all()
