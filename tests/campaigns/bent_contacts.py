"""Random beams on compliant joints, bent and twisted along polygons: all contacts against the barrier of elements.

Beams as those of :mod:`histories`. Ends before the last corner, and what the barrier does not follow, are counted.
"""

from __future__ import annotations

import collections

import numpy as np
from histories import Given, drawn

from legs import Bent, follow_legs
from oracle.barrier import surface
from squama.contacts import path, states
from squama.fe.assembly import make_bent
from squama.fe.geometry import Geometry
from squama.model.outcome import End
from squama.types import Array

TRIALS, SIZE = 20, 10
FAR = (0.12, 0.15)
"""Largest bend and twist per pitch."""
SAME, LOST, INCREMENT = 0.02, 5e-3, 2e-3
"""Difference of moment or torque over both together; work that is lost, over the largest energy; increments."""


def polygon(r: np.random.Generator) -> Array:
    """Return the corners of a path."""
    psi, phi = r.uniform(0.3, 1.0) * FAR[0], r.uniform(-0.7, 1.0) * FAR[1]
    kinds = (
        [(psi, phi)], [(psi, 0), (psi, phi)], [(0, phi), (psi, phi)], [(psi, 0), (psi, -abs(phi)), (psi, abs(phi))],
        [(0, abs(phi)), (psi, abs(phi)), (-psi, abs(phi)), (psi, abs(phi))],
    )  # fmt: skip
    return np.array(kinds[r.integers(len(kinds))], float)


def along(corners: Array, n: int = 120) -> Array:
    """Return places of a path, so many on each way."""
    start = np.zeros(2)
    found = []
    for end in corners:
        found += [start + (end - start) * w for w in np.arange(1, n + 1) / n]
        start = end
    return np.array(found)


def lost(found: Bent, corners: Array) -> float:
    """Return the work that is neither stored nor rubbed away, over the largest energy."""
    x = np.concatenate([np.zeros((1, 2)), along(corners)])
    U = sum(states.energies(found.way, found.rows).values())
    loads = np.concatenate([np.zeros((1, 2)), np.column_stack([found.M, found.T])])
    work = ((loads[1:] + loads[:-1]) / 2 * np.diff(x, axis=0)).sum()
    gone = found.column("W_fr")[-1] + found.column("W_snap")[-1]
    return float(abs(work - U[-1] - gone) / np.nanmax(U))


def wrong(given: Given, corners: Array) -> tuple[str, list[str], float]:
    """Return how a path ends, what is wrong with it, and the larger difference to the barrier."""
    s = given.scale._replace(alpha=given.sense * given.scale.alpha)
    found = follow_legs(s, given.K, given.mu, along(corners))
    (end,) = path.endings(found.answers.contacts, found.answers.ends)
    if end not in (End.RANGE, End.NONE):
        return str(end), [], np.nan
    told = [f"loses {w:.1e} of its work"] if (w := lost(found, corners)) > LOST else []
    shape = Geometry(np.nan, s.lam, np.nan, s.eta, s.beta, s.h, s.alpha, s.theta0, np.nan)
    led = make_bent(given.K, shape, given.mu, exposed=surface(s))
    if not all(led.run(led.aim(*corner), INCREMENT).reached for corner in corners):
        return "not by the barrier", told, np.nan
    own, other = np.array([found.M[-1], found.T[-1]]), np.array([led.columns[name][-1] for name in "MT"])
    off = float(np.abs(own - other).max() / np.hypot(*other))
    return str(end), told + ([f"is {off:.2%} off"] if off > SAME else []), off


def trial(seed: int, size: int = SIZE) -> list[str]:
    """Try paths; the line for a failure names the trial and its number."""
    r, counts, failed, offs = np.random.default_rng([17, seed]), collections.Counter[str](), [], []
    for i in range(size):
        given, corners = drawn(r), polygon(r)
        end, told, off = wrong(given, corners)
        counts[end] += 1
        offs.append(off)
        failed += [f"trial {seed}, path {i} (mu {given.mu:.3g}, {corners.round(3).tolist()}): {what}" for what in told]
    ends = ", ".join(f"{n} {end}" for end, n in counts.most_common())
    print(
        f"bent contacts, {seed}: {ends}; differences {np.nanmedian(offs):.2%}, at most {np.nanmax(offs):.2%}",
        flush=True,
    )
    return failed
