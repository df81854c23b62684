"""The path of the contact, and where it ends: traced in doubles by small steps, polished to 30 digits."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .twisting import condition, drive, gradient, phi, places, tangent
from .vectors import FP, MP, Ctx, Design, Num

Event = Callable[[Ctx, Num, Num], Num]


@dataclass(frozen=True)
class Neighbour:
    """Another tip-side pair, with scale 1 + k, that comes in before the end."""

    k: int
    theta: Num
    phi: Num


@dataclass(frozen=True)
class End:
    """How a path ends. `theta_f` is the fold it went through, or None.

    kind: none (never engages), friction, kinematic, edge-tip, edge-side, return (theta is back at theta0),
    half-turn (k phi = pi).
    """

    kind: str
    k: int
    theta: Num
    phi: Num
    phi_e: Num
    theta_f: Num | None = None
    phi_f: Num | None = None
    neighbour: Neighbour | None = None


def others(d: Design) -> list[int]:
    """Neighbours that can be reached: no corner is farther than hypot(eta, beta) from its base."""
    return [1] + [k for k in range(2, 40) if k < 2 * (d.eta**2 + d.beta**2) ** 0.5]


def engagement(d: Design) -> tuple[int, Num] | None:
    """(k, phi_e) of the tip-side pair that comes first at theta0, or None where none does."""
    best = None
    for k in others(d):
        dk = d.with_k(k)
        q = phi(d.theta0, dk)
        if q is None or k * q > MP.pi or not _on_edges(dk, *places(MP, dk, d.theta0, q)):
            continue
        if best is None or q < best[1]:
            best = (k, q)
    return best


def _on_edges(d: Design, p: Num, s: Num) -> bool:
    return bool(abs(p) <= d.beta and 0 <= s <= d.eta)


def correct(d: Design, theta: float, q: float) -> tuple[float, float]:
    """Drop a point onto F = 0 along the gradient."""
    for _ in range(4):
        f = condition(FP, d, theta, q)
        ft, fq = gradient(FP, d, theta, q)
        g = f / (ft * ft + fq * fq)
        theta, q = theta - g * ft, q - g * fq
        if abs(g) < 1e-14:
            break
    return theta, q


def trace(d: Design, phi_e: Num, step: float = 0.004) -> NDArray[np.float64]:
    """Points (theta, phi) from engagement to just past the first end that geometry alone sets."""
    d = d.floats()
    t, q = correct(d, d.theta0, float(phi_e))
    points = [(t, q)]
    while len(points) * step < 12:
        dt, dq = tangent(FP, d, t, q)
        if dq <= 0 and len(points) > 1:
            break
        h = step / float(np.hypot(dt, dq))
        t, q = correct(d, t + h * dt, q + h * dq)
        points.append((t, q))
        if not _on_edges(d, *places(FP, d, t, q)) or t < d.theta0 or d.k * q > np.pi:
            break
    return np.array(points)


def geometry_events(d: Design) -> dict[str, Event]:
    """Functions that are positive before, and negative after, each end that geometry sets."""

    def p_s(ctx: Ctx, t: Num, q: Num) -> tuple[Num, Num]:
        return places(ctx, d, t, q)

    return {
        "edge-tip": lambda c, t, q: d.beta - p_s(c, t, q)[0],
        "edge-tip-": lambda c, t, q: d.beta + p_s(c, t, q)[0],
        "edge-side": lambda c, t, q: d.eta - p_s(c, t, q)[1],
        "edge-side-": lambda c, t, q: p_s(c, t, q)[1],
        "kinematic": lambda c, t, q: tangent(c, d, t, q)[1],
        "return": lambda c, t, q: t - d.theta0 + 0 * q,
        "half-turn": lambda c, t, q: c.pi / d.k - q + 0 * t,
    }


def _crossing(d: Design, event: Event, points: NDArray[np.float64], start: int) -> float | None:
    """Place (fractional index) of the first change of sign from + to -, by bisection between samples."""
    values = event(np, points[:, 0], points[:, 1])
    bad = np.flatnonzero((values[:-1] > 0) & (values[1:] <= 0))
    bad = bad[bad >= start]
    if not len(bad):
        return None
    i, lo, hi = int(bad[0]), 0.0, 1.0
    for _ in range(36):
        mid = 0.5 * (lo + hi)
        if event(FP, *_between(d, points, i + mid)) > 0:
            lo = mid
        else:
            hi = mid
    return i + 0.5 * (lo + hi)


def _between(d: Design, points: NDArray[np.float64], x: float) -> tuple[float, float]:
    i = min(int(x), len(points) - 2)
    t, q = points[i] + (x - i) * (points[i + 1] - points[i])
    return correct(d, float(t), float(q))


def polish(d: Design, event: Event, start: tuple[float, float]) -> tuple[Any, Any]:
    """Newton on F = 0 and event = 0 together, to 30 digits."""
    t, q = MP.mpf(start[0]), MP.mpf(start[1])
    h = MP.mpf(2) ** -50
    for _ in range(12):
        f, e = condition(MP, d, t, q), event(MP, t, q)
        ft, fq = gradient(MP, d, t, q)
        et = (event(MP, t + h, q) - event(MP, t - h, q)) / (2 * h)
        eq = (event(MP, t, q + h) - event(MP, t, q - h)) / (2 * h)
        det = ft * eq - fq * et
        dt, dq = (f * eq - fq * e) / det, (ft * e - f * et) / det
        t, q = t - dt, q - dq
        if abs(dt) + abs(dq) < 1e-26:
            break
    return t, q


def fold(d: Design, points: NDArray[np.float64]) -> tuple[float, tuple[Any, Any]] | None:
    """Place of the fold on the traced path and (theta_f, phi_f) to 30 digits, or None."""
    df = d.floats()
    x = _crossing(df, lambda c, t, q: tangent(c, df, t, q)[0], points, 0)
    if x is None:
        return None
    return x, polish(d, lambda c, t, q: tangent(c, d, t, q)[0], _between(df, points, x))


def path_end(design: Design, mu: Num, law: str, *, digits: bool = True) -> End:
    """Follow the first tip-side pair to the first of its ends; `digits` False leaves it in doubles."""
    first = engagement(design)
    if first is None:
        return End("none", 0, design.theta0, MP.inf, MP.inf)
    k, phi_e = first
    d = design.with_k(k)
    df = d.floats()
    if drive(MP, d, d.theta0, phi_e, law, mu) <= 0:
        return End("friction", k, d.theta0, phi_e, phi_e)
    if tangent(MP, d, d.theta0, phi_e)[1] <= 0:
        return End("kinematic", k, d.theta0, phi_e, phi_e)
    points = trace(d, phi_e)
    if len(points) < 2:
        msg = f"no path traced for {df}"
        raise RuntimeError(msg)
    coarse, exact = geometry_events(df), geometry_events(d)
    if mu > 0:
        mf = float(mu)
        coarse["friction"] = lambda c, t, q: drive(c, df, t, q, law, mf)
        exact["friction"] = lambda c, t, q: drive(c, d, t, q, law, mu)
    elif law == "plate":
        coarse["friction"] = lambda c, t, q: drive(c, df, t, q, law, 0.0)
        exact["friction"] = lambda c, t, q: drive(c, d, t, q, law, 0)
    found = {name: _crossing(df, e, points, 1 if name == "return" else 0) for name, e in coarse.items()}
    hits = {name: x for name, x in found.items() if x is not None}
    if not hits:
        msg = f"no end found for {df}"
        raise RuntimeError(msg)
    name = min(hits, key=lambda n: hits[n])
    x_end = hits[name]
    rough = _between(df, points, x_end)
    theta, q = polish(d, exact[name], rough) if digits else rough
    turned = fold(d, points)
    theta_f, phi_f = turned[1] if turned is not None and turned[0] < x_end else (None, None)
    near = _neighbour(d, points, x_end)
    return End(name.rstrip("-"), k, theta, q, phi_e, theta_f, phi_f, near)


def _neighbour(d: Design, points: NDArray[np.float64], x_end: float) -> Neighbour | None:
    """First other tip-side pair whose edges come to touch before the end."""
    best: tuple[float, Neighbour] | None = None
    df = d.floats()
    for j in others(d):
        if j == d.k:
            continue
        dj, djf = d.with_k(j), df.with_k(j)
        values = -condition(np, djf, points[:, 0], points[:, 1])
        for i in np.flatnonzero((values[:-1] > 0) & (values[1:] <= 0)):
            x = _crossing(df, lambda c, t, q, w=djf: -condition(c, w, t, q), points, int(i))
            if x is None or x > x_end or (best is not None and x > best[0]):
                continue
            t, q = polish(d, lambda c, t, q, w=dj: -condition(c, w, t, q), _between(df, points, x))
            if _on_edges(dj, *places(MP, dj, t, q)):
                best = (x, Neighbour(j, t, q))
                break
    return best[1] if best else None


def rigid_path(design: Design, phi_max: float = 1.5, n: int = 800) -> NDArray[np.float64]:
    """Points (theta, phi) for `plates.first_contact`: theta0 up to engagement, then the contact curve to its
    geometric end; theta0 up to `phi_max` where no tip-side pair engages.
    """
    f = design.floats()
    first = engagement(design)
    top = phi_max if first is None else float(first[1])
    approach = np.linspace(0.0, top, n)
    rest = np.column_stack([0 * approach + f.theta0, approach])
    if first is None:
        return rest
    points = trace(design.with_k(first[0]), first[1])
    return np.concatenate([rest, points[1:-1]])
