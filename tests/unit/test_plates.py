"""Contacts of the rigid plates: every feature pair by vectors, names, and what is no contact."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest

import squama
from oracle.plates import corners, first_contact, overlap
from oracle.vectors import FP, Design, cross, dot, scale, sub
from properties.designs import each, many, mirrored
from squama.model import plates
from squama.model.plates import CORNERS, EDGES, Plates, Touch, first_touch, gaps, name

SHAPE = (2.5, 0.8, 0.4, math.radians(35))


def plates_of(shape: tuple[float, ...], sense: int = 1) -> Plates:
    eta, beta, lam, alpha = shape
    return Plates(eta, beta, lam, sense * math.sin(alpha), math.cos(alpha))


def touch_at_rest(p: Plates, theta0: float, limit: float, follows: int = 0, *, mirrored: bool = False) -> Touch | None:
    """First contact while theta = theta0 and the twist grows to the limit."""
    x = limit * np.linspace(1e-4, 1.0, 80) ** 2
    return first_touch(p, lambda v: (theta0 + 0 * v, v), x, follows=follows, mirrored=mirrored)


@pytest.mark.parametrize("seed", range(12))
def test_gaps_of_edges_by_vectors(seed: int) -> None:
    """The gap of two edges is the distance of their lines, and counts where the common normal meets both."""
    r = np.random.default_rng(seed)
    eta, beta, lam, alpha = shape = (r.uniform(1, 6), r.uniform(0.3, 3), r.uniform(0.1, 1), r.uniform(0.05, 1.5))
    theta, phi, k = r.uniform(0.05, 1.6), r.uniform(0.02, 1.2), int(r.integers(1, 4))
    d = Design(eta, alpha, beta, lam, theta)
    gap, inside = gaps(plates_of(shape), np.array([theta]), np.array([phi]), np.array([k]))
    one, two = scale(FP, d, theta, phi, 0), scale(FP, d, theta, phi, k)
    for e, first in enumerate(EDGES):
        for f, second in enumerate(EDGES):
            (a0, a1), (b0, b1) = ([getattr(s, c) for c in names] for s, names in ((one, first), (two, second)))
            u, v = sub(a1, a0), sub(b1, b0)
            n = cross(u, v)
            distance = float(dot(sub(b0, a0), n)) / math.sqrt(dot(n, n))
            assert abs(gap[8 + 4 * e + f, 0, 0]) == pytest.approx(abs(distance), rel=1e-9)
            # feet of the common normal along both edges, 0 to 1, by Cramer's rule
            feet = [float(dot(cross(sub(b0, a0), z), n)) / float(dot(n, n)) for z in (v, u)]
            if min(abs(x - end) for x in feet for end in (0, 1)) > 1e-6:
                assert inside[8 + 4 * e + f, 0, 0] == all(0 <= x <= 1 for x in feet)


@pytest.mark.parametrize(("off", "counts"), [(0.0, True), (1e-12, True), (-1e-12, True), (1e-6, False)])
def test_places_at_the_very_ends_count(off: float, counts: bool) -> None:
    """To rounding: scale 2 laid end to end with scale 1, its corners D, A on C, B; `off` beyond in both directions."""
    wide = Plates(1.0, 1.0, 0.4, 0.0, 1.0)
    _, inside = gaps(wide, np.array([0.0]), np.array([0.0]), np.array([1]))
    touching = {i for i in range(24) if inside[i, 0, 0]}
    corner = [i for i in touching if i < 8]
    # D2, A2 on the face of scale 1 and C1, B1 on that of scale 2
    assert sorted(corner) == [0, 1, 6, 7]
    pairs = {(EDGES[(i - 8) // 4], EDGES[(i - 8) % 4]) for i in touching if i >= 8}
    crossing = {("CB", "DC"), ("CB", "AB"), ("DC", "DA"), ("AB", "DA")}
    assert pairs >= crossing
    assert not pairs & {("DA", "DC"), ("DA", "AB"), ("DC", "CB"), ("AB", "CB")}
    # laid on their backs the tip of scale 2 comes to lie at the base of scale 1
    _, inside = gaps(wide, np.array([np.pi]), np.array([0.0]), np.array([1]))
    back = {i for i in range(24) if inside[i, 0, 0]}
    assert sorted(i for i in back if i < 8) == [2, 3, 4, 5]
    assert {(EDGES[(i - 8) // 4], EDGES[(i - 8) % 4]) for i in back if i >= 8} >= {
        ("DA", "DC"),
        ("DA", "AB"),
        ("DC", "CB"),
        ("AB", "CB"),
    }
    # the pitch is 1: shorter scales lie apart, and longer ones one on the other
    _, inside = gaps(wide._replace(eta=1.0 - off), np.array([0.0]), np.array([0.0]), np.array([1]))
    assert [bool(inside[i, 0, 0]) for i in (0, 1, 6, 7)] == [counts] * 4
    at = {(EDGES[(i - 8) // 4], EDGES[(i - 8) % 4]): bool(inside[i, 0, 0]) for i in range(8, 24)}
    assert [at[p] for p in crossing] == [counts] * 4
    # turned a little sideways about its base corner the other scale leaves the width of scale 1
    askew = wide._replace(sa=off, ca=math.sqrt(1 - off * off), eta=3.0)
    _, inside = gaps(askew, np.array([0.0]), np.array([0.0]), np.array([1]))
    assert bool(inside[0, 0, 0])
    assert bool(inside[1, 0, 0]) == (counts or off < 0)
    assert bool(inside[8 + 4 * 2 + 0, 0, 0]) == (counts or off < 0)


def test_a_contact_is_found_if_its_place_counts_on_either_side() -> None:
    """In samples far apart, whatever came before: as long as the features are near each other at one of the two."""
    r = np.random.default_rng(5)
    shape = (6.0, 2.4, 1.2, 0.18)
    p, k, seen = plates_of(shape, -1), np.arange(1, 3), 0
    for _ in range(300):
        thetas, phis = r.uniform(0.1, 0.5, 3), r.uniform(0.02, 0.25, 3)

        def at(v, thetas=thetas, phis=phis):
            return np.interp(v, [0, 1, 2], thetas), np.interp(v, [0, 1, 2], phis)

        gap, inside = gaps(p, *at(np.array([0.0, 1.0, 2.0])), k)
        up = gap > 0
        last = (
            (up[..., 0] == up[..., 1]) & (up[..., 1] != up[..., 2]) & ~inside[..., 0] & inside[..., 1] & ~inside[..., 2]
        )
        for i, n in np.argwhere(last):
            fine = np.linspace(1, 2, 400)
            g, on = gaps(p, *at(fine), k[n : n + 1])
            change = np.flatnonzero((g[i, 0, :-1] > 0) != (g[i, 0, 1:] > 0))
            if len(change) != 1 or not (on[i, 0, change[0]] and on[i, 0, change[0] + 1]):
                continue
            seen += 1
            touch = first_touch(p, at, np.array([0.0, 1.0, 2.0]), follows=0)
            assert touch is not None
            assert touch.x <= fine[change[0] + 1]
    assert seen > 3


@pytest.mark.slow
@pytest.mark.parametrize("sense", [1, -1])
def test_touching_features_touch(sense: int) -> None:
    """At every first contact the two features have a point in common, and no plate has passed another before."""
    seen: dict[str, int] = {}
    for d in each(many(40, 31) if sense > 0 else mirrored(40, 32)):
        p = plates_of((d.eta, d.beta, d.lam, d.alpha), sense)
        touch = touch_at_rest(p, d.theta0, 1.4, 0, mirrored=sense < 0)
        path = np.column_stack([np.full(2500, d.theta0), np.linspace(0.0, 1.4, 2500)])
        want = first_contact(d.eta, d.beta, d.lam, sense * d.alpha, d.theta0, path, kmax=p.reach + 3)
        if want is None or touch is None:
            assert want is None, d
            assert touch is None, d
            continue
        assert (touch.k, touch.theta) == (want.k, d.theta0)
        assert touch.phi == pytest.approx(want.phi, abs=1e-9)
        kind = "face" if "face" in touch.pair else "edge"
        assert kind in want.pair[0]
        seen[kind] = seen.get(kind, 0) + 1
        # just beyond the plates cut each other, just before they do not
        for phi, cut in ((touch.phi * (1 - 1e-7), False), (touch.phi * (1 + 1e-7), True)):
            q = np.array([phi])
            t = np.array([d.theta0])
            pair = (corners(d.eta, d.beta, d.lam, sense * d.alpha, t, q, j) for j in (0, touch.k))
            assert (overlap(*pair)[0][0] > 0) == cut
    assert sum(seen.values()) > 10


@pytest.mark.parametrize(
    ("shape", "theta0", "sense"),
    [
        ((5.252670910536459, 1.0211806268030195, 1.611473250802064, 0.1127690148383984), 0.49469531565849817, 1),
        ((7.0, 3.0, 1.5, 1.0840517779857866), 0.3125, -1),
        ((6.5, 0.9, 0.6, 0.3), 0.2, -1),
    ],
)
def test_parallel_plates_are_no_contact(shape: tuple[float, ...], theta0: float, sense: int) -> None:
    """At k phi = 2 pi scale 1 + k is parallel to scale 1: all gaps of their edges vanish, k pitches apart."""
    p = plates_of(shape, sense)
    path = np.column_stack([np.full(2500, theta0), np.linspace(0.0, 1.4, 2500)])
    want = first_contact(*shape[:3], sense * shape[3], theta0, path)
    touch = touch_at_rest(p, theta0, 1.4, 0, mirrored=sense < 0)
    assert (touch is None) == (want is None)
    if want is not None:
        assert touch is not None
        assert (touch.k, touch.phi) == (want.k, pytest.approx(want.phi, abs=1e-9))
    for k in range(5, p.reach + 1):
        turn = 2 * math.pi / k
        found = first_touch(
            p, lambda v: (theta0 + 0 * v, v), turn + np.linspace(-0.011, 0.01, 8), follows=0, mirrored=False
        )
        assert found is None or abs(found.phi - turn) > 1e-9


def test_the_followed_contact_is_not_another_one() -> None:
    p = plates_of((3.0, 1.25, 0.45, math.radians(45)))
    theta0 = math.radians(10)
    phi_e = float(squama.ends(eta=3, beta=1.25, lam=0.45, alpha=math.radians(45), theta0=theta0, mu=0).phi_e)
    # followed: nothing else touches before; not followed: the tip-side pair itself is found, at phi_e
    assert touch_at_rest(p, theta0, 1.2 * phi_e, 1, mirrored=False) is None
    touch = touch_at_rest(p, theta0, 1.2 * phi_e, 0, mirrored=False)
    assert touch is not None
    assert touch.pair == "tip edge C1B1 on side edge D2C2"
    assert touch.phi == pytest.approx(phi_e, rel=1e-12)
    assert (touch.k, touch.x) == (1, pytest.approx(phi_e, rel=1e-12))
    plain = first_touch(p, lambda v: (theta0 + 0 * v, v), phi_e * np.array([0.5, 0.9, 1.1]), follows=0)
    assert plain is not None
    assert plain.pair == touch.pair
    # that is the pair whose sign changes at engagement
    gap, _ = gaps(p, np.array([theta0, theta0]), phi_e * np.array([1 - 1e-9, 1 + 1e-9]), np.array([1]))
    changed = np.flatnonzero((gap[:, 0, 0] > 0) != (gap[:, 0, 1] > 0))
    assert changed.tolist() == [plates.TIP_SIDE]


def test_a_contact_that_comes_and_goes_between_samples_counts_by_its_place() -> None:
    """The earliest of several contacts is told, whatever the order of the features."""
    p = plates_of((3.0, 1.25, 0.45, math.radians(45)), -1)
    at = math.radians(10)
    x = np.linspace(1e-6, 1.3, 200)
    first = first_touch(p, lambda v: (at + 0 * v, v), x, follows=0, mirrored=True)
    assert first is not None
    assert first.phi == pytest.approx(0.38669098800552676, abs=1e-12)
    assert first.pair == "side edge A1B1 on base edge D2A2"
    # in a finer and a coarser scan, and from a later start
    for n in (12, 80, 999):
        again = first_touch(p, lambda v: (at + 0 * v, v), np.linspace(1e-6, 1.3, n), follows=0, mirrored=True)
        assert again == (first.k, first.pair, *(pytest.approx(v, rel=1e-13) for v in first[2:]))
    coarse = (
        ((6.026718675744778, 2.375364185127844, 1.9992554565612126, 0.1820765639724717), 0.20936287462600878),
        ((1.4826618070458109, 0.9369576943166595, 0.39007009009485516, 0.027872221428383838), 0.04372994971466562),
        ((2.908905093871831, 1.3884303894270544, 0.6771980698952634, 0.06988980688397095), 0.07328393902458577),
    )
    for shape, theta0 in coarse:
        q = plates_of(shape, -1)
        few, most = (
            first_touch(
                q, lambda v, t=theta0: (t + 0 * v, v), 1.4 * np.linspace(1e-3, 1, n) ** 2, follows=0, mirrored=True
            )
            for n in (12, 500)
        )
        assert few is not None
        assert most is not None
        assert (few.k, few.pair) == (most.k, most.pair)
        assert few.phi == pytest.approx(most.phi, rel=1e-13)
    later = first_touch(p, lambda v: (at + 0 * v, v), np.linspace(0.39, 1.3, 200), follows=0, mirrored=True)
    assert later is None or later.phi > first.phi


def test_names_in_both_senses() -> None:
    assert name(plates.TIP_SIDE, 2, mirrored=False) == "tip edge C1B1 on side edge D3C3"
    assert name(plates.TIP_SIDE, 2, mirrored=True) == "tip edge C1B1 on side edge A3B3"
    for pair in range(24):
        for mirrored_ in (False, True):
            words = name(pair, 1, mirrored=mirrored_)
            letters = re.findall(r"([ABCD])[12]", words)
            swapped = [c.translate(str.maketrans("ABCD", "DCBA")) for c in letters]
            other = re.findall(r"([ABCD])[12]", name(pair, 1, mirrored=not mirrored_))
            assert sorted(swapped) == sorted(other)
    assert len({name(pair, 1, mirrored=False) for pair in range(24)}) == 24
    assert [name(i, 3, mirrored=False) for i in (0, 7)] == [
        "corner D4 on the face of scale 1",
        "corner B1 on the face of scale 4",
    ]
    assert set(CORNERS) == set("ABCD")


@pytest.mark.parametrize(("eta", "beta", "reach"), [(0.5, 0.1, 1), (3.0, 1.25, 3), (3.0, 2.0, 5), (8.0, 3.0, 10)])
def test_reach_is_the_diagonal(eta: float, beta: float, reach: int) -> None:
    assert Plates(eta, beta, 0.4, 0.5, 0.8).reach == reach


def test_contacts_between_edges_in_the_other_sense_name_the_mirrored_side() -> None:
    """Twisted the other way the tip edge rests on the side edge A-B, whoever reports it."""
    e = squama.ends(eta=2.2708, beta=1.9135, lam=1.3147, alpha=0.0141, theta0=0.0295, mu=0.3363, sense="-")
    assert (str(e.end), int(e.neighbour)) == ("other contact", 2)
    assert str(e.other) == "tip edge C1B1 on side edge A2B2 (k = 1)"
