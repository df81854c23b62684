"""Engagement and end against dense scans by plain vectors: nothing happens earlier, and something does happen there."""

from __future__ import annotations

from collections import Counter
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq

from oracle.path import others
from oracle.twisting import condition, drive, places, tangent
from oracle.vectors import FP, Design
from properties.designs import Drawn, Followed, each, follow, many, mirrored
from squama.model.paths import ARRAY, FoldedTwist

GROUPS = {("+", "edge"): many(150, 21), ("+", "plate"): many(100, 22), ("-", "edge"): mirrored(100, 23)}
SAMPLES = 1200
both = pytest.mark.parametrize(("sense", "law"), list(GROUPS))


def room(d: Design, theta: Any, phi: Any) -> Any:
    """Least distance of the contact to the ends of its two edges; negative beyond."""
    p, s = places(np, d, theta, phi)
    return np.minimum.reduce([d.beta - abs(p), s, d.eta - s])


def engagement(d: Drawn, sense: str) -> tuple[int, float, float]:
    """(k, phi_e, room) of the first contact at theta0, from a scan of the twist; 0 and inf where there is none."""
    best, nearest = (0, np.inf), np.inf
    rigid = d.rigid(sense)
    for k in others(rigid):
        dk = rigid.with_k(k)
        grid = np.linspace(0.0, np.pi / k, 1500)
        apart = condition(np, dk, d.theta0 + 0 * grid, grid) < 0
        i = int(np.argmin(apart))
        if apart.all():
            continue
        phi = brentq(lambda q, dk=dk: condition(FP, dk, d.theta0, q), grid[i - 1], grid[i], xtol=1e-16, rtol=1e-13)
        left = float(room(dk, d.theta0, phi))
        nearest = min(nearest, abs(left))
        if left >= 0 and phi < best[1]:
            best = k, phi
    return *best, nearest


@pytest.mark.slow(but=1)
@both
def test_engagement_is_the_first_contact(sense: str, law: str) -> None:
    seen: Counter[int] = Counter()
    for d in each(GROUPS[sense, law]):
        k, phi, nearest = engagement(d, sense)
        if nearest < 1e-9:
            continue
        f = follow(d, law, sense)
        assert (0 if f is None else f.k) == k
        seen[k] += 1
        if f is not None:
            assert f.load_e == pytest.approx(phi, rel=1e-10)
    assert seen[1] > 30
    assert seen[0] > 3
    if sense == "-":
        assert len(seen) > 4


def scan(f: Followed, d: Drawn, sense: str, law: str, samples: int = SAMPLES) -> dict[str, np.ndarray]:
    """Quantities that are positive before the ends they are named after, along a path, by vectors."""
    w = np.linspace(0.0, 1.0, samples)
    pt = f.row.point(f.x0 + w * (f.x_end - f.x0), law, ARRAY)
    theta, phi = pt.theta + 0 * w, pt.load
    rigid = d.rigid(sense, f.k)
    # the package's points lie on the contact curve, one after the other, from engagement on
    assert float(np.abs(condition(np, rigid, theta, phi)).max()) < 1e-12 * (1 + d.eta)
    assert np.all(np.diff(phi) > -1e-12)
    assert phi[0] == pytest.approx(f.load_e, rel=1e-12)
    d_theta, d_phi = tangent(np, rigid, theta, phi)
    size = np.hypot(d_theta, d_phi)
    assert np.all(d_theta[1:-1] * np.diff(theta)[1:] >= -1e-9 * size[1:-1])
    p, s = places(np, rigid, theta, phi)
    out = {
        "kinematic lock": d_phi / size,
        "off tip edge": d.beta - abs(p),
        "off side edge": np.minimum(s, d.eta - s),
        "released": theta - d.theta0 if isinstance(f.row, FoldedTwist) else 1 + w,
        "range end": np.minimum(np.pi / f.k - phi, np.radians(179) - theta),
    }
    if d.mu > 0 or law == "plate":
        out["frictional lock"] = drive(np, rigid, theta, phi, law, d.mu)
    return out


def others_come_in(f: Followed, d: Drawn, sense: str, law: str, samples: int = SAMPLES) -> list[tuple[int, float]]:
    """Other neighbours whose tip-side contact comes in on the path, with the fraction of the path."""
    w = np.linspace(0.0, 1.0, samples)
    pt = f.row.point(f.x0 + w * (f.x_end - f.x0), law, ARRAY)
    theta, phi = pt.theta + 0 * w, pt.load
    found = []
    for j in others(d.rigid(sense)):
        dj = d.rigid(sense, j)
        if j == f.k:
            continue
        apart = condition(np, dj, theta, phi) < 0
        for i in np.flatnonzero(apart[:-1] & ~apart[1:]):
            on = room(dj, theta[i : i + 2], phi[i : i + 2])
            if np.all(on > 1e-9):
                found.append((j, float(w[i + 1])))
    return found


def early_ends(d: Drawn, sense: str, law: str, samples: int) -> list[str]:
    """Margins that vanish, and neighbours that come in, before the end that the package found."""
    f = follow(d, law, sense)
    if f is None or not f.x_end > f.x0:
        return []
    early = []
    for name, values in scan(f, d, sense, law, samples).items():
        # the path starts at theta0, and ends where it ends
        start = 2 if name == "released" else 0
        if not values[start:-2].min() > 0:
            early.append(name)
    return early + [f"neighbour {j}" for j, w in others_come_in(f, d, sense, law, samples) if w < 1 - 2 / samples]


@pytest.mark.slow(but=1)
@both
def test_nothing_ends_the_path_earlier(sense: str, law: str) -> None:
    seen: Counter[str] = Counter()
    for d in each(GROUPS[sense, law]):
        f = follow(d, law, sense)
        if f is None:
            continue
        seen[f.end] += 1
        if f.end == "static lock":
            assert drive(FP, d.rigid(sense, f.k), d.theta0, f.load_e, law, d.mu) <= 0
            continue
        assert f.x_end > f.x0
        margins = scan(f, d, sense, law)
        for name, values in margins.items():
            # the path starts at theta0, and ends where it ends
            start = 2 if name == "released" else 0
            assert values[start:-2].min() > 0, (d, name, f.end)
        early = [j for j, w in others_come_in(f, d, sense, law) if w < 1 - 2 / SAMPLES]
        assert not early, (d, early)
        if f.end == "other contact":
            assert f.crossing not in (0, f.k)
            other = d.rigid(sense, f.crossing)
            assert abs(condition(FP, other, f.theta_end, f.load_end)) < 1e-12 * (1 + d.eta)
            assert float(room(other, f.theta_end, f.load_end)) > -1e-12
            continue
        last = margins[f.end]
        assert abs(last[-1]) < 1e-7 * max(1.0, float(np.abs(last).max())), (d, f.end)
    assert seen["frictional lock"] > 3
    if sense == "+":
        assert seen["off tip edge"] > 5
        assert seen["other contact"] > 3
    assert len(seen) > 4
